# SPDX-License-Identifier: MIT
"""The generator: the worked example, parity, minimum length, backlash zeros."""

import pytest

from pixstep import formats, profile
from pixstep.errors import UserError
from pixstep.line import Line
from worked import ACCELERATING, MPOS, PRN

SPEEDS, _ = formats.read_prn(PRN)


def make(**changes):
    request = profile.LineRequest(**{"speed": 1000, "pixels": 60, **changes})
    return profile.generate(SPEEDS, request)


def test_worked_example():
    assert profile.acceleration_counts(SPEEDS, 1000) == ACCELERATING
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
        profile.acceleration_counts(speeds, 20)


def test_speed_below_the_first_entry_is_one_partial_pixel():
    assert profile.acceleration_counts(SPEEDS, 6) == [3]


def test_equal_entries_hold_the_speed():
    assert profile.acceleration_counts([8, 8, 16], 16) == [4, 8, 12]


def test_plain_counts_are_the_entries():
    line = make(plain=True, speed=33, pixels=12)
    assert line.counts == [8, 16, 24, 32, 33, 33, 33, 33, 32, 24, 16, 8]
