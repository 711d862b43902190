# SPDX-License-Identifier: MIT
"""`pixstep line show`, and what it has in common with `pixstep profile show`."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Unpack

import click

from pixstep import atomic, formats
from pixstep.cli import meantfor
from pixstep.cli.clockoptions import divider_option
from pixstep.cli.command import FILE, command
from pixstep.cli.machinedefaults import by_machine
from pixstep.cli.options import (
    DECODE,
    HZ,
    backlash_option,
    json_option,
    plot_option,
    raw_option,
    say,
    show_json,
    teller,
)
from pixstep.cli.quantities import (
    LimitOptions,
    PixelsType,
    limit_options,
    scale_if_known,
    whole_limit,
)
from pixstep.errors import UserError
from pixstep.lines import linecheck
from pixstep.lines.line import Line
from pixstep.lines.units import ACCELERATION, JERK, SPEED
from pixstep.profiles import madefor, page
from pixstep.profiles.drawing import Drawing
from pixstep.simulation.report import new_console


@command("show")
@click.argument("csv", type=FILE)
@click.option("--decode", type=DECODE, required=True)
@backlash_option
@raw_option
@click.option("--lead-in", type=PixelsType(0),
              help="Constant pixels before the image, to mark its start. Default: the header's.",
              )  # fmt: skip
@click.option("--pixel-hz", type=HZ, help="Pixel frequency. Default: the header's.")
@divider_option
@limit_options
@plot_option("-o", "--output")
@json_option
@click.pass_context
def line_show(
    ctx: click.Context,
    csv: Path,
    decode: str,
    backlash: int,
    raw: bool,
    lead_in: int | None,
    pixel_hz: Fraction | None,
    divider: int,
    plot: Path | None,
    as_json: bool,
    **limits: Unpack[LimitOptions],
) -> None:
    """Show speed, acceleration, jerk and position of a line: a table, with --plot a drawing."""
    read = formats.read_csv(csv, raw=raw)
    say(read.notes)
    pixel_hz = used_frequency(ctx, pixel_hz, csv, read.header, divider)
    if read.header:
        lead_in = read.header.lead_in_px if lead_in is None else lead_in
    shown = Line(read.values, decode, backlash, name=str(csv))
    _refuse_backlash(shown)
    bounds = drawn_limits(limits, pixel_hz)
    drawing = Drawing(
        shown, csv.name, pixel_hz, bounds, image_pixel(shown, lead_in), scale_if_known(ctx)
    )
    show_drawing(drawing, plot, as_json=as_json)


def used_frequency(
    ctx: click.Context,
    clock_hz: Fraction | None,
    path: Path,
    header: formats.ProfileHeader | None,
    divider: int = 1,
) -> Fraction | None:
    """Return the frequency of pixels: by --pixel-hz, else of the file itself, else the machine's.

    A pixel has `divider` edges of the clock. A file that was made for another frequency than is
    given gets a note.
    """
    say(meantfor.motor_notes(path, header))
    given = clock_hz and clock_hz / divider
    own = madefor.frequency(path, header)
    if own is None or (given and not by_machine(ctx, "pixel_hz")):
        say(madefor.notes(path, header, given, divider=divider))
        return given
    return own


def _refuse_backlash(line: Line) -> None:
    """Refuse a backlash that the line cannot take up: there is nothing right to draw."""
    for item in linecheck.check(line):
        if item.name.startswith("backlash"):
            raise UserError(f"{line.name}: {item.message}")


def drawn_limits(limits: LimitOptions, hz: Fraction | None) -> dict[int, int]:
    """Return the limits that are given, by order."""
    given = {
        SPEED: limits["max_speed"],
        ACCELERATION: limits["max_acceleration"],
        JERK: limits["max_jerk"],
    }
    found = {order: whole_limit(limit, hz) for order, limit in given.items()}
    return {order: value for order, value in found.items() if value is not None}


def image_pixel(line: Line, lead_in: int | None) -> int | None:
    """Return the 1-based pixel where the image starts, None if the lead-in is not known.

    It lies `lead_in` pixels after the first one at the line's speed.
    """
    if lead_in is None or not line.line_speed:
        return None
    if line.smooth:
        first = line.speeds.index(line.line_speed) + 1
    else:
        first = [abs(count) for count in line.counts].index(line.line_speed) + 1
    return first + lead_in if first + lead_in <= line.pixels else None


def show_drawing(drawing: Drawing, output: Path | None, *, as_json: bool) -> None:
    """Write the drawing if a file is given, then print the figures."""
    line, figures = drawing.line, drawing.figures
    if output is not None:
        from pixstep.profiles import figure  # matplotlib takes a second to load

        figure.save(drawing, output)
    if as_json:
        report = {
            "file": line.name,
            "drawing": str(output) if output else None,
            "decode": line.decode,
            "image_pixel": drawing.image_pixel,
            **page.figures_json(figures, drawing.pixel_hz),
        }
        show_json(report)
        return
    tell = teller(output)
    tell(f"{line.name}: decoded as {line.decode}")
    console = new_console(stderr=atomic.is_stdout(output))
    console.print(page.figures_table(figures, drawing.pixel_hz))
    if output is not None:
        tell(f"{output}: drawn")
