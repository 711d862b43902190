# SPDX-License-Identifier: MIT
"""Several line files of one command, one an axis, with options given once or per line."""

from pathlib import Path

from pixstep.cli.options import load_line
from pixstep.errors import UserError
from pixstep.lines.line import Line


def per_line(values: tuple, count: int, default: object, option: str) -> list:
    """Spread an option given never, once, or once per line."""
    if len(values) == count:
        return list(values)
    if len(values) > 1:
        raise UserError(f"{option} is given {len(values)} times for {count} lines")
    return [values[0] if values else default] * count


def read_lines(
    csv: tuple[Path, ...],
    decode: tuple,
    backlash: tuple,
    options: dict,
    *,
    refuse_faster: bool = False,
) -> list[Line]:
    """Read the lines, each with its decode rule and backlash."""
    decodes = per_line(decode, len(csv), None, "--decode")
    plays = per_line(backlash, len(csv), 0, "--backlash")
    numbers = per_line(options["line_number"], len(csv), None, "--line")
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
            pixel_hz=options["pixel_hz"],
            divider=options.get("divider") or 1,
            refuse_faster=refuse_faster,
        )
        for path, rule, play, number in zip(csv, decodes, plays, numbers, strict=True)
    ]
