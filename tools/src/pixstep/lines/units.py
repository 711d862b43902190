# SPDX-License-Identifier: MIT
"""Speeds, accelerations and jerks per pixel or per second, carried exactly.

A speed of s steps/px is s*f steps/s at the pixel frequency f; an acceleration of a steps/px2 is
a*f^2 steps/s2, a jerk of j steps/px3 is j*f^3 steps/s3.
"""

import re
from dataclasses import dataclass
from fractions import Fraction

from pixstep.errors import UserError

SPEED, ACCELERATION, JERK = 1, 2, 3
_NAMES = {SPEED: "speed", ACCELERATION: "acceleration", JERK: "jerk"}
_QUANTITY = re.compile(r"(\d{1,12}(?:\.\d{1,9})?) *(?:steps/(px|pixel|s)([23]?))?")


@dataclass(frozen=True)
class Quantity:
    """A figure as it was given; the order is 1 for a speed, 2 an acceleration, 3 a jerk."""

    value: Fraction
    order: int
    per_second: bool
    text: str

    def per_pixel(self, hz: Fraction | None) -> Fraction:
        """Return the value in steps/px^order. Raises UserError if that needs a missing `hz`."""
        if not self.per_second:
            return self.value
        if hz is None:
            raise UserError(f"{_NAMES[self.order]} {self.text}: per second needs --pixel-hz")
        return self.value / hz**self.order


def parse(text: str, order: int) -> Quantity:
    """Return the quantity written as 128, 128steps/px2 or 115200steps/s2.

    A bare number is per pixel. Raises UserError for anything else, another order included.
    """
    found = _QUANTITY.fullmatch(text.strip())
    wanted = f"{unit(order)} or {unit(order, per_second=True)}"
    if not found:
        raise UserError(f"{_NAMES[order]} {text!r}: expected a number of {wanted}")
    number, base, power = found.groups()
    if base and int(power or 1) != order:
        raise UserError(f"{_NAMES[order]} {text!r}: expected {wanted}")
    return Quantity(Fraction(number), order, base == "s", text.strip())


def unit(order: int, *, per_second: bool = False) -> str:
    """Return the name of a unit: steps/px, steps/s2."""
    return f"steps/{'s' if per_second else 'px'}{order if order > 1 else ''}"


def per_second(value: Fraction | int, order: int, hz: Fraction) -> Fraction:
    """Return a value in steps/px^order as steps/s^order."""
    return Fraction(value) * hz**order


def number_text(value: Fraction | float) -> str:
    """Return a figure as people read it: whole where it is, else seven digits."""
    if Fraction(value).denominator == 1:
        return str(int(value))
    return f"{float(value):.7g}"


def both_text(value: Fraction | int, order: int, hz: Fraction | None) -> str:
    """Return a figure per pixel and, if the frequency is known, per second."""
    text = f"{number_text(value)} {unit(order)}"
    if hz is None:
        return text
    return f"{text} = {number_text(per_second(value, order, hz))} {unit(order, per_second=True)}"
