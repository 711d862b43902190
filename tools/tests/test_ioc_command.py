# SPDX-License-Identifier: MIT
"""`pixstep ioc` as a command: names, mistakes, its end; the files beside its document."""

import functools
import json
import re
import signal
import xml.etree.ElementTree as ElementTree

import pytest

from effort import cases
from ideal_ioc import ideal
from iocbench import free_port, loopback, until
from iocprocess import MACHINE, Command
from pixstep import natives
from pixstep.ioc import common
from pixstep.operations import ioc


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Go to a folder with a machine file."""
    (tmp_path / "machine.toml").write_text(MACHINE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


SIGNALS = [(signal.SIGINT, 0), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]


@pytest.mark.parametrize(("number", "status"), cases(SIGNALS[:2], SIGNALS))
def test_a_signal_stops_the_motors_and_keeps_where_they_are(folder, number, status):
    command = Command(folder)
    wire = command.wire()
    check_fields(wire)
    wire.begin("T:m1.VAL", 90.0)
    until(lambda: wire.value("T:m1.RBV") > 1)
    assert command.end(number) == status
    text = command.log.read_text()
    assert "Traceback" not in text
    assert command.events("ended")
    steps = int((folder / "m1.edges").read_text().split()[-1])
    kept = json.loads((folder / "machine.ioc.json").read_text())["motors"]["T:m1"]
    assert kept["fields"]["DVAL"] == pytest.approx(steps / 400)
    assert (kept["moving"], 400 < steps < 36_000) == (False, True)


def check_fields(wire):
    """Assert that fields are those of the machine file."""
    found = {
        name: wire.value(f"T:m1.{name}")
        for name in ("EGU", "MRES", "VMAX", "ACCL", "BDST", "DHLM", "DIR", "OUT", "PREC")
    }
    assert found == {
        "EGU": "mm", "MRES": 0.0025, "VMAX": 5.0, "ACCL": 0.1, "BDST": 0.02, "DHLM": 100.0,
        "DIR": 0, "OUT": "@pixstep(main,0)", "PREC": 4,
    }  # fmt: skip
    assert (wire.value("T:second.DIR"), wire.value("T:second.EGU")) == (1, "steps")


def test_the_list_has_every_pv(folder, pixstep):
    found = pixstep("ioc", "--list", "--prefix", "X:").split()
    assert found == common.all_names("X:", ["X:m1", "X:second"])
    assert json.loads(pixstep("ioc", "--list", "--json"))["records"] == {
        "m1": "T:m1", "m2": "T:second"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words", "said", "status"),
    [
        (("", ""), (), r"machine\.toml: board main has no port: --port PORT, or port in", 2),
        (("", ""), ("--machine", "none"), "no machine file: --machine FILE", 2),
        (("", ""), ("--port", "/dev/nothing"), "/dev/nothing: there is no such port", 2),
        (("", ""), ("--list", "--prefix", "A B:"), "no record can have the name 'A B:m1'", 2),
        (("DHLM = 100", "DHL = 1"), ("--list",), r"toml:\d+: .*fields\.DHL = 1: .* no such", 3),
        (("DHLM = 100", "RBV = 1"), ("--list",), r"toml:\d+: .*RBV = 1: only the record", 3),
        (("DHLM = 100", "MRES = 0"), ("--list",), r"toml:\d+: .*MRES = 0: a step has a size", 3),
        (("DHLM = 100", "PREC = 99"), ("--list",), r"toml:\d+: .*PREC = 99: 0 to 15 digits", 3),
        (("DHLM = 100", "DHLM = -101"), ("--list",), r"DLLM = -100: above DHLM = -101", 3),
        (("DHLM = 100", 'DIR = "X"'), ("--list",), r"DIR = 'X': a number, or one of Pos", 3),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(folder, invoke, change, words, said, status):
    (folder / "machine.toml").write_text(MACHINE.replace(*change) if change[0] else MACHINE)
    done = invoke("ioc", *words, status=status)
    assert re.search(said, done.stderr), done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "says"),
    [("a b", "no record can have the name 'a b'"), ("m1", "motor m1 has the record m1 already")],
)
def test_a_name_that_no_record_can_have_is_found_before_it_is_served(folder, invoke, name, says):
    (folder / "machine.toml").write_text(MACHINE.replace('"second"', f'"{name}"'))
    for words in (("machine", "check"), ("ioc", "--list")):
        done = invoke(*words, status=3)
        assert says in done.output


@pytest.mark.parametrize("field", ["HOMF", "HOMR", "JOGF", "JOGR", "TWF", "TWR", "RLV"])
def test_a_button_in_a_machine_file_is_refused(folder, invoke, field):
    """It would move the motor whenever the records begin."""
    (folder / "machine.toml").write_text(MACHINE.replace("DHLM = 100", f"{field} = 1"))
    done = invoke("ioc", "--list", status=3)
    assert f"epics.fields.{field} = 1: a button" in done.stderr


def test_an_address_that_cannot_be_had_is_one_line(folder, invoke, monkeypatch):
    address = {"EPICS_CAS_INTF_ADDR_LIST": "192.0.2.1"}
    for name, value in (loopback(free_port()) | address).items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(ioc, "opened", functools.partial(ideal, folder))
    done = invoke("ioc", status=2)
    assert re.fullmatch(r"pixstep: Channel Access: .*EPICS_CAS_INTF_ADDR_LIST.*\n", done.stderr)


def test_the_screen_shows_pvs_that_there_are():
    tree = ElementTree.parse(natives.source("docs/epics/motor.bob"))
    there = set(common.all_names("P:", ["P:M"]))
    shown = {one.text for one in tree.findall(".//pv_name")} - {"$(pv_name)"}
    assert len(shown) > 40
    for name in shown:
        assert name.replace("$(P)", "P:").replace("$(M)", "M") in there, name


def test_the_unit_for_systemd_calls_the_command_as_it_is(folder, pixstep):
    text = natives.source("docs/epics/pixstep-ioc.service").read_text()
    (words,) = re.findall(r"^ExecStart=\S+/pixstep (.*)$", text, re.MULTILINE)
    assert "T:m1" in pixstep(*words.split(), "--list")
