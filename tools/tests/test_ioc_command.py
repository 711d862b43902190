# SPDX-License-Identifier: MIT
"""`pixstep ioc` as a command: names, mistakes, its end; the files beside its document."""

import json
import os
import re
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest

from iocbench import free_port, loopback, until
from iocprocess import HERE, MACHINE, Command
from pixstep import natives
from pixstep.ioc import names


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Go to a folder with a machine file."""
    (tmp_path / "machine.toml").write_text(MACHINE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 0), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_a_signal_stops_the_motors_and_keeps_where_they_are(folder, number, status):
    command = Command(folder)
    wire = command.wire()
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


def test_fields_come_from_the_machine_file(folder):
    command = Command(folder)
    wire = command.wire()
    found = {
        name: wire.value(f"T:m1.{name}")
        for name in ("EGU", "MRES", "VMAX", "ACCL", "BDST", "DHLM", "DIR", "OUT", "PREC")
    }
    assert found == {
        "EGU": "mm", "MRES": 0.0025, "VMAX": 5.0, "ACCL": 0.1, "BDST": 0.02, "DHLM": 100.0,
        "DIR": 0, "OUT": "@pixstep(main,0)", "PREC": 4,
    }  # fmt: skip
    assert (wire.value("T:second.DIR"), wire.value("T:second.EGU")) == (1, "steps")
    assert command.end(signal.SIGINT) == 0


def test_the_list_has_every_pv(folder, pixstep):
    found = pixstep("ioc", "--list", "--prefix", "X:").split()
    assert found == names.all_names("X:", ["X:m1", "X:second"])
    assert json.loads(pixstep("ioc", "--list", "--json"))["records"] == {
        "m1": "T:m1", "m2": "T:second"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words", "said", "status"),
    [
        (("", ""), (), r"machine\.toml: board main has no port: --port PORT, or port in", 2),
        (("", ""), ("--machine", "none"), "no machine file: --machine FILE", 2),
        (("", ""), ("--port", "/dev/nothing"), "/dev/nothing: there is no such port", 2),
        (("second", "m1"), ("--list",), "motors m1 and m2 both have the record T:m1", 2),
        (("second", "a b"), ("--list",), "motor m2: no record can have the name 'T:a b'", 2),
        (("DHLM = 100", "DHL = 1"), ("--list",), r"toml:\d+: .*fields\.DHL = 1: .* no such", 3),
        (("DHLM = 100", "RBV = 1"), ("--list",), r"toml:\d+: .*RBV = 1: only the record", 3),
        (("DHLM = 100", 'DIR = "X"'), ("--list",), r"DIR = 'X': a number, or one of Pos", 3),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(folder, invoke, change, words, said, status):
    (folder / "machine.toml").write_text(MACHINE.replace(*change) if change[0] else MACHINE)
    done = invoke("ioc", *words, status=status)
    assert re.search(said, done.stderr), done.stderr
    assert done.stderr.count("\n") == 1


def test_an_address_that_cannot_be_had_is_one_line(folder):
    done = subprocess.run(
        [sys.executable, HERE / "ideal_ioc.py", folder, "ioc"], cwd=folder, check=False,
        env=os.environ | loopback(free_port()) | {"EPICS_CAS_INTF_ADDR_LIST": "192.0.2.1"},
        capture_output=True, text=True, timeout=30,
    )  # fmt: skip
    assert done.returncode == 2
    assert re.fullmatch(r"pixstep: Channel Access: .*EPICS_CAS_INTF_ADDR_LIST.*\n", done.stderr)


def test_the_screen_shows_pvs_that_there_are():
    tree = ElementTree.parse(natives.source("docs/epics/motor.bob"))
    there = set(names.all_names("P:", ["P:M"]))
    shown = {one.text for one in tree.findall(".//pv_name")} - {"$(pv_name)"}
    assert len(shown) > 40
    for name in shown:
        assert name.replace("$(P)", "P:").replace("$(M)", "M") in there, name


def test_the_unit_for_systemd_calls_the_command_as_it_is(folder, pixstep):
    text = natives.source("docs/epics/pixstep-ioc.service").read_text()
    (words,) = re.findall(r"^ExecStart=\S+/pixstep (.*)$", text, re.MULTILINE)
    assert "T:m1" in pixstep(*words.split(), "--list")
