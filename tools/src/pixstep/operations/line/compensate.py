# SPDX-License-Identifier: MIT
"""Take up the play at the reversals of a plain line."""

from __future__ import annotations

import functools
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, TypedDict, cast

from pixstep import atomic, formats
from pixstep.errors import FINE, NEGATIVE, UserError
from pixstep.lazy import rich
from pixstep.lines import units
from pixstep.lines.line_check import MAX_COUNT
from pixstep.lines.units import Quantity
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, Choice, FindScale, Pixels, Steps, no_scale
from pixstep.operations.request import Request, argument, operation, option
from pixstep.operations.result import Page, Result
from pixstep.reversals import compensate
from pixstep.reversals.compensate import (
    FIRST,
    INITIAL_DIRECTIONS,
    UNKNOWN,
    LineTransition,
    MotionLimits,
    MotorCounts,
)


class _PixelsOrAuto(Pixels):
    """A number of pixels, or auto (None)."""

    name = "PIXELS|auto"

    def read(self, value: Any, scale: FindScale = no_scale) -> int | None:
        """Return the number; a bad one is told of with what would be right."""
        if value is None or value == "auto":
            return None
        try:
            return int(super().read(value, scale))
        except UserError:
            raise UserError(f"{value!r}: a number of pixels from 1, or auto") from None


class TransitionFacts(TypedDict):
    """A take-up at a reversal: pixels from 1, errors of the load in steps; see `Transition`."""

    pixel: int
    direction: int
    window_px: int
    steps: int
    missing: int
    peak_extra: int
    peak_speed: int
    peak_acceleration: int
    worst_error: int
    worst_pixel: int | None
    recovered_pixel: int | None


class CompensatedLine(TypedDict):
    """A line that was written with its play taken up; limits in steps and pixels."""

    file: str
    output: str
    play: int
    transition_px: int | Literal["auto"]
    max_acceleration: int
    start_stop: int
    max_speed: int
    initial_direction: str
    pixels: int
    complete: bool
    worst_load_error_steps: int
    worst_load_error_outside_steps: int
    transitions: list[TransitionFacts]


@operation("line compensate")
class LineCompensate(Request):
    """Take up the play at every reversal of a plain line.

    CSV holds the load's motion, OUTPUT gets the motor's: from the first pixel of each new direction
    (zero pixels before the motion included) the play is laid over the motion, without a jump. All
    pixels outside these transitions keep their counts. Exit status 1 if the next reversal breaks a
    transition off before all of the play is taken up, 2 if a transition does not fit.
    """

    result = CompensatedLine

    csv: Path = argument(FILE)
    play: int = option(
        Steps(1),
        "Play between motor and load: steps, or 25um.",
        required=True,
        machine=machine.play,
    )
    transition_px: int | None = option(
        _PixelsOrAuto(1),
        "Pixels to spread each take-up over; auto: the fewest that the limits allow.",
        default_text="auto",
    )
    max_acceleration: Quantity = shared.max_acceleration(
        "Largest acceleration, steps/px2 or steps/s2.", required=True
    )
    start_stop: Quantity = shared.start_stop(
        "Up to this speed the motor may start, stop and turn without a ramp: steps/px or steps/s.",
        required=True,
    )
    max_speed: Quantity | None = shared.max_speed(
        "Largest speed, steps/px or steps/s.", default_text=str(MAX_COUNT)
    )
    pixel_hz: Fraction | None = shared.pixel_hz(
        "Pixel frequency, for limits per second.", required=False
    )
    initial_direction: str = option(
        Choice(INITIAL_DIRECTIONS),
        "Where the play is taken up before the line: as by its first motion, in + or -; "
        "unknown: the first motion takes up all of it too.",
        default=FIRST,
    )
    raw: bool = shared.raw()
    output: Path = option(OUTPUT, "CSV file to write.", "-o", "--output", required=True)
    plot: Path | None = shared.picture()

    def run(self, desk: Desk) -> Result:
        """Take up the play, and write the line and the drawing."""
        read = formats.read_csv(self.csv, raw=self.raw)
        desk.say(read.notes)
        request = compensate.TakeUpRequest(
            self.play, self._limits(), self.transition_px, self.initial_direction
        )
        made = compensate.compensate(read.values, request, str(self.csv))
        with atomic.together():
            formats.write_csv(self.output, list(made.counts), read.header)
            if self.plot:
                from pixstep.reversals import picture  # matplotlib takes a second to load

                scale = desk.facts.scale_if_known()
                picture.draw(made, request, str(self.csv), self.pixel_hz, self.plot, scale)
        page = functools.partial(_page, self, made)
        status = FINE if made.complete else NEGATIVE
        return Result(self._data(request, made), page, status, value=made)

    def _limits(self) -> MotionLimits:
        """Return what the motor can do; no pixel holds more than MAX_COUNT steps."""
        whole = functools.partial(units.whole_limit, hz=self.pixel_hz)
        fast = MAX_COUNT if self.max_speed is None else whole(self.max_speed)
        return MotionLimits(
            whole(self.max_acceleration), whole(self.start_stop), min(fast, MAX_COUNT)
        )

    def _data(self, request: compensate.TakeUpRequest, made: MotorCounts) -> CompensatedLine:
        limits = request.limits
        return {
            "file": str(self.csv),
            "output": str(self.output),
            "play": self.play,
            "transition_px": self.transition_px or "auto",
            "max_acceleration": limits.max_acceleration,
            "start_stop": limits.start_stop,
            "max_speed": limits.max_speed,
            "initial_direction": self.initial_direction,
            "pixels": len(made.counts),
            "complete": made.complete,
            "worst_load_error_steps": max(map(abs, made.load_errors)),
            "worst_load_error_outside_steps": made.worst_outside,
            "transitions": [cast("TransitionFacts", asdict(item)) for item in made.transitions],
        }


def _page(asked: LineCompensate, made: MotorCounts, page: Page) -> None:
    """Write one row a reversal and the summary."""
    output, play = asked.output, asked.play
    if made.transitions:
        page.draw(_table(made.transitions))
    worst = max(made.transitions, key=lambda item: abs(item.worst_error), default=None)
    inside = f", {abs(worst.worst_error)} at pixel {worst.worst_pixel} inside one" if worst else ""
    page.tell(
        f"{output}: {len(made.counts)} pixels, {len(made.transitions)} transitions of "
        f"{play} steps; predicted load error at the pixel edges: "
        f"{made.worst_outside} steps away from the transitions{inside}"
    )
    for item in made.transitions:
        if item.missing:
            page.tell(
                f"{output}: pixel {item.pixel}: warning: the next reversal breaks the transition "
                f"off, {item.missing} of {item.missing + item.steps} steps are not taken up"
            )
    if asked.initial_direction == UNKNOWN:
        page.tell(
            "note: the first motion takes up all of the play; the load may stand up to "
            f"{play} steps ahead of where it should be, by what was taken up already"
        )


def _table(transitions: tuple[LineTransition, ...]) -> rich.table.Table:
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
