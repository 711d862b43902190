# SPDX-License-Identifier: MIT
"""The reference against the anchors of the specification and against itself."""

import random
from fractions import Fraction

import numpy as np
import pytest

from clock import TICK_HZ
from pixstep.lines import exact
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import edge_tick, period_ticks
from pixstep_trials.cases import plain_case, smooth_case
from plan_judge import brute_force_positions
from worked import ACCELERATING, EXPECTED, worked_line

ONE = Fraction(1)


def pixel_times(counts, pixel, period=ONE):
    line = Line(tuple(counts))
    return [float(t) - (pixel - 1) for p, t in exact.exact_instants(line, period) if p == pixel]


def test_step_times_from_rest():
    assert pixel_times([4], 1) == pytest.approx([0.5, 0.707107, 0.866025, 1.0], abs=1e-6)


def test_step_times_decelerating_to_rest():
    assert pixel_times([4, 4], 2) == pytest.approx([0.133975, 0.292893, 0.5, 1.0], abs=1e-6)


def test_step_times_accelerating_from_eight():
    anchors = [0.11803, 0.22474, 0.32288, 0.41421, 0.5, 0.58114]
    anchors += [0.65831, 0.73205, 0.80278, 0.87083, 0.93649, 1.0]
    assert pixel_times([4, 12], 2) == pytest.approx(anchors, abs=1e-5)


@pytest.mark.parametrize("backlash", [0, 250, 1000])
def test_worked_example_expected_positions(backlash):
    line = worked_line(backlash, pixels=60)
    assert exact.expected_positions(line)[:17] == EXPECTED[backlash]
    assert exact.expected_positions(line)[-1] == line.total_steps


def test_worked_example_counts():
    line = worked_line(250, pixels=60)
    assert list(line.counts[:16]) == [0, *ACCELERATING]
    assert list(line.counts[-16:]) == [*reversed(ACCELERATING), 0]


@pytest.mark.parametrize("seed", range(12))
def test_closed_form_equals_brute_force(seed):
    rng = random.Random(seed)
    for make in (smooth_case, plain_case):
        case = make(rng)
        brute = brute_force_positions(case.line, case.period)
        assert exact.expected_positions(case.line) == brute


@pytest.mark.parametrize("part", ["0", "1", "V/4", "V-1", "V"])
@pytest.mark.parametrize("hz", [Fraction(30), Fraction(2997, 100), Fraction(30000, 1001)])
def test_backlash_table_equals_brute_force(part, hz):
    speed = 128
    backlash = {"0": 0, "1": 1, "V/4": speed // 4, "V-1": speed - 1, "V": speed}[part]
    zero = (0,) if backlash else ()
    line = Line((*zero, 10, 42, 96, 128, 128, 100, 50, 14, *zero), backlash=backlash)
    assert line.speeds[-1] == 0 and line.line_speed == speed
    brute = brute_force_positions(line, period_ticks(hz, TICK_HZ))
    assert exact.expected_positions(line) == brute


@pytest.mark.parametrize("seed", range(6))
def test_fast_path_agrees_with_exact(seed):
    case = smooth_case(random.Random(seed))
    fast = exact.instants(case.line, case.period)
    slow = [t for _, t in exact.exact_instants(case.line, case.period)]
    assert len(fast) == len(slow) == case.line.total_steps
    # where an instant is a whole tick the float may fall just below it
    floors = np.array([t.floor() for t in slow])
    assert np.all(fast - floors > -1e-6) and np.all(fast - floors < 1 + 1e-6)


def test_last_step_of_a_pixel_is_on_its_edge():
    case = smooth_case(random.Random(3))
    slow = [t for _, t in exact.exact_instants(case.line, case.period)]
    for pixel, done in exact.edge_ends(case.line):
        assert slow[done - 1].floor() == edge_tick(pixel, case.period)
        assert slow[done - 1].at_or_before(pixel * case.period)


def test_instants_never_go_back():
    for seed in range(8):
        case = smooth_case(random.Random(seed))
        assert np.all(np.diff(exact.instants(case.line, case.period)) > 0)


def test_strictly_within_one():
    half = exact.Instant(5, 0, 0, 2)  # 2.5
    assert [half.strictly_within_one(t) for t in (1, 2, 3, 4)] == [False, True, True, False]
    whole = exact.Instant(6, 0, 0, 2)  # 3
    assert [whole.strictly_within_one(t) for t in (2, 3, 4)] == [False, True, False]
    root = exact.Instant(0, -1, 2, 1)  # -sqrt(2)
    assert root.floor() == -2 and root.at_or_before(Fraction(-1)) and not root.is_integer()
    assert not root.at_or_before(Fraction(-3, 2))


def test_plain_line_is_signed():
    line = Line((3, 0, -2), PLAIN)
    assert exact.expected_positions(line) == [3, 3, 1]
    assert list(exact.directions(line)) == [1, 1, 1, -1, -1]
