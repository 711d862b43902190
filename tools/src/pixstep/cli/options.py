# SPDX-License-Identifier: MIT
"""What the commands share: option types, the reading of line files, notes, errors."""

from fractions import Fraction
from pathlib import Path

import click

from pixstep import formats
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.rational import parse_hz

FILE = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False)


class _Hz(click.ParamType):
    """An exact frequency: 30, 29.97 or 30000/1001."""

    name = "HZ"

    def convert(self, value, param, ctx) -> Fraction:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, Fraction):
            return value
        try:
            return parse_hz(value)
        except UserError as error:
            return self.fail(str(error), param, ctx)


HZ = _Hz()
DECODE = click.Choice([SMOOTH, PLAIN])
pixel_hz_option = click.option(
    "--pixel-hz", type=HZ, required=True, help="30, 29.97 or 30000/1001."
)
backlash_option = click.option(
    "--backlash", type=click.IntRange(min=0), default=0, show_default=True, help="Steps of play."
)
raw_option = click.option(
    "--raw", is_flag=True, help="Take every row after a CSV header as a value."
)
LINE_NUMBER = click.IntRange(min=1)
line_option = click.option(
    "--line", "line_number", type=LINE_NUMBER, metavar="N", help="Line N of a file of many lines."
)


class Group(click.Group):
    """Turns a UserError of any command into one line and exit status 2."""

    def invoke(self, ctx: click.Context) -> object:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except UserError as error:
            click.echo(f"pixstep: {error}", err=True)
            return ctx.exit(2)


def load_line(
    path: Path,
    decode: str,
    backlash: int = 0,
    *,
    raw: bool = False,
    negative: bool = False,
    number: int | None = None,
) -> Line:
    """Read a line of a CSV or CSB file; notes of what was tolerated go to the error stream.

    `number` chooses a line, from 1; without it the file must hold only one.
    """
    read = formats.read_motion(path, raw=raw)
    chosen = read.line(number)
    say(read.notes)
    name = str(path) if number is None else f"{path} line {number}"
    return Line(chosen.values, decode, backlash, negative, name=name)


def say(notes) -> None:
    """Print notes to the error stream."""
    for note in notes:
        click.echo(f"note: {note}", err=True)
