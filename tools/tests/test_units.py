# SPDX-License-Identifier: MIT
"""Quantities per pixel and per second, exact."""

from fractions import Fraction

import pytest

from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import ACCELERATION, JERK, SPEED


@pytest.mark.parametrize(
    ("text", "order", "value"),
    [
        ("1000", SPEED, 1000),
        ("1000steps/px", SPEED, 1000),
        ("30000steps/s", SPEED, 1000),
        ("30000 steps/s", SPEED, 1000),
        ("128 steps/pixel2", ACCELERATION, 128),
        ("115200steps/s2", ACCELERATION, 128),
        ("1080000steps/s3", JERK, 40),
        ("0.5", JERK, Fraction(1, 2)),
    ],
)
def test_per_pixel(text, order, value):
    assert units.parse(text, order).per_pixel(Fraction(30)) == value


def test_a_fraction_of_a_hertz_stays_exact():
    hz = Fraction(30000, 1001)
    assert units.parse("30000steps/s", SPEED).per_pixel(hz) == 1001
    assert units.per_second(1001, SPEED, hz) == 30000


@pytest.mark.parametrize(
    ("text", "order"),
    [("", SPEED), ("-4", SPEED), ("4mm/px3", SPEED), ("4steps/s2", SPEED), ("4steps/s", JERK)],
)
def test_refused(text, order):
    with pytest.raises(UserError, match="expected"):
        units.parse(text, order)


def test_per_second_needs_a_frequency():
    assert units.parse("7", SPEED).per_pixel(None) == 7
    with pytest.raises(UserError, match="needs --pixel-hz"):
        units.parse("7steps/s", SPEED).per_pixel(None)


def test_texts():
    assert units.both_text(128, ACCELERATION, None) == "128 steps/px2"
    assert units.both_text(128, ACCELERATION, Fraction(30)) == "128 steps/px2 = 115200 steps/s2"
    assert units.number_text(Fraction(1, 3)) == "0.3333333"
