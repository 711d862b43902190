# SPDX-License-Identifier: MIT
"""Moves and jogs by speed, base speed and acceleration, as whole steps in pixels."""

import random
from itertools import pairwise

import pytest

from pixstep.lines.runs import MAX_REPEAT, decode
from pixstep.moves.trapezoid import JogLaw, MoveKinematics, Trapezoid, merged, ramp_counts, spread

CASES = 1500


def chosen_moves():
    """Return random moves: steps, kinematics, frequency of pixels."""
    chosen = random.Random(7)
    for _ in range(CASES):
        hz = chosen.choice([1, 30, 100, 1000 / 3, 2000])
        wanted = MoveKinematics(
            10 ** chosen.uniform(-1, 4.5),
            chosen.choice([0, 1]) * 10 ** chosen.uniform(-1, 3),
            chosen.choice([0, 1, 1]) * 10 ** chosen.uniform(0, 6),
        ).within(1000, hz)
        steps = chosen.choice([1, -1, 2, -7, 100, -1000, chosen.randint(1, 20_000)])
        if abs(steps) / wanted.speed_steps_s * hz < 20_000:
            yield steps, wanted, hz


def test_a_move_has_its_steps_its_time_and_its_speed():
    for steps, wanted, hz in chosen_moves():
        move = Trapezoid(steps, wanted, hz)
        runs = list(move.runs())
        assert sum(count * repeat for count, repeat in runs) == steps
        assert sum(repeat for _, repeat in runs) == move.pixels
        assert 0 <= move.lasts_s - move.seconds < 1 / hz + 1e-6
        assert all(count * steps >= 0 and 0 < repeat <= MAX_REPEAT for count, repeat in runs)
        assert max(abs(count) for count, _ in runs) < wanted.speed_steps_s / hz + 1.0001


def test_a_move_follows_its_trapezoid():
    wanted, hz = MoveKinematics(3000, 300, 9000).within(1000, 100), 100
    counts = decode(Trapezoid(3000, wanted, hz).runs())
    ramp_s = 2700 / 9000
    made = 0
    for pixel, count in enumerate(counts, 1):
        made += count
        at_s = pixel / hz
        if at_s <= ramp_s:
            assert abs(made - (300 + 4500 * at_s) * at_s) <= 0.5
    assert counts[0] == pytest.approx(counts[-1], abs=1) and max(counts) == 30
    # Counts are differences of rounded positions: theirs are within 2 of the acceleration.
    assert all(abs(one - other) < 0.9 + 2 for one, other in pairwise(counts))


def test_a_constant_speed_of_many_steps_is_one_run():
    move = Trapezoid(1_000_000, MoveKinematics(4000, 0, 20_000).within(1000, 30), 30)
    runs = list(move.runs())
    assert len(runs) < 20 and max(runs, key=lambda run: run[1])[0] == 133


def test_slow_steps_are_even():
    counts = decode(Trapezoid(40, MoveKinematics(7), 100).runs())
    places = [pixel for pixel, count in enumerate(counts) for _ in range(count)]
    assert {later - one for one, later in pairwise(places)} <= {13, 14, 15, 16}


def test_steps_are_spread_evenly():
    for steps, pixels in ((0, 5), (3, 20), (20, 3), (7, 7), (1, 1), (19, 20)):
        counts = decode(spread(steps, pixels))
        assert len(counts) == pixels and sum(counts) == steps and max(counts) - min(counts) <= 1
    assert list(merged([(1, 2), (1, 3), (0, 0), (2, 1), (2, 70_000)])) == [
        (1, 5), (2, 65_535), (2, 4466),
    ]  # fmt: skip


def test_a_jog_accelerates_changes_its_speed_and_turns():
    hz, law = 100, JogLaw(100, turns_below_steps_px=5, rest_px=2)
    counts = decode(law.pixels(MoveKinematics(1000, 100, 2000), 1, 100))
    assert counts[0] <= 2 and counts[-1] == 10 and law.steps_s == 1000
    assert all(later - one < 0.2 + 2 for one, later in pairwise(counts))
    counts = decode(law.pixels(MoveKinematics(2000, 100, 2000), 1, 60))
    assert counts[-1] == 20
    counts = decode(law.pixels(MoveKinematics(1500, 100, 2000), -1, 300))
    assert counts[-1] == -15 and law.steps_s == -1500
    sudden = decode(law.pixels(MoveKinematics(1500), 1, 3))
    assert sudden[:2] == [0, 0] and sudden[-1] == 15  # it rests before it turns
    assert len(sudden) == 5 and hz == 100


def test_the_ramp_of_a_seek_rises_to_its_speed():
    assert ramp_counts(MoveKinematics(1000, 100, 2000), 100)[-1] == 10
    for wanted in (MoveKinematics(10, 0, 100), MoveKinematics(5000), MoveKinematics(3000, 50, 1e6)):
        counts = ramp_counts(wanted, 100)
        assert counts == sorted(counts) and counts[0] >= 1
        assert counts[-1] == max(1, int(wanted.speed_steps_s / 100))
