# SPDX-License-Identifier: MIT
"""Motion programs: blended moves, the two-move planner and the look-ahead, figure by figure."""

import math
from itertools import pairwise

import numpy as np
import pytest

import optimum
from effort import cases
from pixstep.programs.blends import NominalPath, nominal
from pixstep.programs.language import ProgramError
from pixstep.programs.pixels import timelines
from pixstep.programs.time_law import TimeLaw
from pixstep.programs.two_moves import TwoMoves
from programbench import (
    CHORDS,
    RUN_IN,
    SHORT_MOVES,
    events,
    limits,
    path,
    path_distance,
    planned,
    random_program,
    setup,
)

NO_LIMIT = 1e9


def total_ms(moves):
    moves = list(moves)
    return moves[0].ta / 2 + sum(move.tm for move in moves) + moves[-1].stop_ta / 2


def mode1(text, of, **options):
    return list(TwoMoves(of, **options).timed(events(text, of)))


# Blends


def test_two_moves_have_the_knots_of_the_anchor():
    of = setup(NO_LIMIT)
    found = path("INC TS0 TM250 TA100 X20000\nTA250 X80000", of)
    blends = ~found.straight
    stop = np.flatnonzero(found.bend[:, 0] < 0)[:1]  # which follows the last blend at once
    changes = np.flatnonzero(np.diff(blends.astype(int))) + 1
    times = np.concatenate([[0], np.cumsum(found.du)])
    knots = times[np.concatenate([[0], changes, stop, [len(found)]])]
    assert knots == pytest.approx([0, 100, 175, 425, 675], abs=1e-9)
    speeds = np.interp([0, 100, 175, 425], times[:-1], found.speed[:, 0])
    assert speeds == pytest.approx([0, 80, 80, 320], abs=1e-9)
    assert found.place[-1, 0] < 100_000


def test_a_blend_cannot_begin_before_the_last_one_has_ended():
    first, second = nominal(events("INC TS0 TM100 TA50 X1000\nTA300 X3000", setup(NO_LIMIT)))
    assert (first.tm, second.tm, second.ta) == (100, 300, 150)
    assert 3000 / second.tm == 10


def test_the_acceleration_time_is_the_least_time_of_a_move():
    (move,) = nominal(events("INC TA10 TS50 TM20 X100", setup(NO_LIMIT)))
    assert (move.tm, move.ta, move.ts) == (100, 100, 50)
    assert mode1("INC TA10 TS50 TM20 X100", setup(NO_LIMIT))[0].tm == 100


def test_a_single_move_takes_its_time_and_an_acceleration_time():
    of = setup(NO_LIMIT)
    assert total_ms(nominal(events("INC TS0 TA30 TM100 X500", of))) == 130
    assert total_ms(nominal(events("INC TS0 TA50 TM10 X500", of))) == 100  # twice TA


@pytest.mark.parametrize("ts", [0, 10, 50])
def test_distances_and_the_highest_acceleration_of_a_blend(ts):
    found = path(f"INC TA100 TS{ts} TM200 X1000 Y-300\nX2000 Y900", setup(NO_LIMIT, 2))
    du = found.du[:, None]
    ends = found.place + du * (found.speed + du * (found.bend / 2 + du * found.twist / 6))
    assert ends[:-1] == pytest.approx(found.place[1:], abs=1e-9)  # no gap
    assert ends[-1] == pytest.approx([3000, 600], abs=1e-9)
    change = np.array([1000 / 200, -300 / 200])
    highest = np.abs(found.bend[found.move == 0]).max(axis=0)
    assert highest == pytest.approx(np.abs(change) / (100 - ts))


def test_a_dwell_ends_blending_and_a_delay_does_not():
    of = setup(NO_LIMIT)
    stops = planned("INC TS0 TA10 TM100 X100\nDWELL50\nX100", of)[1].total_ms
    assert stops == pytest.approx(110 + 50 + 110)
    runs = planned("INC TS0 TA10 TM100 X100\nDELAY50\nX100", of)[1].total_ms
    assert runs == pytest.approx(5 + 100 + 50 + 100 + 5)


# mode1


def test_each_move_can_stop_inside_of_itself():
    moves = mode1(SHORT_MOVES, setup(1))
    assert {move.tm for move in moves} == {10.0}
    assert total_ms(moves) == pytest.approx(510, abs=1e-9)
    fast = mode1(SHORT_MOVES, setup(25))
    assert {move.tm for move in fast} == {2.0} and total_ms(fast) == pytest.approx(102, abs=1e-9)


def test_the_run_in_does_not_help_two_moves():
    moves = mode1(RUN_IN, setup(1))
    assert moves[1].tm == pytest.approx(47.91, abs=0.005)
    assert {round(move.tm, 9) for move in moves[2:]} == {10.0}
    assert total_ms(moves) == pytest.approx(667.9, abs=0.05)


def test_without_the_last_assumed_a_stop_exceeds_the_limit():
    two = TwoMoves(setup(1), assume_last=False)
    list(two.timed(events(RUN_IN, setup(1))))
    worst = max(item["ratio"] for item in two.violations)
    assert two.violated and 5.02 <= worst <= 16.67
    counts, report = planned(RUN_IN, setup(1), mode="mode1", assume_last=False)
    assert not report.whole and counts.sum() == 10_000
    assert 5.02 <= report.motors[0].planned_ratio <= 16.67
    assert planned(RUN_IN, setup(1))[1].motors[0].planned_ratio <= 1 + 1e-9


def test_both_motors_are_stretched_and_the_path_stays():
    text = "INC TS0 TA10 TM100 X1000 Y100\nX1000 Y-100\nX-500 Y50"
    free, bound = setup(NO_LIMIT, 2), setup([0.3, NO_LIMIT], 2)
    for mode in ("mode1", "lookahead"):
        counts, report = planned(text, bound, mode=mode)
        assert report.motors[0].planned_ratio == pytest.approx(1, abs=1e-6)
        assert report.total_ms > 1.04 * planned(text, free, mode=mode)[1].total_ms
        assert counts.sum(axis=0).tolist() == [1500, 50]
        assert report.slowed and "X" in report.slowed[0]["why"]
    assert path_distance(planned(text, bound)[0], path(text, bound)) <= 0.5 + CHORDS


# lookahead


def test_the_gain_of_looking_ahead():
    for text, least in ((SHORT_MOVES, 150), (RUN_IN, 250)):
        found = planned(text, setup(1))[1].total_ms
        assert least - 1e-6 <= found <= 1.02 * least


@pytest.mark.parametrize("text", [SHORT_MOVES, RUN_IN])
def test_a_longer_window_is_never_slower_and_enough_is_all(text):
    of = setup(1)
    times, ratios = [], []
    for window in (1, 2, 4, 8, 16, 32, 64):
        report = planned(text, of, window=window)[1]
        times.append(report.total_ms)
        ratios.append(report.motors[0].planned_ratio)
    assert all(late <= early + 1e-9 for early, late in pairwise(times))
    assert max(ratios) <= 1 + 1e-9
    enough = math.ceil(4 / 3 * 50 / 2 / 2)  # of moves of 2 ms: 4/3 of half the time to stop
    whole = planned(text, of)[1].total_ms
    assert planned(text, of, window=enough)[1].total_ms == pytest.approx(whole, abs=1e-6)
    assert times[0] > 1.3 * whole


@pytest.mark.parametrize("ts", [0, 7, 20])
def test_where_no_limit_is_near_the_program_is_run_as_it_is(ts):
    text = f"INC TA30 TS{ts} TM80 X900 Y10\nX-300 Y400\nX100 Y700\nDWELL40\nX30"
    of = setup(NO_LIMIT, 2)
    nominal_ms = path(text, of).du.sum()
    ahead, two = planned(text, of), planned(text, of, mode="mode1")
    assert ahead[1].total_ms == pytest.approx(nominal_ms, abs=1e-6)
    assert two[1].total_ms == pytest.approx(nominal_ms, abs=1e-6)
    assert np.array_equal(ahead[0], two[0]) and not ahead[1].slowed_moves


def dense_ratios(text, of, window):
    """Return the highest acceleration and speed over the limit, many times in each interval."""
    bound = limits(of)
    runs = TimeLaw(bound, window).runs(
        NominalPath(len(of.motors)).intervals(nominal(events(text, of)))
    )
    worst = np.zeros(2)
    for line in timelines(runs, bound):
        for share in np.linspace(0, 1, 17):
            t = line.ms * share
            rate = (line.rate + line.gain * t)[:, None]
            u = (line.rate * t + line.gain * t**2 / 2)[:, None]
            first = line.path.speed + line.path.bend * u + line.path.twist * u**2 / 2
            second = line.path.bend + line.path.twist * u
            acceleration = first * line.gain[:, None] + second * rate**2
            worst = np.maximum(
                worst,
                [
                    np.max(np.abs(acceleration) / bound.acceleration),
                    np.max(np.abs(first * rate) / bound.speed),
                ],
            )
    return worst


@pytest.mark.parametrize("seed", range(cases(12, 200)))
def test_no_limit_is_exceeded_between_the_nodes_either(seed):
    rng = np.random.default_rng(seed)
    motors = int(rng.integers(1, 5))
    of = setup(10 ** rng.uniform(-2, 0.5, motors), motors, speed=rng.choice([3, 1e9], motors))
    text, _ = random_program(rng, motors, int(rng.integers(1, 15)))
    assert dense_ratios(text, of, int(rng.choice([1, 3, 1000]))).max() <= 1 + 1e-6


@pytest.mark.parametrize("seed", range(cases(11, 1000)))
def test_random_programs_against_an_independent_optimum(seed):
    """Within 2 % of the least time, on the path, exact distances, no limit exceeded."""
    rng = np.random.default_rng(seed)
    motors = int(rng.integers(1, 5))
    of = setup(
        10 ** rng.uniform(-2, 0.5) * rng.uniform(0.5, 2, motors), motors, 1000,
        speed=rng.choice([3.0, 1e9], motors),
    )  # fmt: skip
    text, distance = random_program(rng, motors, int(rng.integers(1, 15)))
    counts, report = planned(text, of)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    assert report.whole
    for motor in report.motors:
        assert motor.planned_ratio <= 1 + 1e-6 and motor.speed_ratio <= 1 + 1e-6
        assert motor.counted_ratio <= 1
    nominal_path = path(text, of)
    assert path_distance(counts, nominal_path) <= 0.5 + CHORDS
    bound = limits(of)
    least, _ = optimum.least_ms(nominal_path, bound.acceleration, bound.speed)
    assert least * 0.999 <= report.total_ms <= least * 1.02


# Circles


@pytest.mark.parametrize("way", [1, 2])
@pytest.mark.parametrize("centre", ["I-2000", "R-2000"])
def test_a_circle_is_round(way, centre):
    of = setup(0.5, 2, segment_ms=5)
    end = "X2000 Y0" if centre.startswith("I") else f"X0 Y{2000 if way == 1 else -2000}"
    text = f"TS0 TA5 F4000\nX2000\nDWELL10\nCIRCLE{way} {end} {centre}"
    counts, report = planned(text, of)
    places = np.cumsum(counts, axis=0)[-1200:]
    radius = np.hypot(*places.T)
    assert np.abs(radius - 2000).max() < 1.5  # half a step each, and the ends of the arc
    assert report.motors[0].planned_ratio <= 1 + 1e-6


@pytest.mark.parametrize("tolerance", [100, 0.1])
@pytest.mark.parametrize(("radius", "speed"), [(2000, 4000), (2000, 20_000), (20_000, 40_000)])
def test_long_segments_leave_no_circle_by_more_than_half_a_step(radius, speed, tolerance):
    """At both ends the most: 1.4, 9.7 and 14 steps with segments of 50 ms whatever the radius."""
    of = setup(NO_LIMIT, 2, segment_ms=50, path_tolerance=tolerance)
    text = f"TS0 TA50 F{speed}\nX{radius}\nDWELL10\nCIRCLE1 X{radius} Y0 I-{radius}"
    found = path(text, of)
    dense = found.part(found.move > 0).divided(np.full(np.sum(found.move > 0), 20))
    off = np.abs(np.hypot(*dense.place.T) - radius).max()
    most = min(tolerance, 0.5)
    assert 0.2 * most < off <= most * 1.01


def test_a_circle_has_a_centre_or_a_radius():
    of = setup(1, 2, segment_ms=5)
    for words, message in (
        ("X100", "needs a radius R or a centre"),
        ("X100 I50 R50", "not both"),
        ("X100 R40", "radius 40 is too short: the ends are 100 apart"),
        ("X100 I40", "begins at radius 40 and ends at radius 60"),
    ):
        with pytest.raises(ProgramError, match=rf"p.pmc:2:1: X100: .*{message}"):
            planned(f"TS0 TA5 TM9 CIRCLE1\n{words}", of)


@pytest.mark.parametrize("length", range(280, 340))
def test_a_plain_motor_turns_slowly_wherever_in_a_pixel(length):
    """More than 18 steps in the first pixel after a reversal would leave the board no time."""
    of = setup(0.9, 1, hz=200, speed=30, reversal_steps=18)
    counts, _ = planned(f"TA10 TS0 TM15\nX{length}\nX0\nX{length}\nX3", of)
    turned = [abs(after) for before, after in pairwise(counts[:, 0].tolist()) if before * after < 0]
    assert max(turned, default=0) <= 18
