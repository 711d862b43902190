# SPDX-License-Identifier: MIT
"""Lines that fly over the points of a scanspec, without a stop from the first to the last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from pixstep import arguments
from pixstep.api import given
from pixstep.api.given import Hz
from pixstep.api.machines import Motor
from pixstep.api.making import steps_of
from pixstep.api.words import Decode
from pixstep.errors import UserError
from pixstep.fly.scan_line import ScanLine
from pixstep.fly.scan_making import ScanDrive, ScanLines, axes_of, points_of
from pixstep.lines import units
from pixstep.lines.units import Scale

DEVIATION_STEPS = 2.0


def line_from_scanspec(
    spec: Any,
    *,
    motor: Motor | None = None,
    axis: str | None = None,
    pixel_hz: Hz | None = None,
    unit: str | None = None,
    steps_per_unit: str | Scale | None = None,
    decode: Decode | None = None,
    backlash: int | str | None = None,
    max_acceleration: float | str | None = None,
    run_up: int | str | None = None,
    max_deviation: float = DEVIATION_STEPS,
    check: bool = True,
) -> ScanLine:
    """Make the line of one axis that flies over the points of a scanspec.

    `axis` is needed if the spec has several. Positions are in `unit`, by default mm or degrees as
    the motor's scale has it (`steps_per_unit` without a motor), else steps. A point lasts as long
    as the spec says, in whole pixels; one pixel if the spec says nothing. `run_up` are the pixels
    before the first point and behind the last; without it as many as `max_acceleration`
    (steps/pixel2, or `"500 mm/s2"`, by default the motor's) needs. In the points the line is at
    most `max_deviation` steps from the scan at any pixel's edge. `check` refuses a line that the
    motor or its board could not make. The line knows where it begins (`start`) and which pixels are
    which point's (`points_of`). Raises UserError or RefusedError with axis, point and what fits:
    for gaps between points, for an axis that stands still, for a point that is no whole number of
    pixels, for a smooth motor that would turn back.
    """
    names = axes_of(spec)
    if axis is None:
        if len(names) > 1:
            raise UserError(f"axis: the spec has {', '.join(names)}: give one of them")
        axis = names[0]
    elif axis not in names:
        raise UserError(f"axis {arguments.shown(axis)}: the spec has {', '.join(names)}")
    motor = given.motor(motor)
    hz = given.exact_hz(pixel_hz) or (motor.pixel_hz if motor else None)
    drive = _drive(axis, motor, unit, steps_per_unit, decode, backlash, max_acceleration, hz)
    making = _making(spec, [drive], hz, run_up, max_deviation, check=check)
    return making.that_fit()[axis]


def lines_from_scanspec(
    spec: Any,
    motors: Mapping[str, Motor],
    *,
    max_acceleration: Mapping[str, float | str] | None = None,
    run_up: int | str | None = None,
    max_deviation: float = DEVIATION_STEPS,
    check: bool = True,
) -> dict[str, ScanLine]:
    """Make the lines of several axes that fly together, by the axes' names in the scanspec.

    `motors` are those of the axes, of one machine file. An axis of the spec that stands still needs
    none; each other one does. All lines have the same run-up and so the same pixels. The rest is as
    `line_from_scanspec` has it.
    """
    if not isinstance(motors, Mapping) or not motors:
        raise UserError(f"motors {arguments.shown(motors)}: expected motors by axis of the spec")
    names = axes_of(spec)
    for name in motors:
        if name not in names:
            raise UserError(f"axis {arguments.shown(name)}: the spec has {', '.join(names)}")
    rates = {given.exact_hz(motor.pixel_hz) for motor in motors.values()}
    if len(rates) > 1:
        raise UserError("motors: of machines with several pixel frequencies: one clock drives all")
    hz = rates.pop()
    limits = max_acceleration or {}
    drives = [
        _drive(name, motor, None, None, None, None, limits.get(name), hz)
        for name, motor in motors.items()
    ]
    making = _making(spec, drives, hz, run_up, max_deviation, check=check)
    for name in making.points.moving:
        if name not in motors:
            raise UserError(f"axis {name}: moves in the spec, and has no motor: give it one")
    return making.that_fit()


def _drive(
    axis: str,
    motor: Motor | None,
    unit: str | None,
    steps_per_unit: str | Scale | None,
    decode: Decode | None,
    backlash: int | str | None,
    acceleration: float | str | None,
    hz: Fraction | None,
) -> ScanDrive:
    motor = given.motor(motor)
    rule = given.decode(decode, motor)
    scale = given.scale(steps_per_unit, motor)
    named = unit or (scale.length if scale else "steps")
    factor = steps_of(arguments.text("unit", named), scale)
    if acceleration is None:
        limit = motor.limits.max_acceleration if motor else None
        most = Fraction(limit or 0)
    else:
        found = given.quantity("max_acceleration", acceleration, units.ACCELERATION, scale)
        most = given.needs_hz("max_acceleration", found, hz).per_pixel(hz)
    sign = -1 if motor and motor.negative else 1
    play = given.backlash(backlash, rule, motor)
    return ScanDrive(axis, motor, rule, named, scale, sign * factor, play, float(most))


def _making(
    spec: Any,
    drives: Sequence[ScanDrive],
    hz: Fraction | None,
    run_up: int | str | None,
    max_deviation: float,
    *,
    check: bool,
) -> ScanLines:
    """Return what makes the lines of some axes."""
    if hz is None:
        raise UserError("a scan's line needs a pixel frequency: pixel_hz or motor")
    return ScanLines(
        points_of(spec, hz), drives, hz,
        None if run_up is None else given.pixels("run_up", run_up),
        arguments.finite("max_deviation", max_deviation, 0),
        check=arguments.flag("check", check),
    )  # fmt: skip
