# SPDX-License-Identifier: MIT
"""`direction` of a motor: every command moves the motor the other way for it, or nothing at all."""

import json
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner

from command_tree import commands
from console import PORT, put
from pixstep import formats, natives
from pixstep.cli.main import main
from pixstep.lines.runs import MARK_NEGATIVE, MARK_SMOOTH, signed
from pixstep.moves import experiments
from pixstep.operations import run
from pixstep.trajectories import circle, circle_test, runs
from pixstep.trajectories.transitions import TablePlay

FAST = natives.root() / "tools/data/AccProf-fast-move.csv"
SMOOTH = natives.root() / "tools/data/AccProfM39-30Hz-1.PRN"
MACHINE = f"""\
[clock]
pixel = "30 Hz"
[boards.main]
kind = "mega"
port = "{PORT}"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
direction = "WAY"
limits = {{ max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }}
[motors.Y]
axis = 1
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = {{ max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }}
[motors.S]
axis = 2
kind = "smooth"
direction = "WAY"
steps_per_unit = "400 steps/mm"
limits = {{ max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }}
"""
QUEUED = {  # commands that send motion to a board: those of each kind of motor
    "board home": [(FAST, "--motor", "X"), (FAST, "--motor", "S", "--decode", "smooth")],
    "board measure-play": [(FAST, "--motor", "X")],
    "board move": [
        (FAST, "--motor", "X", "--steps", "1mm"),
        (FAST, "--motor", "X", "--steps", 400),
    ],
    "board run": [("program.pmc", "--motor", "X")],
    "board trajectory": [("circle.csv", "--motor", "X", "--motor", "Y", "--no-take-up")],
    "board upload": [("smooth.csv", "--motor", "S")],
}
WRITTEN = {  # commands that write a line
    "line import": [("table.csv", "--motor", "X", "-o", "out.csv")],
    "line make": [
        (
            "--profile",
            SMOOTH,
            "--motor",
            "X",
            "--decode",
            "plain",
            "--speed",
            "120steps/px",
            "--pixels",
            60,
            "-o",
            "out.csv",
        )
    ],
    "move make": [
        (FAST, "--motor", "X", "--steps", "1mm", "-o", "out.csv"),
        (FAST, "--motor", "X", "--steps", 400, "-o", "out.csv"),
    ],
}
BELOW = {"home sim", "move show", "move sim", "sim", "trajectory sim"}
# Commands with --motor that move nothing, or know only the counts of files: those of the motor.
STILL = {
    *("board arm", "board clear", "board disable", "board disarm", "board enable"),
    *("board features", "board get", "board info", "board log events", "board log records"),
    *("board permit", "board scan", "board selftest", "board set", "board settings defaults"),
    *("board settings diff", "board settings export", "board settings import"),
    *("board settings store", "board simulate", "board start", "board stop", "board watch"),
    *("flash", "limits", "line check", "line compensate", "line show"),
    *("machine new", "profile check", "profile make", "profile repair", "profile show", "serve"),
    *("ticks",),
    *("trajectory circle", "trajectory compensate", "trajectory show"),
}


def cases(table):
    return [(name, words) for name, several in table.items() for words in several]


@pytest.fixture
def turned(monkeypatch, one):
    """Return a function that makes the machine file with a direction."""
    monkeypatch.delenv("PIXSTEP_PORT")
    put([10, 30, 40, 40, 30, 10], "smooth.csv")
    Path("table.csv").write_text("steps\n5\n6\n")
    Path("program.pmc").write_text("ABS LINEAR TA100 TS0 F20\nX1\n")
    Path("circle.csv").write_text("p1,v1,p2,v2\n0,0,0,0\n5,5,0,0\n10,0,0,0\n")
    return lambda way: Path("machine.toml").write_text(MACHINE.replace("WAY", way))


def test_every_command_with_a_motor_is_here():
    found = {
        words
        for words, command in commands().items()
        if any("--motor" in param.opts for param in command.params)
    }
    assert {*QUEUED, *WRITTEN, *BELOW, *STILL} == found


@pytest.mark.parametrize(("name", "words"), cases(QUEUED))
def test_what_goes_to_a_board(one, turned, name, words):
    assert [_queued(one, turned, name, words, way) for way in "+-"] == [1, -1]


def _queued(rig, turned, name, words, way):
    """Return the direction in which the first line that a board gets begins."""
    turned(way)
    before, heard, queue = rig.board.holdings.copy(), [], rig.board.queue

    def hear(data):
        queue(data)
        entries = [entry for axis in rig.board.axes for entry in axis.entries]
        if any(count for count, _ in entries[2:]):
            heard.append(entries)
            raise KeyboardInterrupt

    rig.board.queue = hear
    done = rig.finish(*name.split()[1:], *words)
    rig.board.queue, rig.board.holdings = queue, before
    assert heard, done.output
    (mark, _), _, *found = heard[0]
    if mark & MARK_SMOOTH:
        return -1 if mark & MARK_NEGATIVE else 1
    counts = [signed(count, 16) for count, _ in found]
    return next(1 if count > 0 else -1 for count in counts if count)


@pytest.mark.parametrize(("name", "words"), cases(WRITTEN))
def test_what_is_written(one, turned, invoke, name, words):
    sums = []
    for way in "+-":
        turned(way)
        invoke(*name.split(), *words, "--force")
        sums.append(sum(formats.read_motion(Path("out.csv"), raw=True).values))
    assert sums[0] > 0 and sums[1] == -sums[0]


@pytest.mark.usefixtures("one")
def test_what_is_shown(turned, invoke):
    for way, steps in (("+", 400), ("-", -400)):
        turned(way)
        done = invoke("move", "show", FAST, "--motor", "X", "--steps", "1mm", "--json")
        assert json.loads(done.stdout)["steps"] == steps


class SeenError(Exception):
    """Ends a command whose simulation has begun."""


def _begun(monkeypatch, module, name, *words):
    """Return what a command's simulation is given."""
    seen = []

    def see(*given, **_):
        seen.append(given[0])
        raise SeenError

    with monkeypatch.context() as patched:
        patched.setattr(module, name, see)
        done = CliRunner().invoke(main, [str(word) for word in words])
    assert isinstance(done.exception, SeenError), done.output
    return seen[0]


@pytest.mark.parametrize(("way", "sign"), [("+", 1), ("-", -1)])
def test_what_is_simulated(turned, monkeypatch, way, sign):
    turned(way)
    words = ("move", "sim", FAST, "--motor", "X", "--steps", "1mm")
    assert _begun(monkeypatch, experiments, "simulate_move", *words).move.steps == sign * 400
    words = ("home", "sim", FAST, "--motor", "X", "--plant", "home=2000")
    for asked, towards in (("plus", sign), ("minus", -sign)):
        job = _begun(monkeypatch, experiments, "simulate_homing", *words, "--direction", asked)
        assert (job.plan.direction, job.plan.towards) == (towards, asked)
    words = ("sim", "smooth.csv", "--motor", "S")
    job = _begun(monkeypatch, run, "simulate", *words)
    assert [line.negative for line in job.lines.values()] == [sign < 0]
    words = ("trajectory", "sim", "circle.csv", "--motor", "X", "--motor", "Y")
    test = _begun(monkeypatch, circle_test, "simulate", *words)
    assert test.job.ways == (sign, 1)


def test_without_a_motor_steps_are_the_board_s(turned, invoke):
    turned("-")
    given = ("move", "show", FAST, "--steps", 400, "--json")
    assert json.loads(invoke(*given).stdout)["steps"] == 400
    assert json.loads(invoke(*given, "--motor", "X").stdout)["steps"] == -400


@pytest.mark.usefixtures("simulator")
def test_a_table_runs_the_same_on_a_motor_that_is_turned_round(tmp_path):
    """The loads are where the table says, and play is taken up, whatever the motor's direction."""
    made = circle.make(circle.CircleRequest(200, points=256, revolutions=1, holds=0, lead_in=64))
    plays = (TablePlay(20, 4), TablePlay(10, 4))
    found = []
    for ways in ((1, 1), (-1, 1)):
        job = runs.BoardJob("mega", Fraction(100), (20, 10), ways=ways)
        run = runs.run_on_board(made, plays, runs.COMPENSATED, job, tmp_path / str(ways[0]))
        assert run.summary["verdict"] == "pass"
        found.append(run.trace)
    assert (found[0].load == found[1].load).all() and (found[0].motor == found[1].motor).all()
    counts = [line.counts for line in runs.lines(made)]
    turned = [line.counts for line in runs.turned(runs.lines(made), (-1, 1))]
    assert turned == [tuple(-count for count in counts[0]), counts[1]]
