# SPDX-License-Identifier: MIT
"""Options for speeds, accelerations and jerks, per pixel or per second."""

from collections.abc import Callable
from fractions import Fraction

import click

from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import ACCELERATION, JERK, SPEED, Quantity


class _QuantityType(click.ParamType):
    """A figure such as 128, 128steps/px2 or 115200steps/s2."""

    def __init__(self, order: int):
        self.order = order
        self.name = units.unit(order)

    def convert(self, value, param, ctx) -> Quantity:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, Quantity):
            return value
        try:
            return units.parse(value, self.order)
        except UserError as error:
            return self.fail(str(error), param, ctx)


SPEED_TYPE = _QuantityType(SPEED)
ACCELERATION_TYPE = _QuantityType(ACCELERATION)
JERK_TYPE = _QuantityType(JERK)


def limit_options(command: Callable) -> Callable:
    """Add --max-speed, --max-acceleration and --max-jerk, none of them required."""
    for name, kind, text in (
        ("--max-jerk", JERK_TYPE, "Largest change of the acceleration, steps/px3 or steps/s3."),
        ("--max-acceleration", ACCELERATION_TYPE, "Largest acceleration, steps/px2 or steps/s2."),
        ("--max-speed", SPEED_TYPE, "Largest speed, steps/px or steps/s."),
    ):
        command = click.option(name, type=kind, help=text)(command)
    return command


def whole_limit(quantity: Quantity | None, hz: Fraction | None) -> int | None:
    """Return a limit rounded down to a whole number of steps/px^order; None stays None.

    Raises UserError for a limit below 1, and for one per second without a frequency.
    """
    if quantity is None:
        return None
    value = quantity.per_pixel(hz)
    if value < 1:
        kind = units.unit(quantity.order)
        raise UserError(f"{quantity.text} is {units.number_text(value)} {kind}: at least 1 {kind}")
    return int(value)
