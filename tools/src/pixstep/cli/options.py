# SPDX-License-Identifier: MIT
"""What the commands share: option types, the reading of line files, notes, errors."""

import contextlib
import errno
import functools
import os
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import click

from pixstep import atomic, formats, signals
from pixstep.board import boards
from pixstep.cli.quantities import StepsType
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.rational import parse_hz
from pixstep.profiles import madefor

FILE = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False)


class _Hz(click.ParamType):
    """An exact frequency: 30, 29.97Hz or 30000/1001."""

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
    "--backlash", type=StepsType(0), default=0, show_default=True, help="Steps of play, or 3um."
)
clock_option = click.option(
    "--board",
    type=click.Choice(boards.BOARD_NAMES),
    default=boards.DEFAULT,
    show_default=True,
    help="Whose timer ticks are counted.",
)
raw_option = click.option(
    "--raw", is_flag=True, help="Take every row after a CSV header as a value."
)
LINE_NUMBER = click.IntRange(min=1)
line_option = click.option(
    "--line", "line_number", type=LINE_NUMBER, metavar="N", help="Line N of a file of many lines."
)


class Group(click.Group):
    """Turns what ends a command early into one line and an exit status.

    A UserError, and what the system refuses, is 2; Ctrl-C, SIGTERM and SIGHUP are 128 and the
    signal's number.
    """

    def main(self, *arguments, **options) -> object:
        """Run the command line; SIGTERM and SIGHUP end it as Ctrl-C does."""
        with signals.caught():
            return super().main(*arguments, **options)

    def invoke(self, ctx: click.Context) -> object:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except UserError as error:
            _tell(str(error))
            return ctx.exit(2)
        except KeyboardInterrupt as error:
            _tell(f"ended by {signals.name(error)}")
            return ctx.exit(signals.status(error))
        except OSError as error:
            if error.errno == errno.EPIPE:  # click ends the command in order
                raise
            named = f"{os.fsdecode(error.filename)}: " if error.filename is not None else ""
            _tell(f"{named}{error.strerror or error}")
            return ctx.exit(2)
        except click.Abort as error:  # at a prompt, for which click takes a KeyboardInterrupt
            ended = error.__context__
            if not isinstance(ended, KeyboardInterrupt):
                raise
            _tell(f"ended by {signals.name(ended)}")
            return ctx.exit(signals.status(ended))


def _tell(text: str) -> None:
    """Print a line on the error stream, if that is still there: a closed terminal is not."""
    with contextlib.suppress(OSError):
        click.echo(f"pixstep: {text}", err=True)


def load_line(
    path: Path,
    decode: str,
    backlash: int = 0,
    *,
    raw: bool = False,
    negative: bool = False,
    number: int | None = None,
    pixel_hz: Fraction | None = None,
    refuse_faster: bool = False,
) -> Line:
    """Read a line of a CSV or CSB file; notes of what was tolerated go to the error stream.

    `number` chooses a line, from 1; without it the file must hold only one. A file that was made
    for another frequency than `pixel_hz` gets a note, and is refused on `refuse_faster` if that is
    higher.
    """
    read = formats.read_motion(path, raw=raw)
    chosen = read.line(number)
    say(read.notes)
    say(madefor.notes(path, read.header, pixel_hz, refuse=refuse_faster))
    name = str(path) if number is None else f"{path} line {number}"
    return Line(chosen.values, decode, backlash, negative, name=name)


def teller(output: Path | None) -> Callable[..., None]:
    """Return `click.echo` on the stream that is free for words: not the one the output goes to."""
    return functools.partial(click.echo, err=atomic.is_stdout(output))


def refuse_json_beside(output: Path | None, *, as_json: bool) -> None:
    """Refuse to write a file and JSON to the same stream."""
    if as_json and atomic.is_stdout(output):
        raise UserError("--json and the output both go to the standard output: name a file")


def refuse_input(output: Path | None, *inputs: Path) -> None:
    """Refuse an output that is one of the inputs: a slip would lose what cannot be made again."""
    for path in inputs:
        with contextlib.suppress(OSError):
            if output is not None and output.samefile(path):
                raise UserError(f"{output}: is the input: name another file for the output")


def refuse_same(output: Path, other: Path | None, option: str) -> None:
    """Refuse two outputs in one file."""
    if other is not None and os.path.realpath(output) == os.path.realpath(other):
        raise UserError(f"{other}: {option} and -o are the same file")


def say(notes) -> None:
    """Print notes to the error stream."""
    for note in notes:
        click.echo(f"note: {note}", err=True)
