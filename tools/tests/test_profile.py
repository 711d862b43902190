# SPDX-License-Identifier: MIT
"""The generator: the worked example, parity, minimum length, backlash zeros."""

import itertools
import random

import pytest

from pixstep import formats
from pixstep.errors import UserError
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.profiles import generator, ramps
from worked import ACCELERATING, MPOS, PRN

SPEEDS, _ = formats.read_prn(PRN)


def make(**changes):
    request = generator.LineRequest(**{"speed": 1000, "pixels": 60, **changes})
    return generator.generate(SPEEDS, request)


def test_worked_example():
    assert generator.acceleration_counts(SPEEDS, 1000) == ACCELERATING
    assert sum(ACCELERATING) == 4418
    line = make(backlash=250)
    assert line.counts[:19] == list(formats.read_csv(MPOS).values)
    assert line.counts == line.counts[::-1]
    assert len(line.counts) == 60 and line.accelerating_pixels == 15
    assert Line(tuple(line.counts)).speeds[-1] == 0


def test_without_backlash_no_zeros():
    assert make().counts[0] == 4 and make().counts[-1] == 4


def test_image_pixel_follows_acceleration_and_lead_in():
    assert make().image_pixel == 16
    assert make(backlash=1, lead_in=5).image_pixel == 22


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": 1001}, "nearest legal 1000 and 1002"),
        ({"speed": 1}, "nearest legal 2"),
        ({"speed": 1300}, "tops out at 1280 below 1300"),
        ({"speed": 0}, "outside"),
        ({"pixels": 30}, "at least 31"),
        ({"pixels": 32, "backlash": 10}, "at least 33"),
        ({"pixels": 40, "lead_in": 10}, "at least 41"),
        ({"backlash": 1001}, "does not fit one pixel"),
        ({"backlash": -1}, "positive figure only"),
        ({"backlash": 5, "plain": True}, "only a smooth line"),
        ({"lead_in": -1}, "lead-in"),
    ],
)
def test_refusals(changes, message):
    with pytest.raises(UserError, match=message):
        make(**changes)


def test_minimum_length_is_enough():
    assert len(make(pixels=31).counts) == 31
    assert len(make(pixels=33, backlash=10).counts) == 33


@pytest.mark.parametrize(
    ("speeds", "message"),
    [
        ([8, 15, 24], ":2: speed 15 is odd, nearest legal 14 and 16"),
        ([8, 24, 16], ":3: speed falls from 24 to 16"),
        ([0, 8], ":1: speed 0 must be above 0"),
        ([], "tops out at 0"),
    ],
)
def test_bad_profiles(speeds, message):
    with pytest.raises(UserError, match=message):
        generator.acceleration_counts(speeds, 20)


def test_speed_below_the_first_entry_is_one_partial_pixel():
    assert generator.acceleration_counts(SPEEDS, 6) == [3]


def test_equal_entries_hold_the_speed():
    assert generator.acceleration_counts([8, 8, 16], 16) == [4, 8, 12]


def test_plain_counts_are_the_entries():
    line = make(plain=True, speed=33, pixels=12)
    assert line.counts == [8, 16, 24, 32, 33, 33, 33, 33, 32, 24, 16, 8]


def test_the_table_of_the_worked_example():
    ends = [8, 16, 24, 32, 38, 44, 128, 172, 256, 384, 512, 640, 768, 896, 1000, 1000]
    changes = [8, 8, 8, 8, 6, 6, 84, 44, 84, 128, 128, 128, 128, 128, 104, 0]
    line = Line(tuple(make().counts))
    assert list(line.speeds[1:17]) == ends
    assert [b - a for a, b in itertools.pairwise(line.speeds[:17])] == changes
    full = generator.acceleration_counts(SPEEDS, 1024)
    assert full[14] == 960  # the partial pixel has 948 instead


def test_closed_form_of_the_decode_rule():
    rng = random.Random(40)
    for _ in range(50):
        counts = tuple(rng.randint(0, 1000) for _ in range(rng.randint(1, 20)))
        for n, speed in enumerate(Line(counts).speeds[1:], 1):
            assert speed == 2 * sum((-1) ** (n - j) * counts[j - 1] for j in range(1, n + 1))


# Parity, rules 1 to 5: counts may be odd, the speeds at the boundaries may not.


def test_odd_counts_are_legal():
    assert [count for count in ACCELERATING if count % 2] == [35, 41]
    assert line_check.check(Line(tuple(make().counts))) == []


def test_every_boundary_speed_from_rest_is_even():
    rng = random.Random(41)
    counts = tuple(rng.randint(0, 1000) for _ in range(200))
    assert all(speed % 2 == 0 for speed in Line(counts).speeds)


@pytest.mark.parametrize(("last", "swing"), [(948, [1000, 1002]), (949, [1002, 1000])])
def test_an_odd_constant_speed_ripples_for_ever(last, swing):
    line = Line((*ACCELERATING[:-1], last, *[1001] * 6))
    assert list(line.speeds[15:]) == [*swing, *swing, *swing, swing[0]]
    assert ("ripple", 16) in [(item.name, item.pixel) for item in line_check.check(line)]


@pytest.mark.parametrize("speed", [1001, 897, 1023, 3])
def test_an_odd_speed_fails_with_an_even_profile(speed):
    with pytest.raises(UserError, match=f"nearest legal {speed - 1} and {speed + 1}"):
        make(speed=speed)


@pytest.mark.parametrize("edit", [-1, 1])
def test_a_hand_edit_changes_every_later_speed_by_two_alternating(edit):
    counts = list(make().counts)
    counts[7] += edit
    before, after = Line(tuple(make().counts)).speeds, Line(tuple(counts)).speeds
    changes = [b - a for a, b in zip(before, after, strict=True)]
    assert changes[:8] == [0] * 8
    assert changes[8:] == [2 * edit * (-1) ** k for k in range(len(changes) - 8)]


def test_an_odd_start_stays_odd_for_the_rest():
    assert all(speed % 2 for speed in ramps.decoded(7, tuple(ACCELERATING)))


# Backlash: 0 <= B <= V; a trailing zero if and only if there is a leading one.


@pytest.mark.parametrize("backlash", [0, 1, 250, 999, 1000])
def test_a_trailing_zero_iff_a_leading_one(backlash):
    line = make(backlash=backlash)
    assert (line.counts[0] == 0) == (line.counts[-1] == 0) == (backlash > 0)
    shifted = Line(tuple(line.counts), backlash=backlash)
    assert line_check.check(shifted) == []
    assert shifted.total_steps == sum(line.counts) + backlash


@pytest.mark.parametrize(("backlash", "lead_in"), list(itertools.product((0, 1, 1000), (0, 1, 7))))
def test_minimum_length_and_first_image_pixel(backlash, lead_in):
    zeros = 2 if backlash else 0
    minimum = 2 * 15 + lead_in + 1 + zeros
    line = make(pixels=minimum, backlash=backlash, lead_in=lead_in)
    # the one image pixel is the last at constant speed; it follows zero, acceleration, lead-in
    assert line.image_pixel == zeros // 2 + 15 + lead_in + 1
    assert line.counts[line.image_pixel - 1] == 1000
    assert line.counts[line.image_pixel] == 948
    with pytest.raises(UserError, match=f"at least {minimum}$"):
        make(pixels=minimum - 1, backlash=backlash, lead_in=lead_in)


@pytest.mark.parametrize("speed", [2, 4, 6])
def test_a_speed_below_the_first_entry_makes_a_line(speed):
    line = make(speed=speed, pixels=5)
    assert line.counts == [speed // 2, speed, speed, speed, speed // 2]
    assert line_check.check(Line(tuple(line.counts))) == []
