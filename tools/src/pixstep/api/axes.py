# SPDX-License-Identifier: MIT
"""Which axis a line goes to: that of its motor, or the one that the caller names."""

from collections.abc import Mapping, Sequence

from pixstep import arguments
from pixstep.api import given
from pixstep.api.motions import MotionLine
from pixstep.errors import UserError

Lines = MotionLine | Sequence[MotionLine] | Mapping[int, MotionLine]
"""One line, several, or lines by axis."""


def by_axis(lines: Lines, axis: int | None = None) -> dict[int, MotionLine]:
    """Return lines by axis.

    One line goes to `axis`, else to the axis of its motor, else to axis 0; several to those of
    their motors, or to axes 0, 1, 2 ... if none has a motor. Raises UserError for no line at all,
    for two lines of one axis, and where an axis that is named is not that of the line's motor.
    """
    if isinstance(lines, MotionLine):
        chosen = lines.axis if axis is None else given.axis(axis)
        return _agreed({chosen: lines})
    if axis is not None:
        raise UserError(f"axis {arguments.shown(axis)}: only one line has an axis by it")
    if isinstance(lines, Sequence) and not isinstance(lines, str):
        return _in_order(lines)
    return _agreed(_checked(given.by_axis("lines", lines)))


def _in_order(lines: Sequence[MotionLine]) -> dict[int, MotionLine]:
    """Return lines that are given without axes."""
    found = _checked(dict(enumerate(lines)))
    if not any(item.motor for item in found.values()):
        return found
    placed: dict[int, MotionLine] = {}
    for item in found.values():
        if item.motor is None:
            raise UserError(f"{item.line.name}: has no motor, the others have: give lines by axis")
        if item.axis in placed:
            raise UserError(f"axis {item.axis}: has two lines, of motor {item.motor.name}")
        placed[item.axis] = item
    return placed


def _checked(lines: Mapping[int, MotionLine]) -> dict[int, MotionLine]:
    if not lines:
        raise UserError("no line is given")
    for axis, item in lines.items():
        arguments.instance(f"line of axis {axis}:", item, MotionLine, "a MotionLine")
    return dict(lines)


def _agreed(lines: dict[int, MotionLine]) -> dict[int, MotionLine]:
    """Return lines by axis; raises UserError for the line of another axis' motor."""
    for axis, item in lines.items():
        if item.motor and item.motor.axis != axis:
            raise UserError(
                f"{item.line.name}: is for motor {item.motor.name}, axis {item.motor.axis}, not "
                f"for axis {axis}"
            )
    return lines
