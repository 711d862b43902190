# SPDX-License-Identifier: MIT
"""Smooth motors of motion programs: their limits, the path, plain motors beside them."""

from dataclasses import replace

import numpy as np
import pytest

from effort import cases
from pixstep.errors import RefusedError
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.programs.language import ProgramError
from programbench import CHORDS, path, path_distance, planned, random_program, setup

# Some of these would have equal counts around a peak, at the end or beside their highest speed.
PEAKS = {97, 296, 365, 542, 653, 705, 764}
# A corner in the last pixel, a rest on odd steps in the middle, a path that bends within a pixel.
CORNERS = {3507, 4020, 4152, 5038, 12710}


@pytest.mark.parametrize("seed", sorted({*range(cases(80, 1000)), *PEAKS, *CORNERS}))
def test_smooth_motors_stay_within_their_limits_as_the_board_decodes_them(seed):
    rng = np.random.default_rng(seed)
    hz = int(rng.choice([50, 100, 200]))
    pixel, motors = 1000 / hz, int(rng.integers(1, 4))
    of = setup(
        rng.uniform(6, 200) / pixel**2, motors, hz, rng.uniform(20, 400) / pixel, smooth=True
    )
    text, distance = random_program(rng, motors, int(rng.integers(1, 20)), rising=True)
    counts, report = planned(text, of)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    for index, motor in enumerate(report.motors):
        assert motor.counted_acceleration <= motor.limit // 2 * 2
        assert motor.counted_speed <= motor.motor.max_speed * pixel
        assert motor.speed == 0
        line = Line(tuple(counts[:, index].tolist()))
        found = line_check.without_idle_pixel(line_check.check(line))
        assert not [item for item in found if item.severity == line_check.ERROR]
    assert path_distance(counts, path(text, of)) <= 1 + CHORDS
    assert path_distance(counts, path(text, of)) - CHORDS <= report.off_path <= 1 + CHORDS


# Programs that are known to leave the path farther than promised, steps: PROGRAMS.md has them.
FARTHER = {251: 1.14}


@pytest.mark.parametrize("seed", range(cases(20, 300)))
def test_plain_motors_stay_beside_smooth_ones(seed):
    """On the path together, each within its own limits."""
    rng = np.random.default_rng(seed)
    hz = int(rng.choice([50, 100, 200]))
    pixel, motors = 1000 / hz, int(rng.integers(2, 5))
    of = setup(rng.uniform(20, 200) / pixel**2, motors, hz, rng.uniform(20, 400) / pixel)
    smooth = [True, False, *(bool(rng.integers(2)) for _ in range(motors - 2))]
    of = replace(
        of, motors=tuple(replace(m, smooth=one) for m, one in zip(of.motors, smooth, strict=True))
    )
    text, distance = random_program(rng, motors, int(rng.integers(1, 20)), rising=True)
    counts, report = planned(text, of)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    for motor in report.motors:
        assert motor.counted_ratio <= 1 and motor.counted_speed <= motor.motor.max_speed * pixel + 1
    most = FARTHER.get(seed, 1)
    assert path_distance(counts, path(text, of)) <= most + CHORDS
    assert path_distance(counts, path(text, of)) - CHORDS <= report.off_path <= most + CHORDS


def test_a_smooth_motor_goes_the_way_that_the_program_says():
    """Its line cannot say so: the sign of the counts does, for the direction of the line."""
    text = "INC TS0 TA9 TM40 X-90 Y50\nX-200 Y20"
    counts, report = planned(text, setup(0.5, 2, 100, smooth=True))
    assert counts.sum(axis=0).tolist() == [-290, 70]
    assert np.all(counts[:, 0] <= 0) and np.all(counts[:, 1] >= 0)
    assert [motor.steps for motor in report.motors] == [-290, 70]
    mirrored = planned(text.replace("X-", "X"), setup(0.5, 2, 100, smooth=True))[0]
    assert np.array_equal(np.abs(counts), mirrored)


def test_a_turn_in_less_than_a_pixel_may_be_farther_off_which_is_told():
    """Motors that stop for a moment turn as they like there: no bend says how the way turns."""
    text = "INC TS0 TA1 TM4\nX400 Y40\nDELAY1\nX40 Y400"
    of = setup(25.0, 2, 50, smooth=True)
    counts, report = planned(text, of)
    assert report.off_path > 1
    assert report.off_path == pytest.approx(path_distance(counts, path(text, of)), abs=0.01)


def test_a_smooth_motor_needs_more_than_four_steps_a_pixel_squared():
    with pytest.raises(RefusedError, match=r"motor X: 4 steps/px2 .* a pixel longer than 2 ms"):
        planned("TS0 TA9 TM9 X10", setup(1, hz=500, smooth=True))
    assert planned("TS0 TA9 TM9 X10", setup(1.1, hz=500, smooth=True))[0].sum() == 10


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("TS0 TA9 TM9 X10\nX4", r"p.pmc:2:1: motor X is smooth and would turn round"),
        ("TS0 TA9 TM9 X10\nX13", r"p.pmc:2:1: motor X is smooth and would stop at step 13.*12 and"),
    ],
)
def test_what_a_smooth_motor_cannot_do(text, message):
    with pytest.raises(ProgramError, match=message):
        planned(text, setup(1, hz=100, smooth=True))
