# SPDX-License-Identifier: MIT
"""What a clock input does to the rest of the board: storms of edges, lines armed at odd moments."""

import contextlib
import itertools
from fractions import Fraction

import pytest

from bench import Bench
from effort import cases
from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line

pytestmark = pytest.mark.usefixtures("simulator")

BOARDS = [board.name for board in boards.all_boards()]
SEVERAL = [board.name for board in boards.all_boards() if board.axes > 1]
LOCK = 2
SETTLED_S = 0.3
MOMENTS = cases(8, 60)
SLOW = Line((1777,) * 12, PLAIN, clocked=False)
SLOW_HZ = 30
SPEEDS = (*range(0, 22, 2), *[20] * 100, *range(18, -1, -2))
RISING = Line(tuple((a + b) // 2 for a, b in itertools.pairwise(SPEEDS)), SMOOTH)


@contextlib.contextmanager
def running(board, steps):
    """Yield a board whose axis 0 has made so many steps of the slow line."""
    with Bench(board, hz=SLOW_HZ) as bench:
        bench.load(SLOW)
        bench.arm()
        bench.run_until_steps(steps)
        yield bench


@pytest.mark.parametrize("hz", [6000, 8500, 12_000])
@pytest.mark.parametrize("board", BOARDS)
def test_a_storm_of_edges_holds_nobody(board, hz):
    """A floating input is one: a line that needs no clock goes on, the board answers."""
    with running(board, 1000) as bench:
        bench.sim.command(f"clock hz {hz}/1")
        bench.sim.wait_s(0.3)
        bench.sim.command(f"clock hz {SLOW_HZ}/1")
        bench.until(lambda: bench.state() == "done")
        assert bench.count() == SLOW.total_steps
        assert bench.fault() == "none"


@pytest.mark.parametrize("hz", [2200, 2400])
def test_edges_lost_while_a_start_is_decoded_are_no_fault(hz):
    """The gap that they leave lies behind the edges that waited."""
    with Bench("uno", hz=hz) as bench:
        bench.load(RISING)
        bench.arm()
        bench.run_until_steps(1500)
        assert bench.fault() == "none"


@pytest.mark.parametrize("moment", range(MOMENTS))
@pytest.mark.parametrize("board", SEVERAL)
def test_a_locked_line_armed_at_the_end_of_another_begins_soon(board, moment):
    with Bench(board, (0, 1), hz=Fraction(1000)) as bench:
        bench.board.write_setting("sync", LOCK)
        bench.sim.wait_s(SETTLED_S)
        bench.load(Line((4,) * 60, PLAIN), 0)
        bench.load(Line((4,) * 30, PLAIN), 1)
        bench.board.command("arm", [0])
        bench.run_until_steps(4 * 52)
        bench.sim.run(int(bench.sim.tick_hz * 0.009 * moment / MOMENTS))
        bench.board.command("arm", [1])
        bench.sim.wait_s(0.1)
        assert [bench.state(axis) for axis in (0, 1)] == ["done", "done"]
        assert [bench.count(axis) for axis in (0, 1)] == [240, 120]


@pytest.mark.parametrize("held", [320, 400, 500])
@pytest.mark.parametrize("board", SEVERAL)
def test_interrupts_that_come_too_late_in_a_slow_train_are_a_fault(board, held):
    """Intervals of 300 ticks or more: no later edge may be late without a fault."""
    with running(board, 3000) as bench:
        before = _last(bench)
        bench.sim.command("hang 0 interrupts")
        bench.sim.run(held)
        bench.sim.command("hang 0 off")
        bench.until(lambda: bench.state() in ("done", "fault"))
        if bench.fault() == "none":
            after = _last(bench)
            assert after[0] == SLOW.total_steps
            pixels = Fraction(after[0] - before[0], SLOW.counts[0])
            assert abs(after[1] - before[1] - pixels * bench.sim.tick_hz / SLOW_HZ) <= 2
        else:
            assert bench.fault() == "underrun"


def _last(bench):
    """Return the number of the newest step and the cycle of its edge."""
    _, count, _, rise, _ = bench.sim.command("last 0 0").split()
    return int(count), int(rise)
