# SPDX-License-Identifier: MIT
"""The play model and the laying over, against the published errors of a circle."""

import functools
import math
from itertools import accumulate, pairwise

import pytest

from pixstep.reversals.compensate import MotionLimits, TakeUpRequest, compensate, load_positions

# The published circle: 1 638 400 counts an inch, 8192 points a revolution, play 7485 counts.
INCH = 1_638_400
SLOP = 7485
POINTS = 8192
SMALL, LARGE = 102_400, 3_276_800  # radii of the 1/8 in and the 4 in circle, counts
TABLE = {  # points of the transition: largest error in inches, small and large circle
    8: (0.000001, 0.000038),
    16: (0.000005, 0.000151),
    32: (0.000019, 0.000495),
    64: (0.000073, 0.001284),
    100: (0.000172, 0.001963),
    128: (0.000268, 0.002332),
    150: (0.000353, 0.002559),
    200: (0.000563, 0.002960),
    256: (0.000806, 0.003242),
    512: (0.001735, 0.003847),
    1024: (0.002696, 0.004184),
}


@functools.cache
def circle(radius):
    """One coordinate of a circle in counts, a revolution and a half from its largest value."""
    return [int(radius * math.cos(2 * math.pi * i / POINTS)) for i in range(POINTS * 3 // 2 + 1)]


def straight_ramps(ideal, points):
    """Motor positions with a straight take-up after each turn of a circle, as published.

    The ramp is at 0 on the first point that has moved back: one point after the turn.
    """
    motor, starts = [], (POINTS // 2 + 1, POINTS + 1)
    for i, position in enumerate(ideal):
        done = [min(1.0, max(0.0, (i - start) / points)) for start in starts]
        motor.append(round(position + SLOP * (done[0] - done[1])))
    return motor


def radius_error(load, radius):
    """Largest error of the radius when one coordinate is the load's and the other is right."""
    other = (radius * math.sin(2 * math.pi * i / POINTS) for i in range(len(load)))
    return max(abs(math.hypot(a, b) - radius) for a, b in zip(load, other, strict=True))


def load_on_circle(motor):
    """The load's coordinate; the play is taken up in the direction of the first motion, -."""
    start = motor[0]
    return [start + a for a in load_positions([b - start for b in motor], SLOP, -1)]


def tolerance(inches):
    """2 %, and one count."""
    return 0.02 * inches * INCH + 1


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("points", TABLE)
def test_published_table_of_an_ideal_servo(points, column):
    radius = (SMALL, LARGE)[column]
    worst = radius_error(load_on_circle(straight_ramps(circle(radius), points)), radius)
    assert abs(worst - TABLE[points][column] * INCH) <= tolerance(TABLE[points][column])


@pytest.mark.parametrize("column", [0, 1])
def test_without_compensation_the_circle_is_off_by_the_play(column):
    ideal = circle((SMALL, LARGE)[column])
    assert max(abs(a - b) for a, b in zip(load_on_circle(ideal), ideal, strict=True)) == SLOP


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("points", TABLE)
def test_our_transitions_are_no_worse_than_the_published_ones(points, column):
    radius = (SMALL, LARGE)[column]
    counts = [b - a for a, b in pairwise(circle(radius))]
    free = MotionLimits(10_000, 10_000)
    made = compensate(counts, TakeUpRequest(SLOP, free, points))
    assert [item.steps for item in made.transitions] == [SLOP, SLOP]
    assert made.worst_outside == 0
    motor = list(accumulate(made.counts, initial=radius))
    worst = radius_error(load_on_circle(motor), radius)
    assert worst <= TABLE[points][column] * INCH + tolerance(TABLE[points][column])
