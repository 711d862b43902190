# SPDX-License-Identifier: MIT
"""The even speeds of a smooth motor: near the plan, without an oscillation, exact at the end."""

import numpy as np
import pytest

from effort import cases
from pixstep.programs.even_speeds import EvenLimits, EvenSpeeds, oscillates

ROUNDING = 1e-6
FREE = EvenLimits(np.inf)


def means(planned):
    """Return where the motor should be at the edges before the middles: between them."""
    return (planned + np.concatenate([[0.0], planned[:-1]])) / 2


def made(planned, limits, edges=None):
    """Return the counts of a motion by the planned middles of its pixels."""
    speeds = EvenSpeeds(limits)
    edges = means(planned) if edges is None else edges
    return np.concatenate([speeds.counts(planned, edges), speeds.last_counts()])


def middles(speeds, steps=None):
    """Return middles by the planned speeds at edges, so that they end on even steps, at rest."""
    found = np.cumsum(np.asarray(speeds, dtype=float))
    steps = 2 * round(found[-1] / 2) if steps is None else steps
    return np.concatenate([found * steps / found[-1], np.full(3, steps)])


def boundary_speeds(counts):
    """Return the speeds that the board finds: twice the count, less the speed before."""
    speeds = [0]
    for count in counts.tolist():
        speeds.append(2 * count - speeds[-1])
    return np.array(speeds)


def off_steps(counts, planned):
    """Return by how much positions at pixel edges differ from those between planned middles."""
    return np.abs(np.cumsum(counts) - means(planned))


def swings(counts):
    """Whether the board takes any two equal counts for an oscillation."""
    speeds = boundary_speeds(counts)
    around = np.abs(speeds[:-2] - counts[:-1])
    return bool(np.any((np.diff(counts) == 0) & (around > 2) & (100 * around > counts[:-1])))


def random_speeds(rng, most):
    """Return planned speeds from rest to rest, of accelerations up to `most`."""
    speeds = [0.0]
    for _ in range(int(rng.integers(4, 60))):
        change = most * rng.choice([-1, 0, 1]) if rng.random() < 0.5 else rng.uniform(-most, most)
        speeds.append(float(np.clip(speeds[-1] + change, 0, 200)))
    while speeds[-1] > 0:
        speeds.append(max(0.0, speeds[-1] - most))
    return [*speeds, most]  # that anything moves


def test_random_speeds_become_even_ones_near_by():
    """Whatever the parts are in which they come.

    These speeds change as no plan's do. One line in fifty finds no way that keeps its edges within
    a step; then they are within two, and all else holds.
    """
    rng, far, lines = np.random.default_rng(1), 0, cases(300, 5000)
    for _ in range(lines):
        planned = middles(random_speeds(rng, float(rng.integers(2, 40))))
        counts = made(planned, FREE)
        speeds = EvenSpeeds(FREE)
        cuts = np.flatnonzero(rng.random(len(planned)) < 0.2)
        parts = zip(np.split(planned, cuts), np.split(means(planned), cuts), strict=True)
        one_by_one = [*(speeds.counts(*part) for part in parts), speeds.last_counts()]
        assert np.array_equal(counts, np.concatenate(one_by_one))
        assert len(counts) == len(planned) and counts.sum() == planned[-1]
        found = boundary_speeds(counts)
        assert found.min() >= 0 and found[-1] == 0 and not np.any(found % 2)
        assert not swings(counts)
        off = off_steps(counts, planned).max()
        assert off <= 2 + ROUNDING
        far += off > 1 + ROUNDING
    assert far <= lines / 25


@pytest.mark.parametrize("peak", [20, 20.4, 19.6, 21])
@pytest.mark.parametrize("around", [0, 8, 12.3])
def test_a_peak_between_equal_speeds_is_no_oscillation(peak, around):
    """The nearest even speeds oscillate, in the line and in its last pixels."""
    for before, behind in ((3, 3), (3, 0), (0, 3)):
        ramp = [around / 3, around * 2 / 3] if around else []
        speeds = [*ramp, *[around] * before, around, peak, around, *[around] * behind, *ramp[::-1]]
        planned = middles(speeds)
        counts = made(planned, FREE)
        assert not swings(counts) and counts.sum() == planned[-1]
        assert boundary_speeds(counts)[-1] == 0
        assert off_steps(counts, planned).max() <= 1 + ROUNDING


@pytest.mark.parametrize("peak", [20, 20.9, 19.2])
def test_limits_hold_where_an_oscillation_is_avoided(peak):
    planned = middles([4, 12, 20, 12, peak, 12, 20, 12, 4])
    for limits in (EvenLimits(12, 22), EvenLimits(12, 20), EvenLimits(10, 22)):
        counts = made(planned, limits)
        speeds = boundary_speeds(counts)
        assert not swings(counts)
        assert speeds.max() <= limits.speed
        assert np.abs(np.diff(speeds)).max() <= limits.acceleration
        assert off_steps(counts, planned).max() <= 1 + ROUNDING


def test_what_the_board_takes_for_an_oscillation():
    assert oscillates(np.array([0, 6, 26, 32])).tolist() == [True]  # speeds 6, 20, 6
    assert oscillates(np.array([0, 6, 26, 34])).tolist() == [False]
    assert oscillates(np.array([0, 10, 24, 34])).tolist() == [False]  # 2 around 12: a ripple
    assert oscillates(np.array([0, 10, 26, 36])).tolist() == [True]
    assert oscillates(np.array([0, 600, 1206, 1806])).tolist() == [False]  # 1 % of 603


def test_a_motion_without_a_step():
    assert made(np.zeros(5), EvenLimits(8)).tolist() == [0] * 5
