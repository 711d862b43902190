# SPDX-License-Identifier: MIT
"""Several line files of one command, one an axis, with options given once or per line."""

from fractions import Fraction
from pathlib import Path
from typing import TypedDict, TypeVar

import click

from pixstep.cli import directions
from pixstep.cli.options import load_line
from pixstep.errors import UserError
from pixstep.lines.line import Line

Value = TypeVar("Value")
negative_option = click.option(
    "--negative/--no-negative",
    default=None,
    help="Run smooth lines in the negative direction.  [default: as their motors]",
)
line_axes_option = click.option(
    "--axis", type=click.IntRange(0, 3), multiple=True,
    help="Axis; of several lines or a table the first of a row, or once per line.  [default: 0]",
)  # fmt: skip


class LineOptions(TypedDict):
    """What the options of several lines say besides."""

    line_number: tuple[int, ...]
    raw: bool
    negative: bool | None


def per_line(values: tuple[Value, ...], count: int, default: Value, option: str) -> list[Value]:
    """Spread an option given never, once, or once per line."""
    if len(values) == count:
        return list(values)
    if len(values) > 1:
        raise UserError(f"{option} is given {len(values)} times for {count} lines")
    return [values[0] if values else default] * count


def line_axes(axes: tuple[int, ...], count: int) -> list[int]:
    """Return the axis of each line: one axis is the first of a row, several are one per line.

    Raises UserError for another number of axes than lines, and for an axis with two lines.
    """
    if len(axes) == count:
        found = list(axes)
    elif len(axes) > 1:
        raise UserError(f"--axis is given {len(axes)} times for {count} lines")
    else:
        first = axes[0] if axes else 0
        found = list(range(first, first + count))
    for axis in found:
        if found.count(axis) > 1:
            raise UserError(f"axis {axis}: has {found.count(axis)} lines, one is possible")
    return found


def read_lines(
    csv: tuple[Path, ...],
    decode: tuple[str, ...],
    backlash: tuple[int, ...],
    options: LineOptions,
    *,
    pixel_hz: Fraction | None,
    divider: int = 1,
    refuse_faster: bool = False,
) -> list[Line]:
    """Read the lines, each with its decode rule and backlash."""
    decodes = per_line(decode, len(csv), "", "--decode")  # of which there is one at least
    plays = per_line(backlash, len(csv), 0, "--backlash")
    ctx = click.get_current_context()
    backwards = directions.negatives(ctx, given=options["negative"], lines=len(csv))
    chosen: tuple[int | None, ...] = options["line_number"]
    numbers = per_line(chosen, len(csv), None, "--line")
    if len(backlash) == 1 and len(csv) > 1:  # one figure for all means the smooth ones
        plays = [play if rule == "smooth" else 0 for play, rule in zip(plays, decodes, strict=True)]
    return [
        load_line(
            path,
            rule,
            play,
            raw=options["raw"],
            negative=negative and rule == "smooth",
            number=number,
            pixel_hz=pixel_hz,
            divider=divider,
            refuse_faster=refuse_faster,
            index=index,
        )
        for index, (path, rule, play, number, negative) in enumerate(
            zip(csv, decodes, plays, numbers, backwards, strict=True)
        )
    ]
