# SPDX-License-Identifier: MIT
"""Rates that failed below others that passed, and the campaign that looks for such ones."""

import json
from fractions import Fraction
from itertools import pairwise

import pytest

from effort import cases, only_long
from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.simulation import judge
from pixstep.simulation.job import LOCK, START, LineExperiment, run_job
from pixstep_dev.robustness import holes
from pixstep_dev.robustness.holes import Combination, Hole

CASE = Combination("mega", 4, "lock", "ramps")


def ramps(steps, stride, backlash, held=10):
    """Return a line with backlash that comes to so many steps a pixel by so many in each."""
    up = range(0, steps, stride)
    speeds = [*up, *[steps] * (held + 1), *reversed(up)]
    counts = tuple((a + b) // 2 for a, b in pairwise(speeds))
    return Line((0, *counts), SMOOTH, backlash=backlash)


def assert_right(tmp_path, board, axes, line, hz, sync):
    """Run the line on so many axes at once: every step made, every edge right."""
    lines = dict.fromkeys(range(axes), line)
    result = run_job(LineExperiment(board, lines, Fraction(hz), sync=sync), tmp_path)
    assert (result.trouble, result.refused) == ([], None)
    assert judge.judge(result).summary["reasons"] == []


# The pieces of a ramp with backlash take four axes more than a pixel's time: what was decoded
# before line zero must last.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("steps", "hz"),
    [(14, 300), (14, 350), (14, 400), (20, 225), (20, 300), (20, 500), *cases([], [(14, 450)])],
)
def test_locked_ramps_with_backlash(tmp_path, steps, hz):
    assert_right(tmp_path, "mega", 4, ramps(steps, 2, 7), hz, LOCK)


# Intervals of 256 k and 256 k + 1 ticks, which no pulse train can make.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("board", "axes", "steps", "hz"),
    [
        ("mega", 4, 1040, 30),
        ("mega", 4, 156, 200),
        ("mega", 2, 2080, 30),
        ("mega", 2, 623, 100),
        ("m1284", 2, 2602, 30),
        *cases([], [("mega", 4, 1041, 30), ("mega", 2, 2076, 30), ("m1284", 2, 780, 100)]),
    ],
)
def test_intervals_on_both_sides_of_a_high_byte(tmp_path, board, axes, steps, hz):
    line = Line((steps,) * max(6, hz // 3), PLAIN)
    assert_right(tmp_path, board, axes, line, hz, START)


# The clock's edge that places line zero is taken between two decodings of one round.
@pytest.mark.usefixtures("simulator")
def test_a_line_placed_inside_a_round_is_released_in_time(tmp_path):
    assert_right(tmp_path, "mega", 2, ramps(100, 10, 25), 225, LOCK)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", cases(["mega"], boards.BOARD_NAMES))
def test_a_small_sweep(invoke, board):
    options = ("--board", board, "--quick", "--json")
    done = invoke("robustness", "holes", *options)
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert all(row["passed"] for row in outcome["rows"])


@only_long
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_a_sweep(invoke, board):
    options = ("--board", board, "--clocks", 12, "--counts", 30, "--json")
    done = invoke("robustness", "holes", *options)
    assert done.exit_code == 0, json.loads(done.stdout)["complaints"]


def test_what_a_hole_is():
    found = {
        (100, 10): "",
        (100, 20): "fault decoder_late",
        (100, 25): "",
        (100, 30): "fault underrun",
        (200, 30): "refused",
        (125, 20): "",
        (125, 25): "fault decoder_late",
    }
    row = holes.row_of(CASE, found)
    assert (row.tried, row.passed, row.refused, row.failed) == (7, 3, 1, 3)
    # 20 % below what passes at the same clock and below the clock where as many steps pass; above
    # all that passes there is no hole.
    assert row.holes == [Hole(100, 20, "fault decoder_late", "25 steps", 20.0)]
    assert row.deepest == row.holes[0]


def test_a_clock_that_fails_below_one_that_passes():
    found = {(300, 14): "fault decoder_late", (250, 14): "", (500, 14): ""}
    (hole,) = holes.row_of(CASE, found).holes
    assert (hole.hz, hole.passes, hole.depth_percent) == (300, "500 Hz", 40.0)


def test_the_grid():
    assert holes.clocks(40)[0] == 1
    assert holes.clocks(40)[-1] == 5000
    assert len(holes.counts(100)) > 70
    assert holes.line_of("plain", 7, 30).counts == (7,) * 6
    assert sum(holes.line_of("smooth", 20, 100).counts) == sum((10, *(20,) * 11, 10))
    assert holes.line_of("ramps", 14, 100).counts[:4] == (0, 1, 3, 5)
    names = {str(case) for case in holes.combinations(["uno", "m1284"])}
    assert len(names) == 3 * 2 * 4
    assert "m1284 2 lock backlash" in names


def test_a_deep_hole_is_a_complaint(invoke, monkeypatch):
    ends = {100: "fault decoder_late", 200: ""}
    monkeypatch.setattr(holes, "climb", lambda case, hz, counts: {20: ends[hz]})
    monkeypatch.setattr(holes, "clocks", lambda number: (100, 200))
    monkeypatch.setattr(holes, "ProcessPoolExecutor", InPlace)
    done = invoke("robustness", "holes", "--board", "uno", "--motion", "plain", status=1)
    assert "uno 1 lock plain" in done.stdout
    assert "FAIL: uno 1 start plain: 20 steps at 100 Hz end in fault decoder_late" in done.stdout


class InPlace:
    """Stands for a pool of processes."""

    def __init__(self, processes):
        self.processes = processes

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def submit(self, function, *given):
        return Done(function(*given))


class Done:
    """What was asked of it is done already."""

    def __init__(self, value):
        self.value = value

    def result(self):
        return self.value
