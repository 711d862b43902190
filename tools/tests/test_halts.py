# SPDX-License-Identifier: MIT
"""Halts at the shortest intervals, and emergency stops whose contact bounces.

At 63 ticks a step (Uno) the idle period must be loaded within 63 cycles of the end of the period
that runs, whatever holds interrupts off at that moment: a period made twice is a step too many.
"""

import random

import pytest

from bench import Bench
from effort import cases
from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line
from pixstep_trials import frames
from pixstep_trials.promises import ESTOP_CYCLES

pytestmark = pytest.mark.usefixtures("simulator")

TRIALS = cases(12, 40)
SETTLE_CYCLES = 300_000
SHORTEST_OF_OTHERS = [
    (board.name, board.min_interval_ticks)
    for board in boards.all_boards()
    if board.name not in ("uno", "mega")
]
SHORTEST = [
    ("uno", 63),
    ("uno", 64),
    ("uno", 65),
    ("mega", 266),
    ("mega", 280),
    *SHORTEST_OF_OTHERS,
]


def stop_frame(axes):
    return frames.order("stop", sum(1 << axis for axis in axes), unit=frames.BROADCAST)


def press(bench, level, at):
    (pin,) = [one for one in boards.load(bench.name).pins if one.signal == "ESTOP"]
    bench.sim.pin(0, pin.port, pin.bit, level, at=at)


def run_all(bench, ticks, cycles):
    """Let every axis run a line of this interval; so many cycles behind the first steps."""
    for axis in bench.axes:
        bench.load(Line((bench.pixel_ticks // ticks,) * 30, PLAIN), axis)
    bench.arm()
    bench.run_until_steps(bench.count() + 100)
    bench.sim.run(cycles)


def assert_counted(bench):
    for axis in bench.axes:
        assert bench.board.axis(axis)["position_steps"] == bench.sim.steps(0, axis)


@pytest.mark.parametrize(("board", "ticks"), SHORTEST)
def test_every_step_counts_at_a_stop(board, ticks):
    with Bench(board, range(boards.load(board).axes)) as bench:
        for trial in range(TRIALS):
            run_all(bench, ticks, 20_000 + trial)
            bench.sim.command(f"send {stop_frame(bench.axes).hex()} 0")
            bench.sim.run(SETTLE_CYCLES)
            assert bench.fault() == "none"
            assert_counted(bench)


@pytest.mark.parametrize(("board", "ticks"), SHORTEST)
def test_every_step_counts_at_an_emergency_stop(board, ticks):
    with Bench(board, range(boards.load(board).axes)) as bench:
        for trial in range(TRIALS):
            run_all(bench, ticks, 20_000)
            press(bench, 0, bench.sim.cycle + 100 + 7 * trial)
            bench.sim.run(SETTLE_CYCLES)
            assert bench.fault() == "estop"
            assert_counted(bench)
            press(bench, 1, bench.sim.cycle + 10)
            bench.sim.run(20_000)
            bench.board.command("clear_fault", [])


@pytest.mark.parametrize(
    ("board", "ticks"), [("uno", 63), ("uno", 160), ("mega", 300), ("m1284", 200)]
)
def test_a_bouncing_contact_stops_in_time(board, ticks):
    """Closed for up to 12 us, open for up to 50 us, one to seven times; then closed for good."""
    rng = random.Random(f"bounces {board} {ticks}")
    with Bench(board, range(boards.load(board).axes)) as bench:
        for _ in range(TRIALS // 2):
            bench.board.command("permit_on", [])
            run_all(bench, ticks, 20_000)
            at = bench.sim.cycle + rng.randrange(1000, 9000)
            for _ in range(rng.randrange(1, 8)):
                press(bench, 0, at)
                press(bench, 1, at + rng.randrange(8, 200))
                at += 200 + rng.randrange(100, 800)
            press(bench, 0, at)
            bench.sim.run(at + SETTLE_CYCLES - bench.sim.cycle)
            permit = bench.sim.permit(0)
            assert permit.level == 0
            assert permit.cycle <= at + ESTOP_CYCLES
            assert bench.fault() == "estop"
            assert_counted(bench)
            press(bench, 1, bench.sim.cycle + 10)
            bench.sim.run(20_000)
            bench.board.command("clear_fault", [])


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
@pytest.mark.parametrize("idle_off_ms", [1, 3])
def test_a_driver_stays_on_until_the_last_step_is_over(tmp_path, board, idle_off_ms):
    """Behind a stop the timer holds a step for up to 8 ms, and its pulse for 4 ms more."""
    edges = tmp_path / "edges.csv"
    with Bench(board, edges=edges) as bench:
        bench.board.write_setting("idle_off_ms", idle_off_ms)
        for trial in range(TRIALS):
            bench.load(Line((1 + trial % 3,) * 4, PLAIN))
            bench.arm()
            bench.run_until_steps(bench.count() + 1)
            bench.sim.run(2741 * trial)
            bench.board.command("stop", bench.axes)
            bench.sim.run(2 * SETTLE_CYCLES)
            assert_counted(bench)
        bench.sim.command("flush")
    off = high = False
    seen_off = 0
    for row in edges.read_text().splitlines()[1:]:
        _, _, axis, signal, level = row.split(",")
        if axis == "0" and signal == "ENABLE":
            off = level == "1"
            seen_off += off
            assert not (off and high)
        elif axis == "0" and signal == "STEP":
            high = level == "1"
            assert not (off and high)
    assert seen_off >= TRIALS
