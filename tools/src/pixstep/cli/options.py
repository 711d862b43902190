# SPDX-License-Identifier: MIT
"""What the commands share: option types, the reading of line files, notes."""

import contextlib
import functools
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path

import click

from pixstep import atomic, extras, formats
from pixstep.board import boards
from pixstep.cli import machinedefaults, meantfor
from pixstep.cli.command import FOLDER, PICTURE
from pixstep.cli.quantities import Decorated, StepsType
from pixstep.errors import UserError, one_line
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.rational import parse_hz
from pixstep.profiles import madefor

Facts = Mapping[str, object]  # plain data, for JSON
Tell = Callable[[Facts, str], None]  # takes a board's facts, as data and as text
SCHEMA = 1  # of all --json output; a field that is added does not change it


class _Hz(click.ParamType[Fraction, Fraction | str]):
    """An exact frequency: 30, 29.97Hz or 30000/1001."""

    name = "HZ"

    def convert(
        self, value: Fraction | str, param: click.Parameter | None, ctx: click.Context | None
    ) -> Fraction:
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
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print facts as JSON, for programs."
)
out_option = click.option(
    "--out",
    type=FOLDER,
    required=True,
    help="Folder for the results; replaces only what an earlier run has left there.",
)


def _drawable(_ctx: click.Context, _param: click.Parameter, value: bool) -> bool:
    """Refuse drawings before anything is simulated, where they cannot be made."""
    if value:
        extras.require("matplotlib")
    return value


plots_option = click.option(
    "--plot", is_flag=True, callback=_drawable, help="Draw pictures (PNG) into the folder."
)
details_option = click.option(
    "--details", is_flag=True, help="Print every interrupt's count, cycles and latest start too."
)
no_check_option = click.option(
    "--no-check", "check", is_flag=True, default=True, flag_value=False,
    help="Leave the host's check of the line out: let the board judge it.",
)  # fmt: skip
LINE_NUMBER = click.IntRange(min=1)
line_option = click.option(
    "--line", "line_number", type=LINE_NUMBER, metavar="N", help="Line N of a file of many lines."
)


def load_line(
    path: Path,
    decode: str,
    backlash: int = 0,
    *,
    raw: bool = False,
    negative: bool = False,
    number: int | None = None,
    read: Callable[..., formats.MotionFile] = formats.read_motion,
    pixel_hz: Fraction | None = None,
    refuse_faster: bool = False,
    divider: int = 1,
    index: int = 0,
) -> Line:
    """Read a line of a CSV or CSB file; notes of what was tolerated go to the error stream.

    `number` chooses a line, from 1; without it the file must hold only one. A file that was made
    for another frequency than `pixel_hz` gets a note, and is refused on `refuse_faster` if that is
    higher. That is the frequency of pixels, each of `divider` edges of the clock. A file for
    another motor than that of line `index` of the command gets a note.
    """
    file = read(path, raw=raw)
    chosen = file.line(number)
    say(file.notes)
    say(meantfor.line_notes(path, file.header, index))
    say(madefor.notes(path, file.header, pixel_hz, refuse=refuse_faster, divider=divider))
    name = str(path) if number is None else f"{path} line {number}"
    return Line(chosen.values, decode, backlash, negative, name=name)


def teller(output: Path | None) -> Callable[..., None]:
    """Return `click.echo` on the stream that is free for words: not the one the output goes to."""
    return functools.partial(click.echo, err=atomic.is_stdout(output))


def plot_option(*other: str, what: str = "Draw into a file") -> Callable[[Decorated], Decorated]:
    """Return the option --plot of a command without a folder for results."""
    return click.option(
        "--plot", *other, type=PICTURE, metavar="FILE", help=f"{what}: .png, .svg or .pdf."
    )


def show_json(facts: Facts) -> None:
    """Print facts as JSON, with the version of its layout and the machine file that was used."""
    machine = machinedefaults.told(click.get_current_context(silent=True))
    click.echo(json.dumps({"schema": SCHEMA, **machine, **facts}, indent=2))


def show_json_row(facts: Facts) -> None:
    """Print facts as one row of JSON, where more rows follow as they come."""
    click.echo(json.dumps({"schema": SCHEMA, **facts}))


def deliver_facts(facts: Facts, text: str, output: Path | None = None, *, as_json: bool) -> None:
    """Print facts as JSON, or as text on the stream that is free for words."""
    if as_json:
        show_json(facts)
    else:
        teller(output)(text)


@contextlib.contextmanager
def board_rows(*, as_json: bool) -> Iterator[Tell]:
    """Yield what takes a board's facts, as data and as text; JSON comes at the end, whole."""
    rows: list[Facts] = []

    def take(row: Facts, text: str) -> None:
        rows.append(row)
        if not as_json:
            click.echo(text)

    try:
        yield take
    finally:
        if as_json:
            show_json({"boards": rows})


def say(notes: Iterable[str]) -> None:
    """Print notes to the error stream."""
    for note in notes:
        click.echo(f"note: {one_line(note)}", err=True)
