# SPDX-License-Identifier: MIT
"""mode1: whatever the limits, the path is that of the unlimited program; they are kept or told."""

from dataclasses import replace

import numpy as np
import pytest

from effort import cases
from pixstep.programs.two_moves import TwoMoves
from programbench import (
    CHORDS,
    RUN_IN,
    SHORT_MOVES,
    events,
    path,
    path_distance,
    planned,
    random_program,
    setup,
)

NO_LIMIT = 1e9
TOLERANCE = 1 + 1e-6
CORNER = "INC TS0 TA10 TM100\nX2000\nY2000"


def mode1(text, of, **options):
    return planned(text, of, mode="mode1", **options)


def made(seed):
    """Return a random program, its distances, and motors with limits of their own."""
    rng = np.random.default_rng(seed)
    motors = int(rng.integers(1, 5))
    accelerations = 10 ** rng.uniform(-2, 0.5) * rng.uniform(0.2, 5, motors)
    text, distance = random_program(rng, motors, int(rng.integers(1, 15)))
    if seed % 4 == 0:
        text += "\nDWELL7.5\n" + " ".join(f"{word}-50" for word in "XYZA"[:motors])
        distance = distance - 50
    return text, distance, setup(accelerations, motors, speed=rng.choice([3.0, 1e9], motors))


def unlimited(text, of):
    """Return the path that the blends have without a limit."""
    return path(text, setup(NO_LIMIT, len(of.motors)))


def kept(report):
    """Whether every limit is kept by the plan and by the counts."""
    return all(
        motor.planned_ratio <= TOLERANCE
        and motor.speed_ratio <= TOLERANCE
        and motor.counted_ratio <= 1
        for motor in report.motors
    )


def test_a_limit_stretches_both_moves_and_the_corner_is_passed_as_without_it():
    free, bound = setup(NO_LIMIT, 2), setup([0.5, 4.0], 2)
    for of in (free, bound):
        places = np.cumsum(mode1(CORNER, of)[0], axis=0)
        assert [1975, 25] in places.tolist()
    first, second = TwoMoves(bound).timed(events(CORNER, bound))
    assert (first.tm, second.tm, second.ta) == (200, 200, 20)  # 20 counts/ms in 10 ms is 2
    report = mode1(CORNER, bound)[1]
    assert [item["why"] for item in report.slowed] == ["acceleration of X"] * 2
    assert report.total_ms == pytest.approx(420)  # TA of the start and of the stop 20 as well


@pytest.mark.parametrize("seed", range(cases(12, 330)))
def test_random_programs_keep_the_unlimited_path_and_every_limit(seed):
    text, distance, of = made(seed)
    counts, report = mode1(text, of)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    assert path_distance(counts, unlimited(text, of)) <= 0.5 + CHORDS
    assert kept(report) and report.whole


# Of the last four the corner before the last move has no way left on the move before it.
@pytest.mark.parametrize("seed", sorted({*range(cases(8, 330)), 71, 178, 193, 316}))
def test_without_the_last_assumed_what_exceeds_a_limit_is_said(seed):
    """The path stays, too."""
    text, distance, of = made(seed)
    counts, report = mode1(text, of, assume_last=False)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    assert path_distance(counts, unlimited(text, of)) <= 0.5 + CHORDS
    worst = max(max(motor.planned_ratio, motor.speed_ratio) for motor in report.motors)
    assert report.whole == (worst <= TOLERANCE)
    if not report.whole:
        assert max(item["ratio"] for item in report.violations) == pytest.approx(worst, rel=0.02)


def test_the_random_programs_need_the_limits():
    slower = 0
    for seed in range(12):
        text, _, of = made(seed)
        slower += mode1(text, of)[1].total_ms > 1.05 * unlimited(text, of).du.sum()
    assert slower >= 6


def test_the_last_stop_uses_both_moves_that_are_open():
    """The last one alone stops with 15.4 times the limit, in its programmed time with 16.7 times.

    Two stop with 5: from 50 counts/ms TM is 2.76, which is TA as well, and 4.47, which is the
    stop's TA.
    """
    report = mode1(RUN_IN, setup(1), assume_last=False)[1]
    assert 5 <= report.motors[0].planned_ratio <= 5.05
    assert report.reasons["stop in 2 moves"] == 2


def test_a_stop_behind_a_corner_uses_the_move_before_it():
    """Blends take a quarter of a move: 50 counts are left in the first one, 75 in the last one."""
    text, of = "INC\nTS0 TA50 TM100 X5000\nTA1 TM2 X100\nX100 Y1", setup([1.0, 10.0], 2)
    counts, report = mode1(text, of, assume_last=False)
    assert path_distance(counts, unlimited(text, of)) <= 0.5 + CHORDS
    assert 10 <= report.motors[0].planned_ratio <= 10.1  # 50^2 / 2 (50 + 75)


@pytest.mark.parametrize(("text", "ms"), [(SHORT_MOVES, 510), (RUN_IN, 667.913)])
def test_short_moves_take_the_time_that_their_stops_ask(text, ms):
    assert mode1(text, setup(1))[1].total_ms == pytest.approx(ms, abs=1e-3)


def test_a_move_before_a_slower_one_slows_down_on_its_straight_part():
    """The corner bears 50 counts/ms, the short move behind it can stop from 10."""
    text = "INC TS0 TA50 TM100 X5000\nTA1 TM2 X100 Y5"
    report = mode1(text, setup([1.0, 10.0], 2))[1]
    assert report.motors[0].planned_speed == pytest.approx(50) and kept(report)
    # Up, level, from 50 to 10, half of the corner, the second move at 10, half of its stop.
    level = (5000 - 1250 - 1200 - 25) / 50
    assert report.total_ms == pytest.approx(50 + level + 40 + 2.5 + 10 + 5, abs=1e-3)


@pytest.mark.parametrize("seed", range(cases(8, 200)))
def test_smooth_motors_stay_on_the_unlimited_path_within_a_step(seed):
    rng = np.random.default_rng(seed)
    hz, motors = int(rng.choice([50, 100, 200])), int(rng.integers(1, 4))
    pixel = 1000 / hz
    of = setup(rng.uniform(6, 200) / pixel**2, motors, hz, rng.uniform(20, 400) / pixel)
    of = replace(of, motors=tuple(replace(motor, smooth=True) for motor in of.motors))
    text, distance = random_program(rng, motors, int(rng.integers(1, 20)), rising=True)
    counts, report = mode1(text, of)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    assert path_distance(counts, unlimited(text, of)) <= 1 + CHORDS
    assert kept(report)
