# SPDX-License-Identifier: MIT
"""How long the main loop of a board of several axes stays in a request, and in a round."""

from fractions import Fraction
from itertools import pairwise

import pytest

from pixstep.board import boards
from pixstep.lines.line import SMOOTH, Line
from pixstep_dev.bench import sections, turns
from pixstep_dev.bench.drive import BenchRun, drive
from pixstep_trials import lines

SEVERAL = [board.name for board in boards.all_boards() if board.axes > 1]
REQUEST_CYCLES = 4000
# 4 ms of decoding, the call that goes on then, and all else of a round.
ROUND_CYCLES = 64_000 + 29_000 + 7_000

pytestmark = pytest.mark.usefixtures("simulator")


@pytest.mark.parametrize("board", SEVERAL)
def test_no_request_holds_the_main_loop(board):
    rows = turns.measure(board)
    assert len(rows) > 25
    assert not [row for row in rows if row["request_cycles"] > REQUEST_CYCLES]
    assert max(row["request_cycles"] for row in rows) > REQUEST_CYCLES / 2  # they are measured


def ramps(times):
    """Return a line that comes to 20 steps a pixel and back to rest, over and over."""
    up = range(0, 20, 2)
    speeds = [*up, *[20] * 11, *reversed(up)]
    counts = tuple((a + b) // 2 for a, b in pairwise(speeds))
    return Line((0, *counts * times), SMOOTH, backlash=7)


@pytest.mark.parametrize("board", SEVERAL)
@pytest.mark.parametrize(
    ("line", "hz"), [(ramps(6), 233), (lines.at_peak(200, Fraction(100), 0.6), 100)]
)
def test_every_round_ends_by_time(board, line, hz):
    axes = range(boards.load(board).axes)
    outcome = drive(BenchRun(board, dict.fromkeys(axes, line), Fraction(hz)))
    assert (outcome.refused, outcome.fault, outcome.trouble) == ("", "", "")
    longest = sections.longest(outcome.stats["boards"][0], "round")
    assert ROUND_CYCLES / 4 < longest <= ROUND_CYCLES
