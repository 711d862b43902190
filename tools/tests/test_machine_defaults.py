# SPDX-License-Identifier: MIT
"""What commands take from the machine file, and what comes before it."""

import json
from pathlib import Path

import click
import pytest

from command_tree import own_commands
from pixstep import formats, natives
from pixstep.cli.main import main

PROFILE = "AccProfM39-30Hz-1.PRN"
MACHINE = f"""\
[clock]
pixel = 30
[line]
motor = "M39"
pixels = 60
[boards.main]
kind = "mega"
port = "/dev/none"
unit = 7
baud = 9600
parity = "O"
[motors.M39]
axis = 1
kind = "smooth"
steps_per_unit = "400 steps/mm"
backlash = "25 um"
direction = "-"
profiles = {{ line = "{PROFILE}" }}
limits = {{ max_speed = "20 mm/s", max_acceleration = "999 mm/s2", start_stop = 4 }}
[motors.M40]
axis = 2
kind = "plain"
steps_per_unit = "100 steps/deg"
backlash = "0.4 deg"
direction = "-"
limits = {{ start_stop = "4 steps/px", max_acceleration = 10 }}
"""


@pytest.fixture
def here(tmp_path):
    """Put a machine and its profile into the current folder."""
    (tmp_path / "machine.toml").write_text(MACHINE, encoding="utf-8")
    data = natives.root() / "tools" / "data" / PROFILE
    (tmp_path / PROFILE).write_bytes(data.read_bytes())
    return tmp_path


def asked(words: list[str]) -> dict:
    """Return what a command would get for its parameters."""
    ctx = click.Context(main, info_name="pixstep")
    group: click.Command = main
    while isinstance(group, click.Group):
        group, ctx = group.commands[words[0]], ctx
        words = words[1:] if isinstance(group, click.Group) else words
        if isinstance(group, click.Group):
            ctx = click.Context(group, info_name=group.name, parent=ctx)
    with group.make_context(words[0], list(words[1:]), parent=ctx) as made:
        return made.params


def test_a_line_and_its_simulation_need_nothing_else(here, pixstep, simulator):
    said = pixstep("line", "make", "--speed", "12mm/s", "-o", "line.csv")
    assert "60 pixels" in said and "4800 steps/s at 30 Hz" in said and "backlash 10" in said
    counts = formats.read_csv(here / "line.csv").values
    assert max(counts) == 160 and counts[0] == counts[-1] == 0
    output = pixstep("sim", "line.csv")
    assert output.startswith("PASS  mega, smooth decoding, 30 Hz")
    summary = json.loads((here / "run" / "summary.json").read_text(encoding="utf-8"))
    assert [axis["axis"] for axis in summary["axes"]] == [1]


def test_everything_that_sim_takes(here, invoke, monkeypatch):
    monkeypatch.chdir(here)
    (here / "a.csv").write_bytes(b"     2\r\n")
    got = asked(["sim", "a.csv"])
    assert (got["board"], got["axis"], got["pixel_hz"]) == ("mega", (1,), 30)
    assert (got["decode"], got["backlash"], got["negative"]) == (("smooth",), (10,), True)
    assert got["out"] == Path("run")
    two = asked(["sim", "a.csv", "a.csv", "--motor", "M39", "--motor", "M40"])
    assert (two["decode"], two["backlash"], two["axis"]) == (("smooth", "plain"), (10, 0), (1, 2))
    assert asked(["sim", "a.csv", "--decode", "plain"])["backlash"] == ()
    assert asked(["sim", "a.csv", "--backlash", "5um"])["backlash"] == (2,)


def test_the_command_line_comes_first_then_the_environment(here, monkeypatch):
    monkeypatch.chdir(here)
    (here / "a.csv").write_bytes(b"     2\r\n")
    got = asked(["sim", "a.csv", "--board", "uno", "--pixel-hz", "60", "--axis", "2", "--out", "x"])
    assert (got["board"], got["pixel_hz"], got["axis"], got["out"]) == ("uno", 60, (2,), Path("x"))
    monkeypatch.setenv("PIXSTEP_PORT", "/dev/mine")
    got = asked(["board", "move", PROFILE, "--steps", "0.5mm"])
    assert (got["port"], got["unit"], got["baud"], got["parity"]) == ("/dev/mine", 7, 9600, "O")
    assert (got["axis"], got["steps"], got["max_speed"].per_pixel(got["clock_hz"])) == (
        1, 200, 20 * 400 / got["clock_hz"],
    )  # fmt: skip


def test_plain_motors_and_angles(here, monkeypatch):
    monkeypatch.chdir(here)
    (here / "a.csv").write_bytes(b"     2\r\n")
    got = asked(["line", "make", "--motor", "M40", "--profile", PROFILE, "--speed", "3",
                 "-o", "x.csv"])  # fmt: skip
    assert (got["decode"], got["negative"], got["backlash"], got["lead_in"]) == (
        "plain", True, 0, 0,
    )  # fmt: skip
    got = asked(["line", "compensate", "a.csv", "--motor", "M40", "-o", "b.csv"])
    assert got["play"] == 40 and got["start_stop"].per_pixel(None) == 4
    assert asked(["move", "show", PROFILE, "--motor", "M40", "--steps", "-1.5deg"])["steps"] == -150


@pytest.mark.parametrize("name", ["home", "measure-play"])
def test_what_seeks_the_switch_takes_the_motor_s_kind(here, monkeypatch, name):
    monkeypatch.chdir(here)
    got = asked(["board", name, PROFILE])
    assert (got["decode"], got["axis"]) == ("smooth", 1)
    assert asked(["board", name, PROFILE, "--motor", "M40"])["decode"] == "plain"


def test_a_flag_of_another_meaning_is_left_alone(here, monkeypatch):
    monkeypatch.chdir(here)
    (here / "a.csv").write_bytes(b"     2\r\n")
    assert asked(["ticks", "a.csv", "-o", "b.csv"])["pixels"] is False
    assert asked(["limits"])["axes"] is None
    assert asked(["line", "import", "a.csv", "-o", "b.csv"])["length_unit"] is None
    assert asked(["profile", "check", PROFILE])["decode"] is None


def test_where_the_file_comes_from(here, invoke, monkeypatch):
    words = ("limits", "--json", "--pixel-hz", "30")
    assert json.loads(invoke(*words).stdout)["machine"] == "machine.toml"
    other = here / "other.toml"
    other.write_text(MACHINE.replace("mega", "m1284").replace("axis = 2", "axis = 0"), "utf-8")
    monkeypatch.setenv("PIXSTEP_MACHINE", str(other))
    assert json.loads(invoke(*words).stdout)["board"] == "m1284"
    assert json.loads(invoke(*words, "--machine", "machine.toml").stdout)["board"] == "mega"
    assert (
        "--board is missing: one of uno, mega, m1284"
        in invoke(*words, "--machine", "none", status=2).stderr
    )
    assert "No such file" in invoke(*words, "--machine", "no.toml", status=2).stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["sim", "a.csv", "a.csv"],
            "2 lines for 1 motor of machine.toml: give --motor or --axis once for each",
        ),
        (["sim", "a.csv", "--motor", "M4"], "machine.toml: there is no motor 'M4': M39, M40"),
        (["sim", "a.csv", "a.csv", "--motor", "M40", "--motor", "M40"],
         "axis 2: has 2 lines, one is possible"),
        (["line", "make", "--speed", "11.31mm/s", "-o", "x"],
         "speed 11.31mm/s is 150.8 steps/px, not an even whole number, as a smooth line needs: "
         "nearest legal 150 steps/px = 4500 steps/s = 11.25 mm/s and 152 steps/px"),
        (["line", "make", "--speed", "3deg/s", "-o", "x"], "needs a motor's steps per deg, the"),
        (["line", "check", "a.csv", "--backlash", "3um"], "distance 3um is 1.2 steps, not a whole"),
        (["ticks", "a.csv", "-o", "x", "--machine", "none", "--motor", "M39"],
         "--motor M39: no machine file: --machine FILE, PIXSTEP_MACHINE, or machine.toml in"),
    ],
)  # fmt: skip
def test_what_the_machine_cannot_tell_is_one_line(here, invoke, words, message):
    (here / "a.csv").write_bytes(b"     2\r\n")
    assert message in invoke(*words, status=2).stderr


def test_several_motors_and_none_for_lines(here, invoke):
    (here / "machine.toml").write_text(MACHINE.replace('motor = "M39"', ""), encoding="utf-8")
    (here / "a.csv").write_bytes(b"     2\r\n     2\r\n")
    assert "has motors M39, M40: choose by --motor" in invoke("sim", "a.csv", status=2).stderr
    given = ("line", "check", "a.csv", "--decode", "plain", "--max-acceleration", "9")
    assert "fine: 2 pixels" in invoke(*given).stdout  # all that it needs was given


def test_what_needs_no_motor_runs_beside_several(here, pixstep, invoke):
    text = MACHINE.replace('[line]\nmotor = "M39"\npixels = 60\n', "")
    (here / "machine.toml").write_text(text, encoding="utf-8")
    words = ("limits", "--board", "mega", "--axes", "2", "--pixel-hz", "200")
    assert pixstep(*words) == pixstep(*words, "--machine", "none")
    pixstep("trajectory", "circle", "--radius", "3200", "-o", "circle.trj")
    words = ("trajectory", "circle", "--radius", "3mm", "-o", "other.trj")
    assert "choose by --motor" in invoke(*words, status=2).stderr


def test_a_bad_file_stops_every_command_that_asks_it(here, invoke):
    (here / "machine.toml").write_text(MACHINE.replace("pixel = 30", "pixel = 0"), encoding="utf-8")
    assert "machine.toml:2: clock.pixel = 0" in invoke("limits", status=3).stderr
    assert "Show what a board can do" in invoke("limits", "--help").stdout
    assert invoke("file", "info", PROFILE).stdout


def test_the_bench_is_the_machine_s_board(here, monkeypatch):
    monkeypatch.chdir(here)
    got = asked(["board", "simulate"])
    assert (got["board"], got["pixel_hz"]) == ("mega", 30)


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (["board", "arm"], "--port"),
        (["board", "arm", "--port", "/dev/mine"], None),
        (["sim", "a.csv", "--board", "uno"], "--axis"),
        (["sim", "a.csv", "--board", "uno", "--axis", "1"], None),
        (["limits", "--axes", "9"], "--board"),
        (["line", "show", "a.csv"], "--backlash"),
        (["line", "make", "--speed", "12mm/s", "--pixels", "4", "-o", "b.csv"], None),
        (["line", "make", "--speed", "99mm/s", "-o", "b.csv"], "--profile"),
    ],
)
def test_an_error_about_a_default_says_where_it_is_from(here, invoke, words, option):
    (here / "a.csv").write_bytes(b"     2\r\n")
    said = invoke(*words, status=2).stderr.rstrip("\n")
    assert "\n" not in said and said.startswith("pixstep: ")
    assert said.endswith(f" ({option} from machine.toml)") == (option is not None)
    assert option or "machine.toml" not in said


def test_a_default_out_of_its_range_says_where_it_is_from(here, invoke):
    text = MACHINE.replace("pixels = 60", "pixels = 2_000_001")
    text = text.replace("start_stop = 4 }", "start_stop = '0.5 steps/px' }")
    (here / "machine.toml").write_text(text, encoding="utf-8")
    (here / "a.csv").write_bytes(b"     2\r\n")
    said = invoke("line", "make", "--speed", "12mm/s", "-o", "b.csv", status=3).stderr
    assert said == (
        "pixstep: --pixels: 2000001 is not in the range x<=2000000 (from machine.toml)\n"
    )
    said = invoke("line", "check", "a.csv", "--decode", "plain", status=2).stderr
    assert said == (
        "pixstep: 0.5 steps/px is 0.5 steps/px: at least 1 steps/px (--start-stop from "
        "machine.toml)\n"
    )


def test_what_is_for_all_boards_stays_for_all_boards(here, monkeypatch):
    monkeypatch.chdir(here)
    stop = asked(["board", "stop"])
    assert stop["units"] is None and not stop["axes"] and stop["port"] == "/dev/none"
    assert asked(["board", "scan"])["units"] == "all"
    assert asked(["board", "info"])["units"] == (7,)
    one = asked(["board", "stop", "--motor", "M40"])
    assert one["units"] == (7,) and list(one["axes"]) == [2]
    assert asked(["board", "arm", "--motor", "M39"])["axes"] == (1,)
    assert not asked(["board", "arm"])["axes"]


def test_a_bad_file_does_not_keep_a_board_from_being_stopped(here, invoke, monkeypatch):
    (here / "machine.toml").write_text("[clock]\npixel = 0\n", encoding="utf-8")
    monkeypatch.setenv("PIXSTEP_PORT", "/dev/none")
    stopping = invoke("board", "stop", status=2).stderr
    assert "machine.toml:1: boards: is missing: not used" in stopping and "/dev/none" in stopping
    assert "not used" not in invoke("board", "arm", status=3).stderr


def test_the_commands_that_are_offered_a_machine():
    served = {words for words, command in own_commands().items() if "machine" in names(command)}
    assert {"line make", "line check", "line show", "line import", "ticks", "sim", "limits",
            "move sim", "home sim", "board upload", "board info", "flash"} <= served  # fmt: skip
    assert not {"file info", "machine show", "demo"} & served


def names(command: click.Command) -> set[str]:
    return {param.name for param in command.params}
