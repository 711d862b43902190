# SPDX-License-Identifier: MIT
"""Lines of files: one of an operation, or several, one an axis, of fields given once or per line.

Notes of what was tolerated, and of files that are for another motor or frequency, are said. Which
way motors run is known here too, for what is asked in the directions of their loads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from pixstep import formats
from pixstep.errors import UserError
from pixstep.formats import ProfileHeader
from pixstep.lines.line import SMOOTH, Line
from pixstep.operations import machine_defaults, shared
from pixstep.operations.asked import AskedError
from pixstep.operations.facts import Facts
from pixstep.operations.kinds import FILE, Steps
from pixstep.operations.request import argument, flag, option
from pixstep.profiles import origin

if TYPE_CHECKING:
    from pixstep.operations.desk import Desk


def way(facts: Facts) -> int:
    """Return -1 if the motor runs backwards for its load to go forwards, else 1.

    Without a motor steps are those of the board.
    """
    if facts.found is None:
        return 1
    try:
        return -1 if facts.motor.negative else 1
    except UserError:
        if facts.named.any:
            raise
        return 1


def negatives(facts: Facts, *, given: bool | None, lines: int) -> list[bool]:
    """Return for each line whether a smooth one runs backwards: as its motor does, if none is said.

    `given` is what the caller says, or what the motors have in common.
    """
    if given is not None or facts.found is None or facts.other_kind():
        return [bool(given)] * lines
    found = [motor.negative for motor in facts.motors]
    return found if len(found) == lines else found[:1] * lines


def ways(facts: Facts, axes: int) -> tuple[int, ...]:
    """Return the same as `way` for each axis of a table; 1 unless motors or axes are named."""
    if facts.found is None or not facts.named.any:
        return (1,) * axes
    found = [-1 if motor.negative else 1 for motor in facts.motors]
    if len(found) not in (1, axes):
        raise AskedError(f"{{motor}} is given {len(found)} times for {axes} axes")
    return tuple(found * (axes // len(found)))


def motor_decode(facts: Facts, path: Path) -> str | None:
    """Return how the motor in a conventional file name decodes; None if nothing says it.

    The machine file knows its own motors, the printer's have their names.
    """
    named = origin.parse_name(path)
    if named is None:
        return None
    machine = facts.used
    if machine and named.motor in machine.motors:
        return machine[named.motor].decode
    return named.decode


def motor_notes(
    facts: Facts, path: Path, header: ProfileHeader | None, index: int = 0
) -> Iterator[str]:
    """Yield that a file is for another motor than the one it is used for, if that is so.

    `index` is the number of the line, of an operation that moves several motors.
    """
    motors = facts.motors_in_force
    if not motors:
        return
    motor = motors[index] if index < len(motors) else motors[0]
    yield from origin.other_motor(path, header.name if header else None, motor.name)


def line_notes(
    facts: Facts, path: Path, header: ProfileHeader | None, index: int = 0
) -> Iterator[str]:
    """Yield the same of a line, and that its header's lead-in is not the machine's."""
    yield from motor_notes(facts, path, header, index)
    machine = facts.used
    if machine is None or header is None or not header.lead_in_px:
        return
    if header.lead_in_px != machine.line.lead_in:
        yield (
            f"{path}: its header has LeadIn {header.lead_in_px}, {machine.path} has lead_in = "
            f"{machine.line.lead_in} in the table [line]: the image begins at another pixel"
        )


Value = TypeVar("Value")


def line_files() -> Any:
    """Return the field `csv` of several lines."""
    return argument(FILE, shown="FILE...", many=True)


def decodes() -> Any:
    """Return the field `decode` of several lines."""
    return shared.decode("How counts are decoded; once, or per line.", many=True)


def backlashes() -> Any:
    """Return the field `backlash` of several lines."""
    about = "Steps; once, or per line."
    return option(Steps(0), about, many=True, machine=machine_defaults.backlash)


def axes() -> Any:
    """Return the field `axis` of several lines, or of a table of two axes."""
    about = "Axis; for several lines or a table the first of consecutive axes, or once per line."
    return option(
        shared.AXIS, about, many=True, default_text="0", machine=machine_defaults.axis
    )  # fmt: skip


def negative() -> Any:
    """Return the field `negative` of several lines."""
    return flag(
        "Run smooth lines in the negative direction.", off="--no-negative", default=None,
        default_text="as their motors", machine=machine_defaults.negative,
    )  # fmt: skip


def line_numbers() -> Any:
    """Return the field `line_number` of several lines."""
    return shared.line_number("Line N of files of many lines; once, or per line file.", many=True)


class _SeveralLines(Protocol):
    """The fields of an operation that reads several lines."""

    @property
    def csv(self) -> tuple[Path, ...]: ...
    @property
    def decode(self) -> tuple[str, ...]: ...
    @property
    def backlash(self) -> tuple[int, ...]: ...
    @property
    def negative(self) -> bool | None: ...
    @property
    def line_number(self) -> tuple[int, ...]: ...
    @property
    def raw(self) -> bool: ...


def load_line(
    desk: Desk,
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
    """Read a line of a CSV or CSB file; the backlash of its header comes before a machine file's.

    `number` chooses a line, from 1; without it the file must hold only one. A file that was made
    for another frequency than `pixel_hz` gets a note, and is refused on `refuse_faster` if that is
    higher. That is the frequency of pixels, each of `divider` edges of the clock. A file for
    another motor than that of line `index` of the operation gets a note.
    """
    file = read(path, raw=raw)
    chosen = file.line(number)
    desk.say(file.notes)
    desk.say(line_notes(desk.facts, path, file.header, index))
    desk.say(
        origin.frequency_notes(path, file.header, pixel_hz, refuse=refuse_faster, divider=divider)
    )
    name = str(path) if number is None else f"{path} line {number}"
    play = backlash_of(desk, name, file.header, chosen.values, decode, backlash)
    return Line(chosen.values, decode, play, negative, name=name)


def backlash_of(
    desk: Desk, name: str, header: formats.ProfileHeader | None, counts: Sequence[int],
    decode: str, backlash: int,
) -> int:  # fmt: skip
    """Return the play that a line takes up: the caller's, its own, or the machine file's.

    What differs, and what nothing says, is said.
    """
    machine = str(desk.facts.machine.path) if desk.by_machine("backlash") else ""
    asked = origin.AskedBacklash(backlash, desk.given("backlash"), machine)
    play, notes = origin.taken(name, header, counts, decode, asked)
    desk.say(notes)
    return play


def read_lines(
    desk: Desk,
    asked: _SeveralLines,
    *,
    pixel_hz: Fraction | None,
    divider: int = 1,
    refuse_faster: bool = False,
    read: Callable[..., formats.MotionFile] = formats.read_motion,
) -> list[Line]:
    """Read the lines of an operation, each with its decode rule and backlash."""
    count = len(asked.csv)
    rules = per_line("decode", asked.decode, count, "")  # of which there is one at least
    plays = per_line("backlash", asked.backlash, count, 0)
    backwards = negatives(desk.facts, given=asked.negative, lines=count)
    chosen: tuple[int | None, ...] = asked.line_number
    numbers = per_line("line_number", chosen, count, None)
    if len(asked.backlash) == 1 and count > 1:  # one figure for all means the smooth ones
        plays = [play if rule == SMOOTH else 0 for play, rule in zip(plays, rules, strict=True)]
    return [
        load_line(
            desk,
            path,
            rule,
            play,
            raw=asked.raw,
            negative=backward and rule == SMOOTH,
            number=number,
            read=read,
            pixel_hz=pixel_hz,
            divider=divider,
            refuse_faster=refuse_faster,
            index=index,
        )
        for index, (path, rule, play, number, backward) in enumerate(
            zip(asked.csv, rules, plays, numbers, backwards, strict=True)
        )
    ]


def per_line(field: str, values: Sequence[Value], count: int, default: Value) -> list[Value]:
    """Spread the values of a field that is given never, once, or once per line."""
    if len(values) == count:
        return list(values)
    if len(values) > 1:
        lines = f"{count} line{'s' * (count != 1)}"
        raise AskedError(f"{{{field}}} is given {len(values)} times for {lines}")
    return [values[0] if values else default] * count


def line_axes(axes: Sequence[int], count: int) -> list[int]:
    """Return the axis of each line: one axis is the first of a row, several are one per line.

    Raises UserError for another number of axes than lines, and for an axis with two lines.
    """
    first = axes[0] if axes else 0
    row = tuple(range(first, first + count))
    found = per_line("axis", row if len(axes) < 2 else axes, count, 0)
    for axis in found:
        if found.count(axis) > 1:
            raise UserError(f"axis {axis}: has {found.count(axis)} lines, one is possible")
    return found
