# SPDX-License-Identifier: MIT
"""`pixstep line import`: a line from a user's own table of numbers."""

from fractions import Fraction
from pathlib import Path
from typing import TypedDict, Unpack

import click

from pixstep import atomic, formats
from pixstep.cli.clockoptions import divider_option
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.options import DECODE, HZ, Facts, json_option, say, show_json, teller
from pixstep.cli.quantities import scale_of
from pixstep.errors import RefusedError
from pixstep.formats.findings import counted
from pixstep.lines import linecheck
from pixstep.lines.line import SMOOTH
from pixstep.owndata import Imported, Request, import_line
from pixstep.owndata.naming import QUANTITIES
from pixstep.owndata.numerals import DECIMALS
from pixstep.owndata.table import BLANK, NONE, SEPARATORS
from pixstep.profiles import madefor


class _Options(TypedDict):
    column: str | None
    quantity: str | None
    negative: bool
    separator: str | None
    decimal: str | None


@command("import")
@click.argument("table", metavar="FILE", type=FILE)
@click.option("--decode", type=DECODE, required=True, help="What the motor is.")
@click.option("--column", metavar="NAME|N", help="Column to take, if there are several.")
@click.option(
    "--quantity",
    type=click.Choice(QUANTITIES),
    help="What it holds for each pixel.  [default: by the header; whole numbers: steps]",
)
@click.option(
    "--unit",
    "length_unit",
    metavar="UNIT",
    help="steps, mm, um, deg ...; of speeds also mm/s or um/px.  [default: by the header]",
)
@click.option(
    "--separator",
    type=click.Choice((*SEPARATORS, BLANK, NONE)),
    help="What divides the fields.  [default: by the file]",
)
@click.option(
    "--decimal",
    type=click.Choice(tuple(DECIMALS)),
    help="What divides the decimals; the other one thousands.  [default: by the file]",
)
@click.option("--pixel-hz", type=HZ, help="Pixel clock: for speeds per second, and to check times.")
@divider_option
@click.option("--negative/--no-negative", help="Turn the direction round.")
@click.option("--fit", is_flag=True, help="Smooth motors: make the nearest line that they can.")
@click.option("-o", "--output", type=OUTPUT, required=True, help="CSV file to write.")
@json_option
@click.pass_context
def line_import(
    ctx: click.Context,
    table: Path,
    decode: str,
    length_unit: str | None,
    pixel_hz: Fraction | None,
    divider: int,
    output: Path,
    as_json: bool,
    fit: bool,
    **options: Unpack[_Options],
) -> None:
    """Make a line of your own table: what a spreadsheet exports, or what numpy's savetxt writes.

    One row a pixel (positions: one more, the start). Lengths need a motor of the machine file. What
    was assumed is printed; a table that can be read in two ways, or a line that the motor cannot
    make, is refused and not written.
    """
    line_hz = pixel_hz and pixel_hz / divider
    request = Request(decode, line_hz, unit=length_unit, scale=scale_of(ctx), fit=fit, **options)
    made = import_line(table, request)
    _refuse(table, made, fit=fit)
    header = madefor.of_pixels(output, 0, line_hz, divider) if line_hz else None
    formats.write_csv(output, list(made.line.counts), header)
    if as_json:
        show_json(_report(table, output, made))
        return
    say(made.assumed)
    say(f"pixel {item.pixel}: {item.name}: {item.message}" for item in made.findings)
    size = f"{counted(made.line.pixels, 'pixel')}, {counted(made.line.total_steps, 'step')}"
    teller(output)(f"{output}: {size}, {made.line.decode}")


def _refuse(table: Path, made: Imported, *, fit: bool) -> None:
    """Raise RefusedError for the first thing that no board would take."""
    for item in made.findings:
        if item.severity == linecheck.ERROR:
            hint = "" if fit or made.line.decode != SMOOTH else " (--fit makes the nearest line)"
            raise RefusedError(f"{table}: pixel {item.pixel}: {item.name}: {item.message}{hint}")


def _report(table: Path, output: Path, made: Imported) -> Facts:
    """Return everything as plain data."""
    return {
        "file": str(table),
        "output": None if atomic.is_stdout(output) else str(output),
        "decode": made.line.decode,
        "negative": made.line.negative,
        "pixels": made.line.pixels,
        "steps": made.line.total_steps,
        "largest_error_steps": float(made.largest_error_steps),
        "assumed": list(made.assumed),
        "findings": linecheck.as_json(list(made.findings)),
    }
