# SPDX-License-Identifier: MIT
"""Several line files of one command, one an axis, with options given once or per line."""

from fractions import Fraction
from pathlib import Path
from typing import TypedDict, TypeVar

from pixstep.cli.options import load_line
from pixstep.errors import UserError
from pixstep.lines.line import Line

Value = TypeVar("Value")


class LineOptions(TypedDict):
    """What the options of several lines say besides."""

    line_number: tuple[int, ...]
    raw: bool
    negative: bool


def per_line(values: tuple[Value, ...], count: int, default: Value, option: str) -> list[Value]:
    """Spread an option given never, once, or once per line."""
    if len(values) == count:
        return list(values)
    if len(values) > 1:
        raise UserError(f"{option} is given {len(values)} times for {count} lines")
    return [values[0] if values else default] * count


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
            negative=options["negative"] and rule == "smooth",
            number=number,
            pixel_hz=pixel_hz,
            divider=divider,
            refuse_faster=refuse_faster,
        )
        for path, rule, play, number in zip(csv, decodes, plays, numbers, strict=True)
    ]
