# SPDX-License-Identifier: MIT
"""Pixel clocks of kilohertz and smooth rates that the images keep: every edge right, no fault."""

import random
from fractions import Fraction

import pytest

from pixstep.lines.line import PLAIN, Line
from pixstep.simulation import judge
from pixstep.simulation.job import LineExperiment, run_job
from pixstep_dev.bench import clocks, rates
from pixstep_dev.bench.drive import BenchRun
from pixstep_dev.bench.trial import attempt
from pixstep_trials import lines

pytestmark = pytest.mark.usefixtures("simulator")


def assert_clean(board, axes, line, hz, serial_load):
    """Run the line on so many axes at once: every edge right, every step made, no fault."""
    run = BenchRun(board, dict.fromkeys(range(axes), line), Fraction(hz), serial_load=serial_load)
    trial = attempt(run)
    assert (trial.kind, trial.detail) == ("clean", "")
    assert trial.steps == axes * sum(line.counts)


# A little below the highest ones, which differ with an image's layout (docs/TIMING.md).
@pytest.mark.parametrize(
    ("board", "axes", "steps", "hz", "serial_load"),
    [
        ("uno", 1, 20, 5000, False),
        ("uno", 1, 20, 3500, True),
        ("uno", 1, 110, 1000, False),
        ("mega", 4, 20, 1500, True),
        ("mega", 4, 10, 2000, True),
        ("mega", 2, 80, 600, True),
        ("mega", 4, 80, 350, True),
        ("m1284", 2, 20, 2800, True),
    ],
)
def test_axes_of_one_count_keep_up_with_the_clock(board, axes, steps, hz, serial_load):
    line = Line((steps,) * (2 * hz), PLAIN)
    assert_clean(board, axes, line, hz, serial_load)


# Counts of their own in each pixel, sent by a host that reads positions and records meanwhile.
@pytest.mark.parametrize(
    ("board", "axes", "motion", "steps", "hz"),
    [
        ("mega", 4, "streamed", 10, 1950),
        ("mega", 4, "streamed", 20, 1550),
        ("mega", 4, "mixed", 20, 1600),
        ("m1284", 2, "streamed", 20, 3000),
        ("uno", 1, "streamed", 20, 3000),
    ],
)
def test_axes_with_counts_of_their_own_keep_up_with_the_clock(board, axes, motion, steps, hz):
    case = clocks.ClockSearch(board, axes, motion, steps)
    trial = clocks.attempt(case, hz, 2.0)
    assert (trial.kind, trial.detail) == ("clean", "")
    assert trial.steps == sum(sum(case.line(hz, 2.0, axis).counts) for axis in range(axes))


# A smooth line that takes up backlash and comes to its speed within a pixel.
def test_a_smooth_line_keeps_up_with_the_clock():
    case = clocks.ClockSearch("uno", 1, "smooth", 20)
    trial = clocks.attempt(case, 4800, 2.0)
    assert (trial.kind, trial.detail) == ("clean", "")
    line = case.line(4800, 2.0)
    assert trial.steps == line.total_steps > 20 * 4800 * 2.0


# Any real clock drifts away from lines that only begin on it: each edge has an error then, which
# all records take. A locked line's pixels are measured one by one.
@pytest.mark.parametrize(
    ("board", "axes", "motion", "hz", "sync", "ppm"),
    [
        ("mega", 4, "mixed", 1650, "start", -100),
        ("mega", 4, "mixed", 1650, "start", 100),
        ("mega", 4, "mixed", 1300, "lock", -100),
        ("mega", 4, "mixed", 1300, "lock", 100),
        ("uno", 1, "one count", 3000, "lock", -100),
    ],
)
def test_axes_keep_up_with_a_clock_that_is_off(tmp_path, board, axes, motion, hz, sync, ppm):
    case = clocks.ClockSearch(board, axes, motion, 20)
    own = {axis: case.line(hz, 2.0, axis) for axis in range(axes)}
    job = LineExperiment(board, own, Fraction(hz), sync=sync, pixel_ppm=ppm, baud=500_000)
    result = run_job(job, tmp_path)
    assert result.trouble == []
    assert judge.judge(result).summary["reasons"] == []


# Every pixel at the peak accelerates or brakes: at each pixel's edge a curve begins on every axis.
@pytest.mark.parametrize(
    ("board", "axes", "steps_per_s", "hz", "serial_load"),
    [
        ("mega", 4, 30_000, 30, True),
        ("mega", 4, 28_500, 100, False),
        ("mega", 4, 27_000, 100, True),
        ("mega", 2, 52_000, 30, True),
        ("m1284", 2, 60_000, 30, True),
    ],
)
def test_smooth_axes_keep_up(board, axes, steps_per_s, hz, serial_load):
    line = rates.line_of("smooth", steps_per_s // hz // 2 * 2, Fraction(hz), 2.0)
    assert_clean(board, axes, line, hz, serial_load)


# Slow steps are found one by one, by long calculations, while the clock's edges wait: boundary
# speeds wander through small numbers of steps a pixel.
@pytest.mark.parametrize(("hz", "divider"), [(3000, 5), (4000, 30), (4300, 20)])
@pytest.mark.parametrize("sync", ["start", "lock"])
def test_slow_smooth_lines_of_a_divided_clock(tmp_path, hz, divider, sync):
    some = random.Random(hz)
    speeds = [0]
    for _ in range(hz // divider):
        speeds.append(max(2, min(16, speeds[-1] + some.choice((-2, 0, 2)))))
    speeds += range(speeds[-1] - 2, -1, -2)
    line = lines.smooth(speeds)
    job = LineExperiment("uno", {0: line}, Fraction(hz), divider=divider, sync=sync, baud=500_000)
    result = run_job(job, tmp_path)
    assert result.trouble == []
    assert judge.judge(result).summary["reasons"] == []
