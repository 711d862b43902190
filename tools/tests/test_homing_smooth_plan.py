# SPDX-License-Identifier: MIT
"""Smooth homing's plan and sequence, over a test double of board and plant."""

import random
from fractions import Fraction
from pathlib import Path

import pytest

from fake_home import FakeHome, Plant
from pixstep.errors import UserError
from pixstep.lines import line_check, runs
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.moves import fast, homing, legs
from pixstep.moves.homing import HomingError
from pixstep.profiles import origin, readings
from worked import DATA

PATH = DATA / "AccProf-fast-move.csv"
PROFILE = fast.read(PATH)
SPEEDS = (8, 16, 24, 32, 40, 52, 64, 84, 104, 136)  # after the first ten entries, by hand
HZ = Fraction(300)


def plan(direction=1, profile=PROFILE, **changes):
    options = {"search_steps": 6000, "decode": SMOOTH, **changes}
    return legs.plan(profile, legs.HomingRequest(0, direction, **options), HZ)


def home(plant, made=None, **options):
    board = FakeHome(plant, hz=int(HZ), **options)
    return homing.home(board, made or plan(), HZ, board), board


def speeds_of(counts):
    return Line(tuple(abs(count) for count in counts)).speeds


def test_the_example_profile_is_sound_under_both_rules():
    """For homing smoothly, for fast moves plainly."""
    found = readings.check(readings.load(PATH), None, line_check.Limits())
    adopted = [reading for reading in found if reading.rows.adopted]
    assert {reading.decode for reading in adopted} == {SMOOTH, PLAIN}
    assert [reading.findings for reading in adopted] == [(), ()]


@pytest.mark.parametrize("suffix", ["PRN", "csv", "CSB"])
def test_the_motor_is_known_by_the_name_of_its_file(suffix):
    assert origin.parse_name(Path(f"x/AccProfM39-30Hz-1.{suffix}")).decode == SMOOTH
    assert origin.parse_name(Path(f"x/AccProfM40-30Hz-1.{suffix}")).decode == PLAIN


def test_a_smooth_seek_holds_the_speed_behind_its_last_entry_and_mirrors_all():
    seek = legs.seek_line(fast.Acceleration((4, 12, 20)), -1, 150, decode=SMOOTH)
    assert seek.rising == (-4, -12, -20) and seek.falling == (-20, -12, -4)
    assert (seek.held, seek.hold_px, seek.steps, seek.pixels) == (-24, 3, -144, 9)
    mark = runs.MARK_START | runs.MARK_SEEK | runs.MARK_SMOOTH | runs.MARK_NEGATIVE
    assert runs.seek_entries(seek) == [
        (mark, 0), (0, 0), (4, 1), (12, 1), (20, 1), (24, 3),
        (runs.MARK_DOWN, 0), (20, 1), (12, 1), (4, 1), (runs.MARK_END, 0),
    ]  # fmt: skip


def test_a_smooth_seek_for_opening_in_plus_direction():
    seek = legs.seek_line(fast.Acceleration((2,)), 1, 4 * 70_001, opens=True, decode=SMOOTH)
    mark = runs.MARK_START | runs.MARK_SEEK | runs.MARK_SEEK_OPEN | runs.MARK_SMOOTH
    assert runs.seek_entries(seek) == [
        (mark, 0), (0, 0), (2, 1), (4, 65_535), (4, 70_000 - 65_535),
        (runs.MARK_DOWN, 0), (2, 1), (runs.MARK_END, 0),
    ]  # fmt: skip


@pytest.mark.parametrize("steps", [*range(16, 900, 7), 20_000])
def test_every_search_is_a_sound_smooth_line_within_its_distance(steps):
    """Also without room to hold: equal counts at the top would be refused as oscillating."""
    ramp = PROFILE.leading(10)
    seek = legs.seek_line(ramp, 1, steps, decode=SMOOTH)
    entries = len(seek.rising)
    assert seek.hold_px >= 1 and seek.held == SPEEDS[entries - 1]
    assert seek.steps <= steps
    assert entries < 10 or seek.steps > steps - seek.held
    counts = (*seek.rising, *(seek.held,) * seek.hold_px, *seek.falling)
    line = Line(counts, clocked=False)
    assert line_check.check(line) == []
    assert line.total_steps == seek.steps and line.pixels == seek.pixels
    assert line.speeds == line.speeds[::-1]


def test_haps_are_entries_and_the_top_is_the_speed_behind_the_last():
    assert plan().top == 136 and plan().speeds == SPEEDS
    assert plan(haps=1).top == 8 and plan(haps=3).top == 24
    assert plan(decode=PLAIN).top == 120 and plan(decode=PLAIN).speeds == PROFILE.counts[:10]


@pytest.mark.parametrize(("first", "slow"), [(1, 2), (2, 2), (3, 2), (4, 4), (5, 4), (9, 8)])
def test_the_slow_approach_is_the_largest_even_speed_not_above_the_first_entry(first, slow):
    made = plan(profile=fast.Acceleration((first, 40), haps=1))
    seek = made.slow_approach()
    assert made.slow == slow == seek.held
    assert seek.rising == (slow // 2,) == seek.falling and seek.hold_px > 1


@pytest.mark.parametrize("slow", [2, 6, 8])
def test_other_slow_speeds(slow):
    assert plan(slow=slow).slow_approach().held == slow


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"slow": 3}, "slow approach at 3 steps/pixel: an even number, 2 to 8"),
        ({"slow": 0}, "slow approach at 0"),
        ({"slow": 10}, "slow approach at 10 .* twice the first entry"),
        ({"search_steps": 15}, "search distance 15 is less than a smooth line needs .* 16 steps"),
        ({"haps": 0}, "HAPs 0"),
    ],
)
def test_plans_that_cannot_be(changes, text):
    with pytest.raises(UserError, match=text):
        plan(**changes)


@pytest.mark.parametrize(
    ("counts", "entry", "text"),
    [
        ((10, 10, 10), 1, "3 pixels of 10 entered at speed 0 swing between 0 and 20"),
        ((4, 12, 20, 30, 30, 30), 4, "3 pixels of 30 entered at speed 24"),
        ((20, 30, 60), 2, "the speed falls from 40 to 20"),
        ((100, 101, 102), 2, "the speed falls from 200 to 2"),
        ((8, 9, 9, 40), 2, "2 pixels of 9 entered at speed 16"),
        ((40, 39, 60), 2, "count 39 entered at speed 80, at least 40"),
        ((100, 101, 101), 2, "swing between 2 and 200"),
        ((4000, 16_000), 2, "count 24000 is outside"),
    ],
)
def test_profiles_that_a_smooth_axis_cannot_follow(counts, entry, text):
    profile = fast.Acceleration(counts, haps=len(counts), source="x.csv")
    with pytest.raises(UserError, match=text) as caught:
        plan(profile=profile, search_steps=100_000)
    assert str(caught.value).startswith(f"x.csv: entry {entry}, decoded as smooth: ")
    assert "pixstep profile check" in str(caught.value)


def test_only_the_haps_entries_must_be_sound():
    """What lies beyond is for fast moves, which are plain."""
    profile = fast.Acceleration((4, 12, 20, 200, 200), haps=3)
    assert plan(profile=profile).top == 24


def test_a_smooth_profile_need_not_rise_everywhere():
    profile = fast.Acceleration((4, 8, 8, 8, 10), haps=5)
    assert plan(profile=profile).speeds == (8, 8, 8, 8, 12)


@pytest.mark.parametrize(("start", "first"), [(123, "approach"), (3000, "leave the switch")])
def test_what_seeks_is_smooth_and_what_moves_between_is_plain(start, first):
    result, board = home(Plant(start=start))
    assert result.legs[0].name == first
    assert board.plant.load == 2000 and result.position_steps == 0
    for leg, mark, counts in zip(result.legs, board.marks, board.moves, strict=True):
        seeks = leg.name not in ("stand clear", "return to 0")
        assert leg.decode == (SMOOTH if seeks else PLAIN)
        assert bool(mark & runs.MARK_SMOOTH) == seeks == bool(mark & runs.MARK_SEEK)
        assert bool(mark & runs.MARK_NEGATIVE) == (seeks and leg.steps < 0)
        assert sum(counts) == leg.steps


def test_the_stop_is_the_way_up_mirrored_from_wherever_the_switch_comes():
    tops = set()
    for start in range(1000, 2000, 9):
        _, board = home(Plant(start=start))
        speeds = speeds_of(board.moves[0])
        assert speeds == speeds[::-1]
        rising = speeds[: speeds.index(max(speeds)) + 1]
        assert rising == (0, *SPEEDS)[: len(rising)]
        tops.add(max(speeds))
    assert tops >= set(SPEEDS[3:])  # in the first pixels it is still to be filtered


def test_many_starts_and_delays_end_on_one_step():
    rng = random.Random(8)
    made = plan(slow=2)
    ends = set()
    for _ in range(100):
        plant = Plant(start=rng.randint(-450, 3950), delay_s=rng.uniform(0, 0.001))
        home(plant, made)
        ends.add(plant.load)
    assert max(ends) - min(ends) <= 1


@pytest.mark.parametrize(
    ("plant", "changes", "name"),
    [
        (Plant(stuck=False), {}, "limit_plus"),
        (Plant(stuck=False), {"search_steps": 900}, "home_not_found"),
        (Plant(stuck=True), {}, "limit_minus"),
        (Plant(stuck=True), {"search_steps": 400}, "home_stuck"),
    ],
)
def test_named_faults(plant, changes, name):
    made = plan(**changes)
    board = FakeHome(plant, hz=int(HZ))
    with pytest.raises(HomingError) as caught:
        homing.home(board, made, HZ, board)
    assert caught.value.name == name and caught.value.legs[0].decode == SMOOTH


def test_rising_and_falling_both_take_queue_room():
    """Start, parameters, hold, mark and end beside twice the entries: 13 fit the uno's 32."""
    assert len(runs.seek_entries(plan(haps=13).approach())) == 31
    home(Plant(), plan(haps=13))
    with pytest.raises(HomingError, match=r"approach takes 33 queue entries.* 32: fewer HAPs"):
        home(Plant(), plan(haps=14))
