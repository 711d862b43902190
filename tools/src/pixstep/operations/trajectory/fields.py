# SPDX-License-Identifier: MIT
"""Fields of tables: their play and how it is taken up, scales, lengths, the run that is meant."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from pixstep import arguments
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import STEP, Quantity, Scale
from pixstep.operations import machine_defaults as machine
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.facts import Facts
from pixstep.operations.kinds import FILE, Number, Parsed, Steps
from pixstep.operations.reading_lines import per_line
from pixstep.operations.request import Request, argument, option, shared_fields
from pixstep.trajectories import circle, table, transitions
from pixstep.trajectories.circle import Circle, Unit
from pixstep.trajectories.table import AXES, TwoAxisTable
from pixstep.trajectories.transitions import Servo, TablePlay

AUTO = "auto"
NONE = "none"
MOST_POINTS = 1_000_000
_HIGHEST_HZ = 1_000_000  # of a servo
_SERVO_HZ = 10.0
_STEPPER_HZ = 20.0  # a stepper swings at some tens of hertz, with its load at fewer
_PER = re.compile(r".*/ *([^/ ]+) *")


class _Written(Parsed):
    """A text that a function reads; a number of Python's is read as it is written."""

    def judge(self, value: Any) -> Any:
        """Return what a number of Python's stands for."""
        return self.parse(arguments.shown(value))


@dataclass(frozen=True)
class GivenScale:
    """A scale as it was written, and the unit that lengths are told in."""

    scale: Scale
    unit: Unit


def _read_scale(text: str) -> GivenScale:
    """Return counts of a length: 1638400 steps/in or 400 steps/mm."""
    scale = units.parse_scale(text)
    named = _PER.fullmatch(text)
    found = units.parse_length_unit(named[1]) if named else None
    if named is None or found is None or found[0] == STEP:  # um/step
        return GivenScale(scale, Unit(scale.length, scale.steps_per_unit))
    return GivenScale(scale, Unit(named[1], scale.steps_per_unit * found[1]))


class _ScaleKind(Parsed):
    """Counts of a length, as they are written or as a motor has them."""

    def judge(self, value: Any) -> GivenScale:
        """Return the scale of a motor."""
        if isinstance(value, GivenScale):
            return value
        if isinstance(value, Scale):
            return GivenScale(value, Unit(value.length, value.steps_per_unit))
        raise UserError(f"{arguments.shown(value)}: expected a text, as 400 steps/mm")


def _read_points(text: str) -> int | str:
    """Return a number of points, or auto."""
    if text == AUTO:
        return text
    if not (text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= MOST_POINTS):
        raise UserError(f"{text!r}: a number of points from 1, or auto")
    return int(text)


def _read_bandwidth(text: str) -> float | str:
    """Return the natural frequency of a servo in Hz, or none for a motor that follows at once."""
    if text == NONE:
        return text
    try:
        hz = float(text.removesuffix("Hz"))
    except ValueError:
        hz = 0.0
    if not 0 < hz < _HIGHEST_HZ:
        wanted = f"a frequency above 0 Hz and below {_HIGHEST_HZ} Hz, or none"
        raise UserError(f"{text!r}: {wanted}")
    return hz


def table_argument() -> Any:
    """Return the field of a table that is read."""
    return argument(FILE)


def scale() -> Any:
    """Return the field of the counts of a length."""
    return option(
        _ScaleKind("SCALE", _read_scale, "str"),
        'Counts of a length: "1638400 steps/in", "400 steps/mm".', default_text="the motor's",
        machine=machine.scale,
    )  # fmt: skip


def _bandwidth(hz: float, motor: str) -> Any:
    return option(
        _Written("HZ|none", _read_bandwidth, "float | str"),
        f"Natural frequency of {motor} that follows the table; none: a motor without lag.",
        default=hz, default_text=f"{hz:g}",
    )  # fmt: skip


@shared_fields
class PlayFields(Request):
    """The play of a table's axes, and how it is taken up: by a servo."""

    play: tuple[int, ...] = option(
        Steps(0), "Play of each axis in counts; once, or per axis.", many=True, machine=machine.play
    )
    transition: tuple[int | str, ...] = option(
        _Written("POINTS|auto", _read_points, "int | str"),
        "Points in which play is taken up; once, or per axis. auto: those with the smallest error "
        "for the circle's radius, the play and --bandwidth.",
        many=True, default=(AUTO,), default_text=AUTO,
    )  # fmt: skip
    bandwidth: float | str = _bandwidth(_SERVO_HZ, "the servo")
    damping: float = option(Number(0, 4), "Damping of that motor.", default=0.6)
    max_added: int | None = option(
        Steps(1),
        "Most counts that a transition may add in a point: the jump that the motor's speed can "
        "take.",
    )

    @property
    def servo(self) -> Servo | None:
        """The servo; None for a motor without lag."""
        hz = self.bandwidth
        return None if isinstance(hz, str) else Servo(hz, self.damping)

    def axis_plays(
        self, made: TwoAxisTable, hz: Fraction | None, most_added: int | None = None
    ) -> tuple[TablePlay, ...]:
        """Return play and transition of each axis, as given or as chosen, as long as wanted.

        `most_added` is what the board allows. Raises UserError if they cannot be chosen.
        """
        plays, steps = per_axis(self.play, 0, "play"), per_axis(self.transition, AUTO, "transition")
        limits = [limit for limit in (self.max_added, most_added) if limit and limit > 0]
        made_of = []
        for play, points in zip(plays, steps, strict=True):
            least = transitions.least_steps(play, min(limits)) if limits and play else 1
            if isinstance(points, str):
                points = self._chosen(made, hz, play, least)
            elif points < least:
                raise AskedError(
                    f"{{transition}} {points}: {play} counts add more than {min(limits)} in a "
                    f"point: at least {least} points"
                )
            made_of.append(TablePlay(play, points))
        return tuple(made_of)

    def crest(self, found: Circle, play: int, hz: Fraction | None) -> transitions.Crest:
        """Return where an axis of a circle reverses. Raises UserError if points have no time."""
        if self.servo and hz is None:
            raise AskedError(
                "a servo has a bandwidth in time: give {pixel_hz}, the points a second"
            )
        point_s = float(1 / hz) if hz else 1.0
        return transitions.Crest(found.radius, found.points, play, point_s, self.servo)

    def _chosen(self, made: TwoAxisTable, hz: Fraction | None, play: int, least: int) -> int:
        """Return the best number of points for a circle."""
        if not play:
            return 1
        found = find_circle(made)
        if found is None:
            raise AskedError(
                "{name}: is not a circle, so {transition} is needed as a number", name=made.name
            )
        return transitions.choose(self.crest(found, play, hz), least).steps


@shared_fields
class BoardPlayFields(PlayFields):
    """The same by steppers on a board."""

    bandwidth: float | str = _bandwidth(_STEPPER_HZ, "a stepper with its load")


def per_axis(values: tuple[Any, ...], default: Any, field: str) -> list[Any]:
    """Return a value for each axis, of a field given never, once, or for both."""
    if len(values) > AXES:
        raise AskedError(f"{{{field}}} is given {len(values)} times for {AXES} axes")
    return per_line(field, values, AXES, default)


def unit_of(given: GivenScale | None) -> Unit:
    """Return the unit to tell lengths in: of the scale, else counts."""
    return given.unit if given else Unit()


def counts_of(facts: Facts, length: Quantity, given: GivenScale | None) -> Fraction:
    """Return a length in counts. Raises UserError if that needs a scale which is missing."""
    if length.length == STEP:
        return length.value
    known = given.scale if given else facts.scale()
    if not known:
        raise AskedError("{text}: needs {scale}, or a motor of a machine file", text=length.text)
    return length.in_steps(known).value


def read_table(desk: Desk, path: Path) -> TwoAxisTable:
    """Read a table; what was tolerated is noted."""
    found, notes = table.read(path)
    desk.say(notes)
    return found


def find_circle(made: TwoAxisTable) -> Circle | None:
    """Return the circle of a table; None if it is none."""
    try:
        return circle.find(made)
    except UserError:
        return None
