# SPDX-License-Identifier: MIT
"""What the commands of `pixstep trajectory` share: scales, plays, transitions, reading a table."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TypedDict

import click

from pixstep.cli.manylines import Value, per_line
from pixstep.cli.options import say
from pixstep.cli.quantities import (
    Decorated,
    FiniteRange,
    StepsType,
    scale_if_known,
    scale_of,
)
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import DISTANCE, STEP, Quantity, Scale
from pixstep.trajectories import choose, circle, files
from pixstep.trajectories.circle import Circle
from pixstep.trajectories.model import Servo
from pixstep.trajectories.table import AXES, Table
from pixstep.trajectories.trace import Unit
from pixstep.trajectories.transitions import AxisPlay

AUTO = "auto"
NONE = "none"
MOST_POINTS = 1_000_000
_PER = re.compile(r".*/ *([^/ ]+) *")


class LengthType(click.ParamType[Quantity, Quantity | str]):
    """A length such as 0.125in, 3mm or 102400 (counts); the scale is asked for later."""

    name = "LENGTH"

    def convert(
        self, value: Quantity | str, param: click.Parameter | None, ctx: click.Context | None
    ) -> Quantity:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, Quantity):
            return value
        try:
            return units.parse(str(value), DISTANCE)
        except UserError as error:
            return self.fail(str(error), param, ctx)


@dataclass(frozen=True)
class GivenScale:
    """A scale as it was written, and the unit that lengths are told in."""

    scale: Scale
    unit: Unit


class ScaleType(click.ParamType[GivenScale, GivenScale | str]):
    """Counts of a length: 1638400 steps/in or 400 steps/mm."""

    name = "SCALE"

    def convert(
        self, value: GivenScale | str, param: click.Parameter | None, ctx: click.Context | None
    ) -> GivenScale:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, GivenScale):
            return value
        try:
            scale = units.parse_scale(value)
        except UserError as error:
            return self.fail(str(error), param, ctx)
        named = _PER.fullmatch(value)
        found = units.parse_length_unit(named[1]) if named else None
        if named is None or found is None or found[0] == STEP:  # um/step
            return GivenScale(scale, Unit(scale.length, scale.steps_per_unit))
        return GivenScale(scale, Unit(named[1], scale.steps_per_unit * found[1]))


class PointsType(click.ParamType[int | str, int | str]):
    """A number of points, or auto."""

    name = "POINTS|auto"

    def convert(
        self, value: int | str, param: click.Parameter | None, ctx: click.Context | None
    ) -> int | str:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, int) or value == AUTO:
            return value
        if not (value.isascii() and value.isdigit() and 1 <= int(value[:9]) <= MOST_POINTS):
            self.fail(f"{value!r}: a number of points from 1, or auto", param, ctx)
        return int(value)


_HIGHEST_HZ = 1_000_000  # of a servo


class BandwidthType(click.ParamType[float | str, float | str]):
    """The natural frequency of a servo in Hz, or none for a motor that follows at once."""

    name = "HZ|none"

    def convert(
        self, value: float | str, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | str:
        """Parse the text; a bad one is a usage error."""
        if not isinstance(value, str) or value == NONE:
            return value
        try:
            hz = float(value.removesuffix("Hz"))
        except ValueError:
            hz = 0.0
        if not 0 < hz < _HIGHEST_HZ:
            wanted = f"a frequency above 0 Hz and below {_HIGHEST_HZ} Hz, or none"
            self.fail(f"{value!r}: {wanted}", param, ctx)
        return hz


scale_option = click.option(
    "--scale", type=ScaleType(), metavar="SCALE",
    help='Counts of a length: "1638400 steps/in", "400 steps/mm".  [default: the motor\'s]',
)  # fmt: skip
_SERVO_HZ = "10"
_STEPPER_HZ = "20"  # a stepper swings at some tens of hertz, with its load at fewer


class PlayOptions(TypedDict):
    """What the options of play and transitions give."""

    play: tuple[int, ...]
    transition: tuple[int | str, ...]
    bandwidth: float | str
    damping: float
    max_added: int | None


def _play_options(bandwidth: str, motor: str) -> tuple[Callable[[Decorated], Decorated], ...]:
    """Return the options of play and transitions, for motors of a kind."""
    return (
        click.option(
            "--play", type=StepsType(0), multiple=True,
            help="Play of each axis in counts; once, or per axis.",
        ),
        click.option(
            "--transition", type=PointsType(), multiple=True, default=(AUTO,),
            help="Points in which play is taken up; once, or per axis. auto: those with the "
            "smallest error for the circle's radius, the play and --bandwidth.  [default: auto]",
        ),
        click.option(
            "--bandwidth", type=BandwidthType(), default=bandwidth, show_default=True,
            help=f"Natural frequency of {motor} that follows the table; none: a motor without lag.",
        ),
        click.option(
            "--damping", type=FiniteRange(0, 4), default=0.6, show_default=True,
            help="Damping of that motor.",
        ),
        click.option(
            "--max-added", type=StepsType(1),
            help="Counts that a transition may add in a point: what the motor's speed may jump by.",
        ),
    )  # fmt: skip


def play_options(command: Decorated) -> Decorated:
    """Give a command the options of play and transitions, for a servo."""
    return _with(_play_options(_SERVO_HZ, "the servo"), command)


def board_play_options(command: Decorated) -> Decorated:
    """Give a command the options of play and transitions, for steppers on a board."""
    return _with(_play_options(_STEPPER_HZ, "a stepper with its load"), command)


def _with(options: tuple[Callable[[Decorated], Decorated], ...], command: Decorated) -> Decorated:
    for option in reversed(options):
        command = option(command)
    return command


def unit_of(ctx: click.Context, given: GivenScale | None) -> Unit:
    """Return the unit to tell lengths in: of --scale, of the motor, else counts."""
    if given:
        return given.unit
    scale = scale_if_known(ctx)
    return Unit(scale.length, scale.steps_per_unit) if scale else Unit()


def counts_of(ctx: click.Context, length: Quantity, given: GivenScale | None) -> Fraction:
    """Return a length in counts. Raises UserError if that needs a scale which is missing."""
    if length.length == STEP:
        return length.value
    scale = given.scale if given else scale_of(ctx)
    if not scale:
        raise UserError(f"{length.text}: needs --scale, or a motor of a machine file")
    return length.in_steps(scale).value


def read_table(path: Path) -> Table:
    """Read a table; notes go to the error stream."""
    found, notes = files.read(path)
    say(notes)
    return found


def find_circle(made: Table) -> Circle | None:
    """Return the circle of a table; None if it is none."""
    try:
        return circle.find(made)
    except UserError:
        return None


def servo_of(options: PlayOptions) -> Servo | None:
    """Return the servo that the options describe."""
    bandwidth = options["bandwidth"]
    return None if isinstance(bandwidth, str) else Servo(bandwidth, options["damping"])


def axis_plays(
    options: PlayOptions, made: Table, hz: Fraction | None, most_added: int | None = None
) -> tuple[AxisPlay, ...]:
    """Return play and transition of each axis, as given or as chosen, at least as long as wanted.

    `most_added` is what the board allows. Raises UserError if they cannot be chosen.
    """
    plays = per_axis(options["play"], 0, "--play")
    steps = per_axis(options["transition"], AUTO, "--transition")
    limits = [limit for limit in (options["max_added"], most_added) if limit and limit > 0]
    made_of = []
    for play, points in zip(plays, steps, strict=True):
        least = choose.least_steps(play, min(limits)) if limits and play else 1
        if isinstance(points, str):
            points = _chosen(options, made, hz, play, least)
        elif points < least:
            raise UserError(
                f"--transition {points}: {play} counts add more than {min(limits)} in a point: at "
                f"least {least} points"
            )
        made_of.append(AxisPlay(play, points))
    return tuple(made_of)


def per_axis(values: tuple[Value, ...], default: Value, option: str) -> list[Value]:
    """Return a value for each axis, of an option given never, once, or for both."""
    if len(values) > AXES:
        raise UserError(f"{option} is given {len(values)} times for {AXES} axes")
    return per_line(values, AXES, default, option)


def crest_of(found: Circle, play: int, hz: Fraction | None, options: PlayOptions) -> choose.Crest:
    """Return where an axis of a circle reverses. Raises UserError if points have no time."""
    servo = servo_of(options)
    if servo and hz is None:
        raise UserError("a servo has a bandwidth in time: give --pixel-hz, the points a second")
    point_s = float(1 / hz) if hz else 1.0
    return choose.Crest(found.radius, found.points, play, point_s, servo)


def _chosen(options: PlayOptions, made: Table, hz: Fraction | None, play: int, least: int) -> int:
    """Return the best number of points for a circle."""
    if not play:
        return 1
    found = find_circle(made)
    if found is None:
        raise UserError(f"{made.name}: is no circle, so --transition is needed as a number")
    return choose.choose(crest_of(found, play, hz, options), least).steps
