# SPDX-License-Identifier: MIT
"""What the limits of a motor let its lines do, in whole steps and pixels."""

from __future__ import annotations

from fractions import Fraction

from pixstep.lines import units
from pixstep.lines.line import Line
from pixstep.lines.line_check import Limits
from pixstep.lines.units import Quantity
from pixstep.machine.model import MotorTable


def of_motor(motor: MotorTable, line: Line, hz: Fraction) -> Limits:
    """Return the limits of a motor for one of its lines; `hz` is the frequency of pixels.

    Raises UserError for one that pixels are too short for.
    """
    speed, acceleration = motor.limit("max_speed"), motor.limit("max_acceleration")
    found = of_quantities(line, hz, speed, acceleration, motor.limit("start_stop"))
    return found.with_rounding(line)


def of_quantities(
    line: Line,
    hz: Fraction | None,
    max_speed: Quantity | None,
    max_acceleration: Quantity | None,
    start_stop: Quantity | None,
) -> Limits:
    """Return limits in whole steps and pixels; speeds of smooth lines differ by two at least."""
    return Limits(
        max_speed=_whole(max_speed, hz),
        max_acceleration=_whole(max_acceleration, hz, 2 if line.smooth else 1),
        start_stop=_whole(start_stop, hz),
    )


def _whole(quantity: Quantity | None, hz: Fraction | None, step: int = 1) -> int | None:
    if quantity is None:
        return None
    return units.whole_limit(quantity, hz, least=step if quantity.per_second else 1)
