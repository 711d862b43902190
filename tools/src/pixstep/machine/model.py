# SPDX-License-Identifier: MIT
"""What a machine file holds, each value checked by itself, then all of them together."""

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr

from pixstep.board import boards
from pixstep.board.port import LAST_UNIT, LEAST_BAUD, MOST_BAUD
from pixstep.errors import AskedText, UserError
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import (
    ACCELERATION,
    DISTANCE,
    JERK,
    SPEED,
    Quantity,
    Scale,
    hz_words,
    parse_hz,
)
from pixstep.profiles.origin import MOST_EDGES

PARITIES = ("E", "O", "N")


def _by(parse: Callable[[str], Any]) -> BeforeValidator:
    """Return a validator for what `parse` reads: texts with a unit, and bare numbers."""

    def check(value: object) -> object:
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise ValueError("expected a text with a unit, or a number")
        try:
            return parse(value if isinstance(value, str) else repr(value))
        except UserError as error:
            raise ValueError(str(error)) from None

    return BeforeValidator(check)


def _board_kind(text: str) -> str:
    if text not in boards.BOARD_NAMES:
        raise UserError(f"expected one of {', '.join(boards.BOARD_NAMES)}")
    return text


def _clock_out_hz(text: str) -> int:
    hz = parse_hz(text)
    if hz.denominator != 1 or hz > boards.MOST_CLOCK_OUT_HZ:
        raise UserError(f"expected a whole number from 1 to {boards.MOST_CLOCK_OUT_HZ:,} Hz")
    return int(hz)


Hz = Annotated[Fraction, _by(parse_hz)]
ClockOutHz = Annotated[int, _by(_clock_out_hz)]
Seconds = Annotated[Fraction, _by(units.parse_seconds)]
StepScale = Annotated[Scale, _by(units.parse_scale)]
Pixels = Annotated[int, _by(units.parse_pixels)]
Distance = Annotated[Quantity, _by(partial(units.parse, order=DISTANCE))]
SignedDistance = Annotated[Quantity, _by(partial(units.parse, order=DISTANCE, signed=True))]
Speed = Annotated[Quantity, _by(partial(units.parse, order=SPEED))]
Acceleration = Annotated[Quantity, _by(partial(units.parse, order=ACCELERATION))]
Jerk = Annotated[Quantity, _by(partial(units.parse, order=JERK))]


class _MachineTable(BaseModel):
    """A table of the file: no key but those that are known."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True
    )


class ClockTable(_MachineTable):
    """The pixel clock: how often it has an edge, how many are a pixel, what lines are to it."""

    pixel: Hz
    divider: Annotated[int, Field(ge=1, le=MOST_EDGES)] | None = None
    sync: Literal["free", "start", "lock"] | None = None
    gate_edges: Annotated[int, Field(ge=0, le=boards.MOST_GATE_EDGES)] | None = None

    @property
    def edges(self) -> int:
        """Edges of a pixel, one if the file does not say."""
        return self.divider or 1


class BoardTable(_MachineTable):
    """A board: what it is, and where on which port it answers."""

    kind: Annotated[str, _by(_board_kind)]
    port: str | None = None
    unit: Annotated[int, Field(ge=1, le=LAST_UNIT)] = 1
    baud: Annotated[int, Field(ge=LEAST_BAUD, le=MOST_BAUD)] | None = None
    parity: Literal["E", "O", "N"] | None = None
    clock_out_hz: ClockOutHz | None = None


class LimitsTable(_MachineTable):
    """What a motor can do: none of them is needed."""

    max_speed: Speed | None = None
    max_acceleration: Acceleration | None = None
    max_jerk: Jerk | None = None
    start_stop: Speed | None = None


class ProfilesTable(_MachineTable):
    """Acceleration profiles: of lines (PRN), of fast moves and of homing (CSV or CSB)."""

    line: str | None = None
    move: str | None = None
    home: str | None = None


class MotorEpicsTable(_MachineTable):
    """A motor as a record of EPICS: the record's name, and fields in place of what follows."""

    name: str | None = None
    fields: dict[str, str | int | float] = {}


class EpicsTable(_MachineTable):
    """What the records of all motors have in common."""

    prefix: str | None = None


class MotorTable(_MachineTable):
    """A motor: its place, its kind, its scale and its limits."""

    name: str
    axis: Annotated[int, Field(ge=0)]
    word: Literal["X", "Y", "Z", "A", "B", "C", "U", "V", "W"] | None = None
    kind: Literal["smooth", "plain"]
    board: str | None = None
    steps_per_unit: StepScale | None = None
    direction: Literal["+", "-"] = "+"
    backlash: Distance = Quantity(Fraction(0), DISTANCE, False, "0")
    home_is_limit: Literal["none", "minus", "plus"] | None = None
    limits: LimitsTable = LimitsTable()
    profiles: ProfilesTable = ProfilesTable()
    epics: MotorEpicsTable = MotorEpicsTable()

    @property
    def decode(self) -> str:
        """How its lines are decoded: smooth or plain."""
        return SMOOTH if self.kind == "smooth" else PLAIN

    @property
    def smooth(self) -> bool:
        """True if its speed changes inside a pixel."""
        return self.decode == SMOOTH

    @property
    def negative(self) -> bool:
        """True if the load's positive direction is the motor's negative one."""
        return self.direction == "-"

    @property
    def backlash_steps(self) -> int:
        """Its play in steps."""
        return self.backlash.in_steps(self.steps_per_unit).whole_steps()

    def limit(self, name: str) -> Quantity | None:
        """Return a limit by its key, in steps; None if the file has none."""
        given: Quantity | None = getattr(self.limits, name)
        return given.in_steps(self.steps_per_unit) if given else None


class LineTable(_MachineTable):
    """What lines have in common: whose they are, how long they are, where images are in them."""

    motor: str | None = None
    pixels: Annotated[Pixels, Field(ge=1)] | None = None
    lead_in: Annotated[Pixels, Field(ge=0)] = 0
    lead_out: Annotated[Pixels, Field(ge=0)] | None = None
    scan_offset_forward: SignedDistance = Quantity(Fraction(0), DISTANCE, False, "0")
    scan_offset_back: SignedDistance = Quantity(Fraction(0), DISTANCE, False, "0")


class ProgramTable(_MachineTable):
    """What motion programs have in common: their units of time, their feed rates."""

    feed_time: Annotated[Seconds, Field(gt=0)] = Fraction(1)
    top_feed: Annotated[float, Field(gt=0)] | None = None
    other_feed: Annotated[float, Field(gt=0)] | None = None
    segment_time: Annotated[Seconds, Field(ge=0, le=Fraction(255, 1000))] = Fraction(0)


class MachineTables(_MachineTable):
    """A machine: `machine["M39"]` is a motor. `files.MachineFile` is one that comes from a file."""

    clock: ClockTable
    boards: dict[str, BoardTable] = Field(min_length=1)
    motors: dict[str, MotorTable] = Field(min_length=1)
    line: LineTable = LineTable()
    program: ProgramTable = ProgramTable()
    epics: EpicsTable = EpicsTable()
    _path: Path = PrivateAttr(default=Path("machine.toml"))

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    @property
    def pixel_hz(self) -> Fraction:
        """The frequency of pixels, exact."""
        return self.clock.pixel / self.clock.edges

    @property
    def clock_hz(self) -> Fraction:
        """The frequency of the clock's edges, of which `clock.divider` are a pixel, exact."""
        return self.clock.pixel

    def __getitem__(self, name: str) -> MotorTable:
        if name not in self.motors:
            raise UserError(f"{self.path}: there is no motor {name!r}: {', '.join(self.motors)}")
        return self.motors[name]

    def default_motor(self) -> MotorTable:
        """Return the motor that a line is for when nothing else says so.

        Raises UserError if there are several and `line.motor` names none.
        """
        if self.line.motor:
            return self[self.line.motor]
        if len(self.motors) > 1:
            raise UserError(AskedText(
                "{path}: has motors {motors}: choose by {motor}, or set motor in the table [line]",
                path=self.path, motors=", ".join(self.motors),
            ))  # fmt: skip
        return next(iter(self.motors.values()))

    def board_of(self, motor: MotorTable) -> BoardTable:
        """Return a motor's board."""
        return self.boards[motor.board] if motor.board else next(iter(self.boards.values()))

    def board_name(self, motor: MotorTable) -> str:
        """Return the name of a motor's board."""
        return motor.board or next(iter(self.boards))

    def profile(self, motor: MotorTable, use: str) -> Path | None:
        """Return the file of a profile (`line`, `move` or `home`), relative to the machine's."""
        name = getattr(motor.profiles, use)
        return self.path.parent / name if name else None


Problem = tuple[tuple[str, ...], str]


def contradictions(machine: MachineTables) -> Iterator[Problem]:
    """Yield the keys and the reason of whatever does not fit the rest of the file."""
    if machine.line.motor and machine.line.motor not in machine.motors:
        yield ("line", "motor"), f"there is no motor of this name: {', '.join(machine.motors)}"
    yield from _places_of_boards(machine)
    yield from _clock_makers(machine)
    for name, motor in machine.motors.items():
        if motor.name != name:
            yield ("motors", name, "name"), f"its name is that of the table: {name}"
        wrong_board = [*_board_problems(machine, motor)]
        yield from wrong_board or _axis_problems(machine, motor)
        yield from _length_problems(name, motor)
        yield from _field_problems(name, motor)
    yield from _record_problems(machine)


def _places_of_boards(machine: MachineTables) -> Iterator[Problem]:
    """Yield every board whose address on its port another one has."""
    seen: dict[tuple[str, int], str] = {}
    for name, board in machine.boards.items():
        place = (board.port or "", board.unit)
        if place in seen:
            where = "on this port" if board.port else "too, and neither has a port of its own"
            yield ("boards", name, "unit"), f"board {seen[place]} has this address {where}"
        seen.setdefault(place, name)


def _clock_makers(machine: MachineTables) -> Iterator[Problem]:
    """Yield every board that makes another clock than the machine's, or a second one."""
    makers = {name: board for name, board in machine.boards.items() if board.clock_out_hz}
    for name, board in makers.items():
        where = ("boards", name, boards.CLOCK_OUT_SETTING)
        made, wanted = boards.clock_out_of(board.kind, board.clock_out_hz or 0), machine.clock_hz
        if abs(made - wanted) > boards.CLOCK_OUT_SHARE * wanted:
            yield where, f"the pixel clock of the table [clock] has {hz_words(wanted)} Hz"
        elif name != next(iter(makers)):
            yield where, f"board {next(iter(makers))} makes the clock already"


def _board_problems(machine: MachineTables, motor: MotorTable) -> Iterator[Problem]:
    if motor.board is None and len(machine.boards) > 1:
        yield (
            ("motors", motor.name),
            f"needs a key board, one of {', '.join(machine.boards)}",
        )
    elif motor.board is not None and motor.board not in machine.boards:
        known = ", ".join(machine.boards)
        yield ("motors", motor.name, "board"), f"there is no board of this name: {known}"


def _axis_problems(machine: MachineTables, motor: MotorTable) -> Iterator[Problem]:
    """Yield an axis that the board does not have, or that another motor has."""
    board = machine.board_of(motor)
    where = ("motors", motor.name, "axis")
    if motor.axis >= boards.load(board.kind).axes:
        yield where, boards.axes_text(board.kind)
    for other in machine.motors.values():
        if other is motor:
            return
        if (machine.board_name(other), other.axis) == (machine.board_name(motor), motor.axis):
            yield where, f"motor {other.name} has this axis of this board"


def _length_problems(name: str, motor: MotorTable) -> Iterator[Problem]:
    """Yield every length that needs another steps_per_unit, or comes out as a part of a step."""
    try:
        _ = motor.backlash_steps
    except UserError as error:
        yield ("motors", name, "backlash"), str(error)
    for key in LimitsTable.model_fields:
        try:
            motor.limit(key)
        except UserError as error:
            yield ("motors", name, "limits", key), str(error)


def _record_problems(machine: MachineTables) -> Iterator[Problem]:
    """Yield every name of a record that none can have, and every one that another motor has."""
    given = {name: motor.epics.name or name for name, motor in machine.motors.items()}
    if [*given] == [*given.values()]:
        return
    from pixstep.motor_record.field import WANTED, is_record_name  # which not every file needs

    owners: dict[str, str] = {}
    for name, record in given.items():
        where = ("motors", name, "epics", "name")
        if not is_record_name((machine.epics.prefix or "") + record):
            yield where, f"no record can have the name {record!r}: {WANTED}"
        if record in owners:
            yield where, f"motor {owners[record]} has the record {record} already"
        owners.setdefault(record, name)


_MAX_DIGITS = 15  # of a number in a text of EPICS
_BUTTONS = ("HOMF", "HOMR", "JOGF", "JOGR", "PROC", "RLV", "STOP", "SYNC", "TWF", "TWR")


def _field_problems(name: str, motor: MotorTable) -> Iterator[Problem]:
    """Yield every field that no motor record has or takes, and every value that it refuses."""
    if not motor.epics.fields:
        return
    from pixstep import motor_record  # which files without records do not need

    for field, value in motor.epics.fields.items():
        known = motor_record.FIELDS.get(field)
        where = ("motors", name, "epics", "fields", field)
        if known is None:
            yield where, "a motor record has no such field"
        elif not known.writable:
            yield where, "only the record itself writes this field"
        elif field in _BUTTONS:
            yield where, "a button, for clients: it would act each time that the record begins"
        else:
            try:
                known.taken(value)
            except motor_record.PutRefusedError as error:
                yield where, error.reason
    yield from _senseless_fields(name, motor.epics.fields)


def _senseless_fields(name: str, fields: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield values that a record takes from a client, and that no motor can have from the start."""
    where = ("motors", name, "epics", "fields")
    numbers = {field: value for field, value in fields.items() if isinstance(value, int | float)}
    if numbers.get("MRES") == 0:
        yield (*where, "MRES"), "a step has a size: another number than 0"
    if not 0 <= numbers.get("PREC", 0) <= _MAX_DIGITS:
        yield (*where, "PREC"), f"0 to {_MAX_DIGITS} digits after the point"
    for low, high in (("LLM", "HLM"), ("DLLM", "DHLM")):
        if low in numbers and high in numbers and numbers[low] > numbers[high]:
            yield (*where, low), f"above {high} = {numbers[high]}: no position would be allowed"
