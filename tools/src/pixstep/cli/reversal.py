# SPDX-License-Identifier: MIT
"""`pixstep line compensate`: take up the play at the reversals of a plain line."""

from __future__ import annotations

from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from pixstep import atomic, formats
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.options import (
    HZ,
    Facts,
    json_option,
    plot_option,
    raw_option,
    say,
    show_json,
    teller,
)
from pixstep.cli.quantities import ACCELERATION_TYPE, SPEED_TYPE, StepsType, scale_if_known
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.lines import units
from pixstep.lines.linecheck import MAX_COUNT
from pixstep.reversals.compensate import (
    FIRST,
    INITIAL_DIRECTIONS,
    UNKNOWN,
    Compensated,
    Request,
    Transition,
    compensate,
)
from pixstep.reversals.takeup import MotionLimits
from pixstep.simulation.report import new_console

if TYPE_CHECKING:
    import rich.box
    import rich.console
    import rich.table
else:
    rich = lazy("rich")


class _Pixels(click.ParamType[int | None, int | str | None]):
    """A number of pixels, or auto (None)."""

    name = "PIXELS|auto"

    def convert(
        self, value: int | str | None, param: click.Parameter | None, ctx: click.Context | None
    ) -> int | None:
        """Parse the text; a bad one is a usage error."""
        if value is None or isinstance(value, int):
            return value
        if value == "auto":
            return None
        try:
            pixels = units.parse_pixels(value)
        except UserError:
            pixels = 0
        if pixels < 1:
            self.fail(f"{value!r}: a number of pixels from 1, or auto", param, ctx)
        return pixels


class _Options(TypedDict):
    play: int
    transition_px: int | None
    max_acceleration: units.Quantity
    start_stop: units.Quantity
    max_speed: units.Quantity
    pixel_hz: Fraction | None
    initial_direction: str


@command("compensate")
@click.argument("csv", type=FILE)
@click.option(
    "--play", type=StepsType(1), required=True, help="Between motor and load: steps, or 25um."
)
@click.option(
    "--transition-px",
    type=_Pixels(),
    default="auto",
    help="Pixels to spread each take-up over; auto: the fewest that the limits allow.  "
    "[default: auto]",
)
@click.option(
    "--max-acceleration", type=ACCELERATION_TYPE, required=True, help="steps/px2 or steps/s2"
)
@click.option(
    "--start-stop",
    type=SPEED_TYPE,
    required=True,
    help="steps/px or steps/s; up to this speed the motor may start, stop and turn without a ramp.",
)
@click.option(
    "--max-speed", type=SPEED_TYPE, default=str(MAX_COUNT), show_default=True,
    help="steps/px or steps/s",
)  # fmt: skip
@click.option("--pixel-hz", type=HZ, help="Pixel frequency, for limits per second.")
@click.option(
    "--initial-direction",
    type=click.Choice(INITIAL_DIRECTIONS),
    default=FIRST,
    show_default=True,
    help="Where the play is taken up before the line: as by its first motion, in + or -; "
    "unknown: the first motion takes up all of it too.",
)
@raw_option
@click.option("-o", "--output", type=OUTPUT, required=True, help="CSV file to write.")
@plot_option()
@json_option
@click.pass_context
def line_compensate(
    ctx: click.Context,
    csv: Path,
    output: Path,
    plot: Path | None,
    as_json: bool,
    raw: bool,
    **options: Unpack[_Options],
) -> None:
    """Take up the play at every reversal of a plain line.

    CSV holds the load's motion, OUTPUT gets the motor's: from the first pixel of each new direction
    (zero pixels before the motion included) the play is laid over the motion, without a jump. All
    pixels outside these transitions keep their counts. Exit status 1 if the next reversal breaks a
    transition off before all of the play is taken up, 2 if a transition does not fit.
    """
    read = formats.read_csv(csv, raw=raw)
    say(read.notes)
    limits = _limits(options)
    request = Request(
        options["play"], limits, options["transition_px"], options["initial_direction"]
    )
    made = compensate(read.values, request, str(csv))
    with atomic.together():
        formats.write_csv(output, list(made.counts), read.header)
        if plot:
            _draw(made, request, csv, options["pixel_hz"], plot)
    if as_json:
        show_json(_report(csv, output, request, made))
    else:
        _print(new_console(stderr=atomic.is_stdout(output)), output, request, made)
    ctx.exit(0 if made.complete else 1)


def _limits(options: _Options) -> MotionLimits:
    """Return what the motor can do; no pixel holds more than MAX_COUNT steps."""
    hz = options["pixel_hz"]
    fast = units.whole_limit(options["max_speed"], hz)
    return MotionLimits(
        units.whole_limit(options["max_acceleration"], hz),
        units.whole_limit(options["start_stop"], hz),
        min(fast, MAX_COUNT),
    )


def _draw(made: Compensated, request: Request, csv: Path, hz: Fraction | None, plot: Path) -> None:
    from pixstep.reversals import picture  # matplotlib takes a second to load

    scale = scale_if_known(click.get_current_context())
    picture.draw(made, request, str(csv), hz, plot, scale)


def _report(csv: Path, output: Path, request: Request, made: Compensated) -> Facts:
    """Return everything as plain data."""
    worst = max(map(abs, made.load_errors))
    return {
        "file": str(csv),
        "output": str(output),
        "play": request.play,
        "transition_px": request.transition_px or "auto",
        **asdict(request.limits),
        "initial_direction": request.initial_direction,
        "pixels": len(made.counts),
        "complete": made.complete,
        "worst_load_error_steps": worst,
        "worst_load_error_outside_steps": made.worst_outside,
        "transitions": [asdict(item) for item in made.transitions],
    }


def _print(
    console: rich.console.Console, output: Path, request: Request, made: Compensated
) -> None:
    """Print one row a reversal and the summary."""
    tell = teller(output)
    if made.transitions:
        console.print(_table(made.transitions))
    worst = max(made.transitions, key=lambda item: abs(item.worst_error), default=None)
    inside = f", {abs(worst.worst_error)} at pixel {worst.worst_pixel} inside one" if worst else ""
    tell(
        f"{output}: {len(made.counts)} pixels, {len(made.transitions)} transitions of "
        f"{request.play} steps; predicted load error at the pixel edges: "
        f"{made.worst_outside} steps away from the transitions{inside}"
    )
    for item in made.transitions:
        if item.missing:
            tell(
                f"{output}: pixel {item.pixel}: warning: the next reversal breaks the transition "
                f"off, {item.missing} of {item.missing + item.steps} steps are not taken up"
            )
    if request.initial_direction == UNKNOWN:
        tell(
            "note: the first motion takes up all of the play; the load may stand up to "
            f"{request.play} steps ahead of where it should be, by what was taken up already"
        )


def _table(transitions: tuple[Transition, ...]) -> rich.table.Table:
    table = rich.table.Table(box=rich.box.SIMPLE_HEAD, pad_edge=False)
    names = ("from", "to", "way", "taken up", "extra", "speed", "accel", "load off", "right from")
    for name in names:
        table.add_column(name, justify="right", no_wrap=True)
    for item in transitions:
        off = f"{item.worst_error:+d} @{item.worst_pixel}" if item.worst_error else "0"
        table.add_row(
            str(item.pixel),
            str(item.last_pixel),
            "+" if item.direction > 0 else "-",
            str(item.steps),
            str(item.peak_extra),
            str(item.peak_speed),
            str(item.peak_acceleration),
            off,
            str(item.recovered_pixel or "never"),
        )
    table.caption = (
        "extra, speed: steps/pixel, accel: steps/pixel2, at most; load off: the\n"
        "largest error in steps at a pixel edge, and which; right from: the\n"
        "pixel from whose end on the load is where it should be"
    )
    table.caption_justify = "left"
    return table
