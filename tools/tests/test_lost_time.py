# SPDX-License-Identifier: MIT
"""Step interrupts that were missed, and a halt before the check of time could name them.

A period whose interrupt does not come is made twice: a step too many, and no flag tells. The check
of time (time_check.c) finds it afterwards, also when the axis has stopped or failed meanwhile.
"""

import random

import pytest

from bench import Bench
from lockbench import LockBench
from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line
from pixstep_trials.probe import BoardProbe
from test_lock import errors, ppm, run_line
from test_safety_faults import estop_pin

pytestmark = pytest.mark.usefixtures("simulator")
HZ = 100
UNDERRUN = 1 << 3  # in the mask of faults
HELD_CYCLES = 400  # several periods
FAST = [
    ("mega", {1: 2470}),
    ("mega", {0: 1190, 3: 1190}),
    ("mega", dict.fromkeys(range(4), 590)),
    ("m1284", {0: 2430}),
]


def start(bench, counts, pixels=60):
    """Load a line on each axis and arm them."""
    for axis, count in counts.items():
        bench.load(Line((count,) * pixels, PLAIN), axis)
    bench.arm()


def halt(bench, way):
    """Stop all axes by a command or by the emergency stop, and let them come to rest."""
    if way == "stop":
        bench.board.command("stop", bench.axes)
    else:
        estop_pin(bench, 0)
    bench.sim.wait_s(0.1)
    estop_pin(bench, 1)


def clear(bench):
    """Make the board ready for the next line."""
    bench.board.command("clear_fault", [])
    bench.board.command("discard", bench.axes)
    bench.sim.wait_s(0.05)


@pytest.mark.parametrize("way", ["stop", "estop"])
@pytest.mark.parametrize(("board", "counts"), FAST)
def test_what_was_missed_before_a_halt_is_named(board, counts, way):
    with Bench(board, hz=HZ, axes=tuple(counts)) as bench:
        start(bench, counts)
        bench.run_until_steps(8000, min(counts))
        BoardProbe(bench.sim).hang(0, f"for {HELD_CYCLES}")
        halt(bench, way)
        assert bench.board.input("fault_mask") & UNDERRUN
        assert any(bench.board.axis(axis)["underruns"] for axis in counts)
        clear(bench)
        start(bench, dict.fromkeys(counts, 100))
        bench.sim.wait_s(1)
        assert bench.board.input("fault_mask") == 0
        assert [bench.board.axis(axis)["lines_done"] for axis in counts] == [1] * len(counts)


@pytest.mark.parametrize("way", ["stop", "estop"])
@pytest.mark.parametrize(("board", "counts"), FAST)
def test_nothing_is_named_where_nothing_was_missed(board, counts, way):
    source = random.Random(len(counts))
    with Bench(board, hz=HZ, axes=tuple(counts)) as bench:
        for _ in range(6):
            before = bench.count(min(counts))
            start(bench, counts)
            bench.run_until_steps(before + 3000, min(counts))
            bench.sim.run(source.randint(0, 300_000))
            halt(bench, way)
            assert bench.board.input("fault_mask") & UNDERRUN == 0
            for axis in counts:
                assert bench.board.axis(axis)["position_steps"] == bench.sim.steps(0, axis)
            clear(bench)


# The coarse clock by which time is checked counts overflows of timer 0. If it misses any, parked
# axes would start that much late.
def test_a_coarse_clock_that_lost_time_is_named():
    with Bench("mega", hz=HZ, axes=(2,)) as bench:
        start(bench, {2: 100})
        bench.run_until_steps(300, 2)
        overflows = int.from_bytes(BoardProbe(bench.sim).peek(0, "clock_overflows"), "little")
        BoardProbe(bench.sim).poke(0, "clock_overflows", (overflows - 2).to_bytes(4, "little"))
        bench.sim.wait_s(0.05)
        assert bench.board.input("fault_mask") & UNDERRUN


def run_divided(tmp_path, board, axis, count, divider=3):
    """Run a locked line of pixels of several edges; return how far each ends from its edge."""
    hz = HZ * divider
    with LockBench(board, hz=hz, edges=tmp_path / "edges.csv", axes=(axis,)) as bench:
        bench.follow(divider=divider)
        bench.clock(ppm(hz, 37, boards.load(board).tick_hz))
        return errors(bench, run_line(bench, Line((count,) * 150, PLAIN), axis), divider)


# With a divider the clock has edges inside the pixels, where nothing is known of the interrupt that
# they meet: also the last one of an entry, and one that comes late already.
@pytest.mark.parametrize(("board", "axis", "count"), [("mega", 3, 2190), ("m1284", 1, 2430)])
def test_edges_inside_the_pixels_of_a_fast_axis_lose_no_step(tmp_path, board, axis, count):
    assert len(run_divided(tmp_path, board, axis, count)) == 150


@pytest.mark.parametrize(("board", "axis", "count"), [("mega", 3, 1500), ("m1284", 1, 1800)])
def test_pixels_end_with_the_clock_whose_edges_come_inside_them(tmp_path, board, axis, count):
    assert max(map(abs, run_divided(tmp_path, board, axis, count))) <= 2
