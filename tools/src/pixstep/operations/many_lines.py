# SPDX-License-Identifier: MIT
"""Fields of several lines: given never, once for all, or once for each."""

from __future__ import annotations

from typing import Any, TypeVar

from pixstep.errors import UserError
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared
from pixstep.operations.asked import AskedError
from pixstep.operations.request import option

Value = TypeVar("Value")


def axes_of_lines() -> Any:
    """Return the field of the axes that lines, or a table, go to."""
    return option(
        shared.AXIS, "Axis; of several lines or a table the first of a row, or once per line.",
        "--axis", many=True, machine=machine.axis, default_text="0",
    )  # fmt: skip


def per_line(
    values: tuple[Value, ...], count: int, default: Value, field: str, what: str = "lines"
) -> list[Value]:
    """Return a value for each line, of a field given never, once, or for each."""
    if len(values) == count:
        return list(values)
    if len(values) > 1:
        raise AskedError(f"{{{field}}} is given {len(values)} times for {count} {what}")
    return [values[0] if values else default] * count


def line_axes(axes: tuple[int, ...], count: int) -> list[int]:
    """Return the axis of each line: one axis is the first of a row, several are one per line.

    Raises UserError for another number of axes than lines, and for an axis with two lines.
    """
    first = axes[0] if axes else 0
    found = list(range(first, first + count))
    if len(axes) > 1 or count == 1:
        found = per_line(axes, count, 0, "axis")
    for axis in found:
        if found.count(axis) > 1:
            raise UserError(f"axis {axis}: has {found.count(axis)} lines, one is possible")
    return found
