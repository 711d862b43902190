# SPDX-License-Identifier: MIT
"""`divider` and `sync` of a machine file: what commands take from them, and where a line shows."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

from pixstep import formats
from pixstep.board import boards, capability, settings
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, Line
from pixstep.machine.files import MachineFile
from test_machine_defaults import asked

MACHINE = """\
[clock]
pixel = "1 kHz"
divider = 4
sync = "lock"
[boards.main]
kind = "mega"
port = "/dev/ttyTEST"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = { max_acceleration = "500 mm/s2" }
"""
NO_HEADER = "no header says how long its pixels are: each is taken as {} edges of the clock"
LONG = {"pixel_hz": 1000, "divider": 1000, "sync": 2}
MAKE = ("line", "make", "--speed", "4000steps/s", "--length", "2400", "-o", "l.csv")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Put a machine into the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("machine.toml").write_text(MACHINE)
    formats.write_csv(Path("bare.csv"), [2, 4, 2])
    return tmp_path


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    "words",
    [["line", "make", "--speed", "9", "-o", "x.csv"], ["line", "check", "bare.csv"],
     ["line", "show", "bare.csv", "--decode", "plain"], ["ticks", "bare.csv", "-o", "x.csv"],
     ["sim", "bare.csv"], ["limits"], ["line", "import", "bare.csv", "-o", "x.csv"],
     ["board", "upload", "bare.csv"], ["board", "move", "bare.csv", "--steps", "9"],
     ["board", "home", "bare.csv", "--haps", "2"],
     ["board", "measure-play", "bare.csv", "--haps", "2"],
     ["board", "trajectory", "bare.csv", "--bandwidth", "9"]],
    ids=lambda words: " ".join(words[:2]),
)  # fmt: skip
def test_a_command_has_the_clock_and_its_divider(words):
    got = asked(words)
    assert (got["clock_hz"], got["divider"]) == (1000, 4)
    assert got["pixel_hz"] in (None, 250)  # None: what the board has follows from the two
    assert got.get("sync") in (None, "lock")
    assert asked([*words, "--divider", "3"])["divider"] == 3


@pytest.mark.usefixtures("here")
def test_what_knows_no_divider_has_the_frequency_of_pixels():
    for words in (["profile", "check", "bare.csv"], ["move", "show", "bare.csv", "--steps", "9"]):
        assert asked(words)["pixel_hz"] == 250
    made = asked(["board", "simulate"])  # it makes the clock
    assert (made["clock_hz"], made["pixel_hz"]) == (1000, 250)


@pytest.mark.usefixtures("here")
def test_what_locks_lines_takes_that_too():
    for words in (["sim", "bare.csv"], ["line", "check", "bare.csv"], ["limits"],
                  ["board", "upload", "bare.csv"]):  # fmt: skip
        assert asked(words)["sync"] == "lock"
        assert asked([*words, "--sync", "free"])["sync"] == "free"


def test_a_machine_without_them_is_as_before(here, put):
    machine = MachineFile.load(put(MACHINE.replace('divider = 4\nsync = "lock"\n', "").encode()))
    assert (machine.clock.divider, machine.clock.sync) == (None, None)
    assert machine.pixel_hz == machine.clock_hz == 1000
    machine = MachineFile.load(here / "machine.toml")
    assert (machine.pixel_hz, machine.clock_hz) == (250, 1000)
    limit = machine["X"].limit("max_acceleration")
    assert limit.per_pixel(machine.pixel_hz) == Fraction(200_000, 250**2)


@pytest.mark.usefixtures("here")
def test_a_line_is_made_for_the_divider_and_held_to_it(invoke):
    made = invoke(*MAKE)
    assert "4 clock edges a pixel, as machine.toml has it" in made.stdout
    assert formats.read_motion(Path("l.csv")).header.frequency == 250
    check = ("line", "check", "l.csv")
    assert "made for" not in invoke(*check).stderr
    assert "--divider 4, not 3" in invoke(*check, "--divider", "3", status=3).stderr
    assert "made for 250 Hz, used at 200 Hz" in invoke(*check, "--divider", "5").stderr
    other = invoke(*MAKE, "--divider", "5", "--force").stdout
    assert "--divider 5 where it is used, or divider = 5 in the table [clock] of machine.t" in other
    said = invoke(*check, status=3).stderr
    assert "made for 200 Hz, used at 250 Hz" in said and "--divider 5, not 4" in said
    invoke("line", "import", "bare.csv", "--quantity", "steps", "-o", "i.csv")
    assert formats.read_motion(Path("i.csv")).header.frequency == 250
    invoke("line", "import", "bare.csv", "--quantity", "steps", "-o", "längs der Achse, zweite.csv")
    found = formats.read_motion(Path("längs der Achse, zweite.csv")).header
    assert (found.name, found.frequency) == ("l_ngs der Achse, zwe", 250)


@pytest.mark.usefixtures("here")
def test_a_line_that_says_nothing_gets_a_note(invoke, plan_program):
    one_edge = ("--divider", "1", "--pixel-hz", "250")
    for words in (("line", "check", "bare.csv"), ("ticks", "bare.csv", "-o", "-")):
        assert f"note: bare.csv: {NO_HEADER.format(4)}\n" in invoke(*words).stderr
        assert "no header" not in invoke(*words, *one_edge).stderr


@pytest.mark.usefixtures("here")
def test_an_upload_sets_the_board_as_the_machine_is(one):
    one.out("set", "divider=2")
    said = one.run("upload", "bare.csv").stderr
    assert NO_HEADER.format(4) in said
    names = ("pixel_hz_num", "divider", "sync")
    assert [one.board.setting(name) for name in names] == [1000, 4, 2]
    one.out("disarm")
    once = ("upload", "bare.csv", "--sync", "start", "--divider", "1")
    assert "--divider 3 would do, or divider = 3 in the table [clock]" in one.err(*once, status=2)
    one.out(*once, "--no-check")
    assert [one.board.setting(name) for name in names] == [1000, 1, 1]


@pytest.mark.usefixtures("here")
def test_nothing_is_set_for_a_line_that_is_refused(one):
    formats.write_csv(Path("fast.csv"), [2, 5000, 2])
    assert "line refused" in one.run("upload", "fast.csv", status=3).stderr
    assert (one.board.setting("divider"), one.board.setting("sync")) == (1, 1)


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_the_highest_speed_of_a_locked_line_is_accepted_and_the_next_is_not(board):
    clock = settings.of_clock("lock", 4)
    able = capability.of(board, Fraction(250), axes=1, clock=clock)
    top = able.top_speed("plain")
    assert top < capability.of(board, Fraction(250), axes=1).top_speed("plain")
    assert able.pixel_ticks - able.shortest_ticks == able.lock_ticks > 0
    for speed, refused in ((top, False), (top + 1, True)):
        line = Line((speed,), PLAIN)
        bounds = capability.named_limits(board, Fraction(250), clock=clock).of(line)
        assert line_check.refused(line_check.check(line, bounds)) is refused


@pytest.mark.usefixtures("here")
def test_a_locked_pixel_may_not_be_as_long_as_others(invoke, one):
    """A pixel of 1 s fits the board's timer, but not the longer ones that a lock may make of it."""
    long = ("--divider", "1000")
    says = "pixel frequency 1 Hz: the period must be 1024 to 15728625 ticks, as lines are locked"
    for words in (("limits",), ("line", "check", "bare.csv"), ("sim", "bare.csv", "--out", "r"),
                  ("sim", "bare.csv", "--out", "r", "--no-check")):  # fmt: skip
        assert says in invoke(*words, *long, status=2).stderr
    assert says in one.run("upload", "bare.csv", *long, status=2).stderr
    assert says in one.err("set", *[f"{name}={value}" for name, value in LONG.items()], status=2)
    assert invoke("limits", *long, "--sync", "start").stdout
    Path("machine.toml").write_text(MACHINE.replace("divider = 4", "divider = 1000"))
    assert f"warning: clock.divider: mega: {says}" in invoke("machine", "check", status=1).stdout


@pytest.mark.usefixtures("here")
def test_the_edges_of_a_clock_may_be_too_fast_for_a_board(invoke):
    """Whatever pixels they make: each of them is captured."""
    fast = ("--pixel-hz", "20kHz", "--sync", "start")
    says = "pixel frequency 20000 Hz: the period must be 1024 to 16777215 ticks"
    for words in (("limits",), ("line", "check", "bare.csv"), ("sim", "bare.csv", "--out", "r"),
                  ("sim", "bare.csv", "--out", "r", "--no-check")):  # fmt: skip
        assert says in invoke(*words, *fast, status=2).stderr
    Path("machine.toml").write_text(MACHINE.replace("1 kHz", "20 kHz"))
    assert f"warning: clock.pixel: mega: {says}" in invoke("machine", "check", status=1).stdout


@pytest.mark.usefixtures("here")
def test_limits_are_those_of_the_pixels(pixstep):
    page = pixstep("limits")
    assert " at 250 Hz: 64000 ticks of 62.5 ns a pixel, 4 clock edges, locked to the clock " in page
    told = json.loads(pixstep("limits", "--json"))
    assert (told["pixel_hz"], told["divider"], told["sync"]) == ("250", 4, "lock")
    assert told["shortest_pixel_ticks"] < told["pixel_ticks"] == 64000
    free = json.loads(pixstep("limits", "--json", "--sync", "free"))
    assert free["shortest_pixel_ticks"] == 64000


def test_a_new_file_has_them_and_shows_them(pixstep, invoke):
    words = ("machine", "new", "--board", "uno", "--clock-hz", "1kHz")
    pixstep(*words, "--divider", "4", "--sync", "lock")
    assert pixstep("machine", "check") == "machine.toml: fine\n"
    page = pixstep("machine", "show")
    assert "machine.toml: 1000 Hz, 4 clock edges a pixel, lines locked to it, lines for" in page
    shown = json.loads(pixstep("machine", "show", "--json"))
    names = ("pixel_hz", "clock_hz", "divider", "sync")
    assert [shown[name] for name in names] == ["250", "1000", 4, "lock"]
    text = Path("machine.toml").read_text().replace("divider = 4", "divider = 1000")
    Path("machine.toml").write_text(text.replace("1000 Hz", "900 Hz"))
    said = pixstep("machine", "check", status=1)
    assert "machine.toml: warning: clock.divider: uno: pixel frequency 0.9 Hz" in said
    assert "0.9" not in invoke("machine", "new", *words[2:], "--divider", "0", status=2).stderr


@pytest.mark.usefixtures("here", "simulator")
def test_a_simulation_locks_the_line_in_pixels_of_the_machine(invoke, pixstep):
    invoke(*MAKE)
    page = pixstep("sim", "l.csv", "--pixel-ppm", "2000")
    assert "1000 Hz, 4 clock edges a pixel, locked to the clock" in page
    summary = json.loads(Path("run/summary.json").read_text())
    assert summary["verdict"] == "pass"
    assert summary["axes"][0]["clock"]["max_error_ticks"] <= 2
