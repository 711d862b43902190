# SPDX-License-Identifier: MIT
"""What a machine file gives the fields of requests: each function is that of some fields.

None where the file does not say it, or where it does not fit what the caller says.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.lines.units import SPEED, Quantity

if TYPE_CHECKING:
    from pixstep.operations.facts import Facts

Default = Callable[["Facts"], object]


def _of(key: str) -> Callable[[Default], Default]:
    """Return what says of a default which key of the file it comes from."""

    def mark(default: Default) -> Default:
        default.key = key  # type: ignore[attr-defined]  # functions have room for it
        return default

    return mark


def key_of(default: Default) -> str:
    """Return the key of the machine file that a default comes from."""
    return str(getattr(default, "key", ""))


@_of("clock.pixel")
def clock_hz(facts: Facts) -> Fraction:
    """The frequency of the clock's edges, for operations that divide them or make a clock."""
    return facts.machine.clock_hz


@_of("clock.pixel / clock.divider")
def pixel_hz(facts: Facts) -> Fraction:
    """The frequency of pixels."""
    return facts.machine.pixel_hz


@_of("clock.divider")
def divider(facts: Facts) -> object:
    """The clock edges of a pixel."""
    return facts.machine.clock.divider


@_of("clock.sync")
def sync(facts: Facts) -> object:
    """What lines are to the pixel clock."""
    return facts.machine.clock.sync


@_of("clock.gate_edges")
def gate_edges(facts: Facts) -> object:
    """The edges from a burst's first one to line zero."""
    return facts.machine.clock.gate_edges


@_of("motors.NAME.kind")
def decode(facts: Facts) -> object:
    """Every line has a motor: the one there is serves one line only."""
    if facts.values.get("plain"):
        return None
    if not facts.many("decode"):
        return facts.motor.decode
    return tuple(motor.decode for motor in facts.motors)


@_of("motors.NAME.kind")
def decode_if_named(facts: Facts) -> object:
    """The same of a motor that the caller names."""
    return decode(facts) if facts.named.any else None


@_of("motors.NAME.kind")
def decode_of_csv(facts: Facts) -> object:
    """The same for a CSV profile, if one is wanted."""
    return decode_if_named(facts) if facts.values.get("csv") else None


@_of("motors.NAME.backlash")
def backlash(facts: Facts) -> object:
    """The play in steps, of smooth lines: only they take it up."""
    if facts.other_kind():
        return None
    steps = [motor.backlash_steps if motor.smooth else 0 for motor in facts.motors]
    return tuple(steps) if facts.many("backlash") else steps[0]


@_of("motors.NAME.direction")
def negative(facts: Facts) -> bool | None:
    """Whether the smooth motors run backwards; None for lines of both directions."""
    if facts.other_kind():
        return None
    smooth = [motor.negative for motor in facts.motors if motor.smooth]
    return any(smooth) if len(set(smooth)) < 2 else None


@_of("motors.NAME.direction")
def negative_of_motor(facts: Facts) -> bool | None:
    """Whether the one motor runs backwards."""
    return None if facts.other_kind() else facts.motor.negative


@_of("motors.NAME.axis")
def axis(facts: Facts) -> object:
    """The axes of the motors, in the order of their lines; those of a table are the board's."""
    if facts.named.table and not facts.named.any:
        return None
    axes = tuple(motor.axis for motor in facts.motors)
    return axes if facts.many("axis") else facts.motor.axis


@_of("motors.NAME.axis")
def axes(facts: Facts) -> object:
    """Which axes are meant, if motors are named."""
    return tuple(motor.axis for motor in facts.motors) if facts.named.any else None


@_of("boards.NAME.unit")
def units(facts: Facts) -> object:
    """The address of the board, for what is done with one board where nothing is said."""
    return (facts.board.unit,)


@_of("boards.NAME.unit")
def units_if_named(facts: Facts) -> object:
    """The same of named motors; what looks for all boards goes on doing so without."""
    return units(facts) if facts.named.any else None


def profile(use: str) -> Default:
    """Return the profile of the motor for lines ("line"), moves ("move") or homing ("home")."""

    @_of(f"motors.NAME.profiles.{use}")
    def find(facts: Facts) -> Path | None:
        return facts.machine.profile(facts.motor, use)

    return find


def of_line(key: str) -> Default:
    """Return a key of the file's table [line]."""
    return _of(f"line.{key}")(lambda facts: getattr(facts.machine.line, key))


@_of("line.lead_in, or LeadIn of motors.NAME.profiles.move")
def lead_in(facts: Facts) -> int:
    """The constant pixels before the image: those of the motor's CSV profile before the file's."""
    return facts.machine.lead_in_of(facts.motor)


def of_board(key: str) -> Default:
    """Return a key of the board; the bus and how it is spoken to may be the same for several."""

    @_of(f"boards.NAME.{key}")
    def value(facts: Facts) -> object:
        values = {getattr(board, key) for board in facts.boards.values()}
        return values.pop() if len(values) == 1 else getattr(facts.board, key)

    return value


@_of("boards.NAME.clock_out_hz")
def clock_wire(facts: Facts) -> bool:
    """Whether a simulated board has a wire from its own clock to its clock input."""
    return bool(facts.board.clock_out_hz)


def limit(key: str) -> Default:
    """Return a limit of the motor."""
    return _of(f"motors.NAME.limits.{key}")(lambda facts: facts.motor.limit(key))


def limit_of_one(key: str) -> Default:
    """Return the same where one motor is meant; those of several are each its line's."""
    of_motor = limit(key)
    named = _of(key_of(of_motor))
    return named(lambda facts: of_motor(facts) if len(facts.motors) == 1 else None)


@_of("motors.NAME.limits.max_speed")
def top_speed(facts: Facts) -> Quantity | None:
    """The highest speed of a profile within the motor's limit: even, in steps/pixel."""
    found = facts.motor.limit("max_speed")
    if found is None:
        return None
    speed = found.per_pixel(facts.machine.pixel_hz) // 2 * 2
    return Quantity(Fraction(speed), SPEED, False, str(speed))


@_of("motors.NAME.backlash")
def play(facts: Facts) -> object:
    """The play of one motor; of a table's axes only if the motors are named."""
    if not facts.many("play"):
        return facts.motor.backlash_steps or None
    return tuple(motor.backlash_steps for motor in facts.motors) if facts.named.any else None


@_of("motors.NAME.steps_per_unit")
def scale(facts: Facts) -> object:
    """The steps of a length, if all motors that are meant have the same."""
    return facts.scale()


@_of("motors.NAME.home_is_limit")
def home_is_limit(facts: Facts) -> object:
    """Whether the home switch is a limit switch too."""
    return facts.motor.home_is_limit


def folder(name: str) -> Default:
    """Return a folder's name: any machine file gives results a place."""
    return _of("any file")(lambda facts: Path(name) if facts.found else None)


def needs_motor(default: Default) -> bool:
    """True if a value comes from a motor, and not from the clock or a board alone."""
    return not key_of(default).startswith(("clock.", "boards."))
