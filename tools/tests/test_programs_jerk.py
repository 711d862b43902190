# SPDX-License-Identifier: MIT
"""Plans with a limit of the jerk: every limit for every pixel, the path, times by hand."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from effort import cases
from pixstep.errors import RefusedError
from pixstep.programs import figure, jerk
from pixstep.programs.plan import Plan
from pixstep.programs.plan_data import PlanOptions
from programbench import CHORDS, SHORT_MOVES, path, path_distance, planned, random_program, setup

PIXEL_MS = 10  # at 100 Hz
TOLERANCE = 1 + 1e-6


def counted_jerks(counts):
    """Return the highest jerk of each plain motor's counts, at rest before and behind them."""
    still = np.zeros((3, counts.shape[1]), dtype=int)
    return np.abs(np.diff(np.vstack([still, counts, still]), n=2, axis=0)).max(axis=0)


def least_pixels(steps, acceleration, limit):
    """Return how long a move from rest to rest takes with limits of acceleration and jerk."""
    if steps < 2 * acceleration**3 / limit**2:
        return (32 * steps / limit) ** (1 / 3)
    rise = acceleration / limit
    return rise + (rise**2 + 4 * steps / acceleration) ** 0.5


def made(seed, smooth):
    """Return a random program, its distances, and motors with and without a limit of the jerk."""
    rng = np.random.default_rng(seed)
    motors, hz = int(rng.integers(1, 4)), int(rng.choice([100, 200, 1000]))
    pixel = 1000 / hz
    if smooth:
        most = rng.uniform(6, 60, motors) / pixel**2
        fastest = rng.uniform(20, 400) / pixel
    else:
        most = 10 ** rng.uniform(-2, 0.5, motors)
        fastest = rng.choice([20.0, 1e9], motors)
    limit = float(most.max() * pixel**2 * 10 ** rng.uniform(-1.5, 0))
    text, distance = random_program(rng, motors, int(rng.integers(1, 9)), rising=smooth)
    if seed % 3 == 0:
        text += "\nDWELL17\n" + " ".join(f"{word}40" for word in "XYZ"[:motors])
        distance = distance + 40
    free = setup(most, motors, hz, fastest, smooth=smooth)
    return text, distance, free, setup(most, motors, hz, fastest, smooth=smooth, max_jerk=limit)


@lru_cache(maxsize=64)
def plan_within_the_limit(seed, smooth):
    """Return the counts and the report of a random program, for all who look at it."""
    text, _, _, of = made(seed, smooth)
    return planned(text, of)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("seed", range(cases(12, 300)))
def test_random_programs_keep_every_limit_and_the_path(seed, smooth):
    text, distance, _, of = made(seed, smooth)
    counts, report = plan_within_the_limit(seed, smooth)
    assert counts.sum(axis=0).tolist() == distance.tolist()
    assert path_distance(counts, path(text, of)) <= (1 if smooth else 0.5) + CHORDS
    for index, motor in enumerate(report.motors):
        assert motor.planned_jerk <= motor.motor.max_jerk * TOLERANCE
        assert motor.planned_ratio <= TOLERANCE and motor.speed_ratio <= TOLERANCE
        assert motor.counted_ratio <= 1
        assert motor.counted_jerk <= motor.allowed_jerk
        if not smooth:
            assert counted_jerks(counts)[index] <= motor.motor.max_jerk + 4
    assert report.total_ms >= path(text, of).du.sum() - 1e-6


def test_the_random_programs_need_the_limit():
    slower = 0
    for seed in range(12):
        text, _, free, _ = made(seed, smooth=False)
        limited = plan_within_the_limit(seed, False)[1]
        slower += limited.total_ms > 1.01 * planned(text, free)[1].total_ms
    assert slower >= 5
    move = "INC TS0 TA1 TM2 X20000"
    assert counted_jerks(planned(move, setup(1, hz=100))[0])[0] > 10 * (5 + 4)
    assert counted_jerks(planned(move, setup(1, hz=100, max_jerk=5))[0])[0] <= 5 + 4


# The longest move takes four fifths of the time and has the same phases as a tenth of it.
@pytest.mark.parametrize("steps", cases([2_000, 20_000], [2_000, 20_000, 200_000]))
@pytest.mark.parametrize("limit", [0.5, 2, 10, 40])
@pytest.mark.parametrize("ta", [1, 100])
def test_a_single_move_takes_at_most_a_quarter_longer_than_the_least_time(steps, limit, ta):
    of = setup(1, 1, 1000 // PIXEL_MS, max_jerk=limit)
    found = planned(f"INC TS0 TA{ta} TM{ta} X{steps}", of)[1].total_ms / PIXEL_MS
    least = max(least_pixels(steps, PIXEL_MS**2, limit), 2 * ta / PIXEL_MS)
    # Between whole pixels the jerk may be higher, for up to three pixels.
    assert least - 3 <= found <= 1.25 * least + 1


def test_the_least_time_of_a_move_by_hand():
    # Four phases of 1 px: speeds 1/2, 1, 1/2, 0 and distances 1/6, 5/6, 5/6, 1/6.
    assert least_pixels(2, 1e9, 1) == pytest.approx(4)
    # Rise, top and fall of the acceleration 1 px each up to speed 2, mean 1; the same to stop.
    assert least_pixels(6, 1, 1) == pytest.approx(6)


@pytest.mark.parametrize("text", [SHORT_MOVES, "INC TS0 TA9 TM20 X90\nDWELL30\nX-50"])
def test_a_limit_that_nothing_reaches_changes_no_section(text):
    free, report = planned(text, setup(1))
    bound, kept = planned(text, setup(1, max_jerk=1e6))
    assert np.array_equal(np.trim_zeros(free[:, 0]), np.trim_zeros(bound[:, 0]))
    assert not report.keeps_jerk and kept.keeps_jerk


def test_mode1_keeps_no_limit_of_the_jerk():
    free, _ = planned(SHORT_MOVES, setup(1), mode="mode1")
    bound, report = planned(SHORT_MOVES, setup(1, max_jerk=0.01), mode="mode1")
    assert np.array_equal(free, bound) and report.motors[0].jerk_limit is None


def test_a_dwell_takes_whole_pixels_and_at_least_three():
    for ms, pixels in ((1, 3), (35, 4), (40, 4)):
        counts, _ = planned(f"INC TS0 TA50 TM99 X90\nDWELL{ms}\nX90", setup(1, 1, 100, max_jerk=2))
        assert counts.sum() == 180
        moved = np.flatnonzero(counts[:, 0])
        assert np.diff(moved).max() - 1 >= pixels


def test_only_a_section_between_two_stops_has_to_be_short(monkeypatch):
    monkeypatch.setattr(jerk, "MOST_PIXELS", 60)
    of = setup(1, 1, 100, max_jerk=2)
    move = "X900\n"
    assert planned("INC TS0 TA50 TM300\n" + (move + "DWELL50\n") * 4, of)[0].sum() == 3600
    with pytest.raises(RefusedError, match=r"p.pmc: too long to keep a max_jerk: at most 60 pix"):
        planned("INC TS0 TA50 TM300\n" + move * 4, of)


def drawn(**options):
    """The drawing of a plan of two motors; the first one has a limit of the jerk that is near."""
    of = setup(2.0, 2, 100)
    of = replace(of, motors=(replace(of.motors[0], max_jerk=20.0), of.motors[1]))
    plan = Plan("p.pmc", SHORT_MOVES.splitlines(), of, PlanOptions(**options))
    return figure.draw_motion(figure.Drawn(plan, np.vstack(list(plan.counts()))))


def test_the_drawing_has_the_jerk_where_a_limit_is_kept():
    rows = [drawn().axes[:3], drawn().axes[3:]]
    assert [len(row) for row in rows] == [3, 3]
    limited, free = (
        {float(line.get_ydata()[0]) for line in row[2].get_lines() if len(line.get_xdata()) == 2}
        for row in rows
    )
    assert limited == {20.0, -20.0, 24.0, -24.0} and not free  # dashed, dotted
    assert rows[0][2].get_ylabel() == "jerk, steps/px³"
    jerks = rows[0][2].get_lines()[0].get_ydata()
    assert 0 < np.abs(jerks).max() <= 24
    assert len(drawn(mode="mode1").axes) == 4  # it keeps none
