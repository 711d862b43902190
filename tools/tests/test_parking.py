# SPDX-License-Identifier: MIT
"""Axes at rest are parked: time goes on without their interrupts, and a line starts right."""

from dataclasses import replace
from fractions import Fraction

import pytest

from bench import Bench
from effort import cases
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.run import arm
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import period_ticks
from pixstep.simulation import verdict
from pixstep.simulation.logs import read_clock, read_edges
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_trials.memory import Memory

pytestmark = pytest.mark.usefixtures("simulator")

SEVERAL = [board.name for board in boards.all_boards() if board.axes > 1]
IDLE_CYCLES = 4096
STEP = 7  # cycles from one phase to the next, beside what a line takes
# The main loop is held for so many cycles in turn: for part of an idle period, and for longer.
HELD_CYCLES = (2500, 4000, 9000)
# An axis is unparked, and what comes before its line is released, in so many cycles.
UNPARKING_CYCLES = 480
SHORT = Line((3, 5, -4), PLAIN)
PARKED = 4  # STEP_ENGINE_PARKED


def interrupts(bench):
    """Count the step interrupts of all axes so far, halted ones included."""
    names = {
        f"TIMER{timer}_{kind}"
        for timer in boards.load(bench.name).timers.values()
        for kind in ("OVF", "COMPA")
    }
    handlers = bench.sim.stats()["boards"][0]["handlers"]
    return sum(row["count"] for row in handlers if row["name"] in names)


@pytest.mark.parametrize("board", SEVERAL)
def test_axes_at_rest_are_not_interrupted(board):
    with Bench(board, range(boards.load(board).axes)) as bench:
        bench.sim.wait_s(20e-3)
        before = interrupts(bench)
        bench.sim.wait_s(100e-3)
        assert interrupts(bench) == before


def test_a_single_axis_goes_on_as_ever():
    with Bench("uno") as bench:
        before = interrupts(bench)
        bench.sim.wait_s(100e-3)
        assert interrupts(bench) - before == pytest.approx(1_600_000 / IDLE_CYCLES, abs=2)


@pytest.mark.parametrize("board", SEVERAL)
def test_a_line_begins_on_the_clock_whatever_the_phase(board, tmp_path):
    """Of each axis, the one that captures the clock among them: parked, unparked, parked again."""
    phases = cases(40, 1200)
    edges, clock = tmp_path / "edges.csv", tmp_path / "clock.csv"
    count = boards.load(board).axes
    bench = Bench(board, range(count), 400, edges=edges)
    bench.options["clock_log"] = clock
    with bench:
        period = period_ticks(bench.hz, bench.sim.tick_hz)
        for phase in range(phases):
            axis = count - 1 - phase % count
            bench.sim.run(IDLE_CYCLES + STEP * phase)
            bench.load(SHORT, axis)
            bench.board.command("arm", [axis])
            bench.until(lambda axis=axis: bench.state(axis) == "done")
        bench.assert_rest()
        assert bench.fault() == "none"
        bench.sim.command("flush")
        ticks = read_clock(clock)
        steps = SHORT.total_steps
        for axis in range(count):
            made = read_edges(edges).axis(0, axis)
            lines = len(range(count - 1 - axis, phases, count))
            assert len(made.rising) == lines * steps
            for number in range(lines):
                found = verdict.judge_axis(
                    SHORT, period, cut(made, number * steps, steps), tick_hz=bench.sim.tick_hz
                )
                assert found.reasons == [], (axis, number)
                assert verdict.judge_clock(found.line_zero_cycle, period, ticks)[1] == ""


@pytest.mark.parametrize("board", SEVERAL)
def test_a_line_begins_wherever_the_main_loop_is_held_before(board):
    """Interrupts may hold the main loop anywhere while it switches an axis's own interrupt on."""
    axis = boards.load(board).axes - 1
    with Bench(board, [axis], 400) as bench:
        bench.board.write_setting("sync", regs.SYNCS["free"])
        for number, place in enumerate(range(0, UNPARKING_CYCLES, cases(16, 4))):
            bench.load(SHORT, axis)
            bench.sim.command("hang 0 at step_unpark")
            bench.arm()
            bench.sim.wait_s(3e-3)
            assert Memory(bench.sim, board).read(f"engine[{axis}].state") == PARKED
            bench.sim.command("hang 0 off")
            bench.sim.run(place)
            bench.sim.command("hang 0 main")
            bench.sim.run(HELD_CYCLES[number % len(HELD_CYCLES)])
            bench.sim.command("hang 0 off")
            bench.until(lambda: bench.state(axis) != "running")
            assert (bench.state(axis), bench.fault()) == ("done", "none"), place
            assert bench.count(axis) == (number + 1) * SHORT.total_steps
        bench.assert_rest()


def cut(made, first, count):
    """Return the edges of one of several lines."""
    begin = made.rising[first - 1] + 1 if first else 0
    end = made.rising[first + count - 1]
    within = (made.direction_cycles > begin) & (made.direction_cycles <= end)
    return replace(
        made,
        step_cycles=made.step_cycles[2 * first : 2 * (first + count)],
        step_levels=made.step_levels[2 * first : 2 * (first + count)],
        direction_cycles=made.direction_cycles[within],
        direction_levels=made.direction_levels[within],
    )


@pytest.mark.parametrize("board", cases(["mega"], SEVERAL))
def test_parked_for_longer_than_the_counts_hold(board):
    """16 bits of idle periods are 17 s (a second wrap: the long check), ticks wrap after 268 s."""
    with Bench(board, [boards.load(board).axes - 1], 30) as bench:
        bench.board.write_setting("bus_timeout_ms", 0)
        axis = bench.axes[0]
        for pause_s in cases((17,), (17, 40)):
            bench.sim.wait_s(pause_s)
            bench.load(SHORT, axis)
            bench.arm()
            bench.until(lambda: bench.state(axis) == "done")
            bench.assert_rest()
        assert bench.fault() == "none"


@pytest.mark.parametrize("board", SEVERAL)
def test_axes_that_are_too_fast_together_are_not_armed(board):
    """One alone may; beside another it is refused by name, and so is the other beside it."""
    one = boards.load(board)
    fast = Line((int(one.tick_hz / 100 / one.min_intervals_ticks[0]),) * 60, PLAIN)
    slow = Line((100,) * 60, PLAIN)
    with Bench(board, (0, 1)) as bench:
        bench.load(slow, 0)
        bench.load(fast, 1)
        for axes in ([0, 1], [1, 0]):
            with pytest.raises(BoardError, match="axis 1: too_fast_together"):
                arm(bench.board, axes)
        assert [bench.state(axis) for axis in (0, 1)] == ["loaded", "loaded"]
        arm(bench.board, [1])
        bench.run_until_steps(100, 1)
        with pytest.raises(BoardError, match="axis 1: too_fast_together"):
            arm(bench.board, [0])
        bench.until(lambda: bench.state(1) == "done")
        assert bench.fault() == "none"
        arm(bench.board, [0])
        bench.until(lambda: bench.state(0) == "done")
        bench.assert_rest()


def test_a_run_of_lines_that_are_too_fast_together_says_so():
    fast = Line((1000,) * 20, PLAIN)
    with SimulatedBoard("mega", Fraction(100)) as board:
        board.set_up(Fraction(100), list(range(4)))
        board.load(dict.fromkeys(range(4), fast))
        with pytest.raises(LineRefusedByBoardError) as refusal:
            board.arm()
        board.finish()
    assert (refusal.value.name, refusal.value.axis) == ("too_fast_together", 0)
