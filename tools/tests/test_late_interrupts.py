# SPDX-License-Identifier: MIT
"""Step interrupts of several axes that come late: made up for to the tick, or named as a fault.

The lines are locked, so that the clock's own edges say where each pixel ends.
"""

import itertools
import random

import pytest

from lockbench import LockBench
from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.edges import read_edges
from test_lock import ppm

HZ = 100
PIXELS = 40
NAMED_WITHIN_S = 0.02  # a period that was made twice (time_check.c), and the host's look
SECONDS = 3


@pytest.fixture
def bench_of(tmp_path):
    """Make benches that record their edges."""
    return lambda board, axes: LockBench(board, hz=HZ, edges=tmp_path / "edges.csv", axes=axes)


def pixels(count):
    """Return the counts of a line's pixels."""
    return [count] * PIXELS if isinstance(count, int) else list(count) * (PIXELS // 2)


def run(bench, counts, period, most=0, seed=0, between=(2000, 4000)):
    """Run a line on each axis, of one count or of two in turn, and hold the processor up.

    Each of these stops takes at most so many cycles, so many cycles behind the one before. Returns
    the fault's name.
    """
    source = random.Random(seed)
    bench.follow()
    run_clock = bench.clock(period).run
    bench.settle()
    for axis, count in counts.items():
        assert bench.load(Line(tuple(pixels(count)), PLAIN), axis).done
    bench.board.command("arm", list(counts))
    bench.until(lambda: all(bench.board.axis(axis)["pixel"] > 1 for axis in counts), SECONDS)

    def run_with_stops(cycles):
        end = bench.sim.cycle + cycles
        while bench.sim.cycle < end:
            run_clock(min(end - bench.sim.cycle, source.randint(*between)))
            bench.sim.hang(0, f"for {source.randint(1, most)}")

    if most:
        bench.sim.run = run_with_stops
    bench.until(
        lambda: all(bench.state(axis) not in ("armed", "running") for axis in counts), SECONDS
    )
    bench.sim.command("flush")
    return bench.fault_name()


def assert_exact(bench, counts, period, seconds_before_end):
    """Each interval is a whole tick beside the ideal one, each pixel ends with the clock's edge."""
    true = [float(edge) for edge in bench.own.true]
    for axis, count in counts.items():
        rising = [int(edge) for edge in read_edges(bench.edges_path).axis(0, axis).rising]
        last = rising[-1] - seconds_before_end * boards.load(bench.name).tick_hz
        edges = [edge for edge in rising if edge <= last]
        ends = list(itertools.accumulate(pixels(count)))
        ideal = [period / n for n in pixels(count) for _ in range(n)]
        assert len(edges) >= ends[5]
        off = [abs(b - a - ideal[k]) for k, (a, b) in enumerate(itertools.pairwise(edges), 1)]
        assert max(off) < 1.05
        found = [edges[end - 1] for end in ends if end <= len(edges)]
        first = min(range(len(true)), key=lambda k: abs(true[k] - found[0]))
        assert max(abs(edge - true[first + k]) for k, edge in enumerate(found)) <= 2


# All step interrupts and the clock's come at once: one of them comes late now and then, and makes up
# for it (step_catch_up.inc). Counts of which both intervals of a train are frequent, and of which
# one is rare; two axes that begin their trains together, and at different steps.
@pytest.mark.parametrize(
    ("counts", "offset"),
    [
        (dict.fromkeys(range(4), 592), -20),
        (dict.fromkeys(range(4), 594), -300),
        (dict.fromkeys(range(4), 586), 100),
        (dict.fromkeys(range(4), 577), 300),
        ({1: 2470}, 0),
        ({3: 2451}, -40),
        ({2: 2474}, 300),
        ({0: 1188, 3: 1182}, 0),
        ({1: 1186, 2: 1186}, -50),
    ],
)
def test_axes_near_their_limit_keep_every_interval(bench_of, counts, offset):
    with bench_of("mega", tuple(counts)) as bench:
        period = ppm(HZ, offset)
        assert run(bench, counts, period) == "none"
        assert_exact(bench, counts, period, 0)


# Whatever holds the processor up: `most` cycles are less than a period without the handlers of the
# other axes and of the clock, and without this axis's own way to OCRnA.
@pytest.mark.parametrize(
    ("board", "counts", "offset", "most"),
    [
        ("mega", {1: 2470}, 0, 45),
        ("mega", {3: 2451}, -40, 45),
        ("mega", {2: 1500}, 40, 60),
        ("mega", {0: 1188, 3: 1182}, 0, 45),
        ("mega", {1: 1100, 2: 1100}, -50, 70),
        ("mega", dict.fromkeys(range(4), 590), 30, 60),
        ("mega", {0: 630, 1: 609, 3: 611}, 30, 100),
        ("m1284", {0: 2430}, 0, 50),
        ("m1284", {0: 1210, 1: 1187}, 0, 80),
    ],
)
def test_a_processor_held_up_moves_no_edge(bench_of, board, counts, offset, most):
    with bench_of(board, tuple(counts)) as bench:
        period = ppm(HZ, offset, boards.load(board).tick_hz)
        assert run(bench, counts, period, most, seed=most) == "none"
        assert_exact(bench, counts, period, 0)


# Held up for longer, a coincidence with a clock edge and the beginning of a train is too much, sooner
# or later. Until then every edge is exact, though hundreds of intervals come late.
@pytest.mark.parametrize(
    ("board", "counts", "offset", "most"),
    [
        ("mega", {1: 2470}, 0, 60),
        ("mega", {2: 1500}, 40, 95),
        ("mega", {0: 1188, 3: 1182}, 0, 85),
        ("mega", {1: 1100, 2: 1100}, -50, 85),
        ("mega", {0: 900, 1: 809}, 30, 120),
        ("mega", dict.fromkeys(range(4), 590), 30, 100),
        ("mega", {0: 630, 1: 609, 3: 611}, 30, 120),
        ("m1284", {0: 2430}, 0, 65),
        ("m1284", {0: 1210, 1: 1187}, 0, 110),
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_edges_are_exact_until_the_fault(bench_of, board, counts, offset, most, seed):
    with bench_of(board, tuple(counts)) as bench:
        period = ppm(HZ, offset, boards.load(board).tick_hz)
        fault = run(bench, counts, period, most, seed)
        assert fault in ("none", "underrun")
        assert_exact(bench, counts, period, 0 if fault == "none" else NAMED_WITHIN_S)


# The first interval of a pixel that differs by more than a tick from the one before: by some ticks, by
# so many that a period without an edge follows, across 256 ticks.
@pytest.mark.parametrize(
    ("counts", "most"),
    [
        ({1: (1500, 1560)}, 60),
        ({3: (2300, 2200)}, 40),
        ({0: (1000, 1030), 3: (1010, 1000)}, 60),
        ({0: (600, 470), 2: (470, 590)}, 100),
        ({1: (700, 600), 3: (622, 630)}, 120),
        ({0: (590, 570), 1: (565, 595), 2: (480, 482), 3: (500, 480)}, 70),
    ],
)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_first_interval_of_a_pixel_is_exact_too(bench_of, counts, most, seed):
    with bench_of("mega", tuple(counts)) as bench:
        period = ppm(HZ, 20)
        fault = run(bench, counts, period, most, seed, between=(500, 900))
        assert fault in ("none", "underrun")
        assert_exact(bench, counts, period, 0 if fault == "none" else NAMED_WITHIN_S)
