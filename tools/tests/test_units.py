# SPDX-License-Identifier: MIT
"""Quantities per pixel and per second, exact."""

from fractions import Fraction

import pytest

from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import ACCELERATION, DISTANCE, JERK, SPEED, parse_hz


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
    with pytest.raises(UserError, match="needs pixel_hz"):
        units.parse("7steps/s", SPEED).per_pixel(None)


def test_texts():
    assert units.both_text(128, ACCELERATION, None) == "128 steps/px2"
    assert units.both_text(128, ACCELERATION, Fraction(30)) == "128 steps/px2 = 115200 steps/s2"
    assert units.number_text(Fraction(1, 3)) == "0.3333333"


@pytest.mark.parametrize(
    ("text", "order", "value"),
    [
        ("250", DISTANCE, 250),
        ("3 um", DISTANCE, Fraction(6, 5)),
        ("3µm", DISTANCE, Fraction(6, 5)),  # the micro sign
        ("3μm", DISTANCE, Fraction(6, 5)),  # the Greek letter
        ("0.5in", DISTANCE, 5080),
        ("1.5e-3 m", DISTANCE, 600),
        ("12mm/s", SPEED, 160),
        ("12 mm / s", SPEED, 160),
        ("720mm/min", SPEED, 160),
        ("0.4mm/px", SPEED, 160),
        ("4800 steps/s", SPEED, 160),
        ("4.8 steps/ms", SPEED, 160),
        ("450 mm/s2", ACCELERATION, 200),
        ("450 mm/s²", ACCELERATION, 200),
        ("0.45 m/s^2", ACCELERATION, 200),
        ("0.5mm/pixel2", ACCELERATION, 200),
        ("13500mm/s3", JERK, 200),
    ],
)
def test_lengths_become_steps_by_the_scale(text, order, value):
    scale = units.parse_scale("400 steps/mm")
    assert units.parse(text, order).in_steps(scale).per_pixel(Fraction(30)) == value


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("400 steps/mm", "400 steps/mm"),
        ("2.5um/step", "400 steps/mm"),
        ("0.4 steps/um", "400 steps/mm"),
        ("12.5 steps / deg", "12.5 steps/deg"),
        ("200 steps/rev", "0.5555556 steps/deg"),
    ],
)
def test_scales(text, shown):
    assert str(units.parse_scale(text)) == shown


@pytest.mark.parametrize("text", ["400", "400 mm", "0 steps/mm", "4 steps/step", "4 mm/deg", "x"])
def test_scales_that_are_none(text):
    with pytest.raises(UserError, match="expected steps per length"):
        units.parse_scale(text)


def test_angles_are_no_lengths():
    with pytest.raises(UserError, match="needs a motor's steps per deg, the motor has 400 steps"):
        units.parse("3deg", DISTANCE).in_steps(units.parse_scale("400 steps/mm"))
    turn = units.parse("2 rev", DISTANCE).in_steps(units.parse_scale("200 steps/rev"))
    assert turn.whole_steps() == 400


def test_parts_of_a_step_are_named_with_their_neighbours():
    with pytest.raises(UserError, match=r"distance -2.5 is -2.5 steps, .* nearest -3 and -2$"):
        units.parse("-2.5", DISTANCE, signed=True).whole_steps()


def test_times_pixels_and_frequencies():
    assert units.parse_seconds("20us") == units.parse_seconds("20", "us") == Fraction(1, 50_000)
    assert units.parse_seconds("1.5 min") == 90
    assert units.parse_pixels("4px") == units.parse_pixels("4 pixels") == 4
    assert parse_hz("100.13Hz") == Fraction(10013, 100) and parse_hz("1 kHz") == 1000
    assert parse_hz("30000/1001 Hz") == Fraction(30000, 1001)
    assert parse_hz("1e3") == parse_hz("1E+3Hz") == parse_hz("0.01e2 kHz") == 1000
    for wrong in ("4.5px", "٤", "4 mm", ""):
        with pytest.raises(UserError, match="whole number of pixels"):
            units.parse_pixels(wrong)
    for wrong in ("-1s", "3 h", "s"):
        with pytest.raises(UserError, match="expected a number of us, ms, s, min"):
            units.parse_seconds(wrong)
    for wrong in ("30 hz", "Hz", "1/0Hz", "٣", "0.0000000001 Hz", "1e", "1e999", "1e3/7"):
        with pytest.raises(UserError, match="pixel frequency"):
            parse_hz(wrong)


def test_texts_with_a_scale():
    scale = units.parse_scale("400 steps/mm")
    text = units.both_text(160, SPEED, Fraction(30), scale)
    assert text == "160 steps/px = 4800 steps/s = 12 mm/s"
