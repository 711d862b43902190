# SPDX-License-Identifier: MIT
"""What a machine file says of one request: its motors, boards and clock.

A file is read only when something of it is asked for.

Motors are meant by their names, by their axes, or as the default one. An axis is the motor that the
file has there, and nothing else of the file then counts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.errors import UserError
from pixstep.machine import FILE_NAME, VARIABLE
from pixstep.operations.asked import AskedError

if TYPE_CHECKING:
    from pixstep.lines.units import Scale
    from pixstep.machine.files import MachineFile
    from pixstep.machine.model import BoardTable, MachineTables, MotorTable
    from pixstep.operations.asked import Field


TABLE_AXES = 2
NO_MACHINE = (
    f"no machine file: {{machine}} FILE, {VARIABLE}, or {FILE_NAME} in this folder "
    f"(`pixstep machine new` begins one)"
)  # a template of `AskedError`


@dataclass
class Named:
    """What a caller says of motors.

    `own` is a --motor that means something else too: it names a motor only if the file has it.
    `lines` is how many the command moves, 0 where it does the same with any number of axes.
    """

    machine: str | None = None  # the file
    own: str | None = None
    motors: tuple[str, ...] = ()
    axes: tuple[int, ...] = ()
    units: tuple[int, ...] = ()
    lines: int = 1
    table: bool = False  # its lines are the axes of a table
    by_axis: bool = True  # its lines may be named by their axes

    @property
    def any(self) -> bool:
        """True if motors are named, by their names or by their axes."""
        return bool(self.motors or self.axes)

    @property
    def wanted(self) -> tuple[int, ...]:
        """The axes that are meant: one axis for several lines is the first of a row."""
        if len(self.axes) == 1 and self.lines > 1:
            return tuple(range(self.axes[0], self.axes[0] + self.lines))
        return self.axes

    @property
    def option(self) -> str:
        """The option that names the motors, in words."""
        return f"--motor {self.motors[0]}" if self.motors else f"--axis {self.axes[0]}"


def choose(machine: MachineTables, named: Named) -> list[MotorTable]:
    """Return the motors that are meant, in the order of their lines.

    Raises UserError if an axis has no motor, if several boards have one there and nothing says
    which board, and if names and axes contradict each other.
    """
    if named.motors:
        motors = [machine[name] for name in named.motors]
        _refuse_contradiction(machine, named, motors)
        return motors
    if named.axes:
        return [motor for axis in named.wanted for motor in _on_axis(machine, named, axis)]
    if named.lines > 1 and not named.table:
        by_what = "{motor} or {axis}" if named.by_axis else "{motor}"
        raise AskedError(
            f"{{lines}} lines for 1 motor of {{path}}: give {by_what} once for each line, in "
            "their order ({machine} none does without the file)",
            lines=named.lines, path=machine.path,
        )  # fmt: skip
    motor = machine.default_motor()
    there = boards_at(machine, named.units)
    if there and machine.board_name(motor) not in there:
        raise AskedError(
            "{unit} {units}: in {path} that is board {there}, motor {name}, which lines are for, "
            "is on board {board}: choose by {motor} or {axis}",
            units=_text(named.units), path=machine.path, there=" and ".join(there),
            name=motor.name, board=machine.board_name(motor),
        )  # fmt: skip
    return [motor]


def _refuse_contradiction(
    machine: MachineTables, named: Named, motors: Sequence[MotorTable]
) -> None:
    """Raise UserError if --axis or --unit mean other motors than --motor."""
    for motor in motors:
        board = machine.board_of(motor)
        others = boards_at(machine, named.units)
        if others and machine.board_name(motor) not in others:
            raise AskedError(
                "{unit} {units}: in {path} motor {name} is on board {board}, unit {its}: leave "
                "{unit} or {motor} out",
                units=_text(named.units), path=machine.path, name=motor.name,
                board=machine.board_name(motor), its=board.unit,
            )  # fmt: skip
    if named.lines > 1 and len(motors) != named.lines:
        raise AskedError(
            f"{named.lines} lines for {len(motors)} motor{'s' if len(motors) > 1 else ''}: give "
            f"{{motor}} once for each line, in their order"
        )
    mine, asked = [motor.axis for motor in motors], list(named.wanted)
    if asked and (mine if named.lines else sorted(mine)) != (
        asked if named.lines else sorted(set(asked))
    ):
        said = ", ".join(f"motor {motor.name} is axis {motor.axis}" for motor in motors)
        axes = " ".join(f"{{axis}} {axis}" for axis in named.axes)
        raise AskedError(
            axes + ": in {path} {said}: leave {axis} or {motor} out", path=machine.path, said=said
        )


def _on_axis(machine: MachineTables, named: Named, axis: int) -> list[MotorTable]:
    """Return the motor of an axis; of commands for several boards that of each one given."""
    there = boards_at(machine, named.units) or machine.boards
    found = [
        motor
        for motor in machine.motors.values()
        if motor.axis == axis and machine.board_name(motor) in there
    ]
    if not found:
        have = ", ".join(
            f"{motor.name} is axis {motor.axis}{_of_board(machine, motor)}"
            for motor in machine.motors.values()
        )
        raise AskedError(
            "axis {number}: {path} has no motor on this axis: {have} ({machine} none does without "
            "the file)",
            number=axis, path=machine.path, have=have,
        )  # fmt: skip
    if len(found) > 1 and (named.lines or not named.units):
        have = ", ".join(f"{motor.name}{_of_board(machine, motor)}" for motor in found)
        raise AskedError(
            "axis {number}: {path} has motors {have}: choose by {motor}",
            number=axis, path=machine.path, have=have,
        )  # fmt: skip
    return found


def _of_board(machine: MachineTables, motor: MotorTable) -> str:
    return f" of board {machine.board_name(motor)}" if len(machine.boards) > 1 else ""


def boards_at(machine: MachineTables, units: Sequence[int]) -> dict[str, BoardTable]:
    """Return the file's boards at some addresses, by name."""
    return {name: board for name, board in machine.boards.items() if board.unit in units}


def _text(units: Sequence[int]) -> str:
    return ",".join(map(str, units))


class Facts:
    """The machine of a request, and what is known of the request so far.

    `find` finds the file, None for none; `values` are the request's values as they are found.
    """

    def __init__(
        self, fields: Mapping[str, Field], named: Named, find: Callable[[str | None], Path | None]
    ):
        self.fields = fields
        self.named = named
        self.values: dict[str, Any] = {}
        self.any_board = False  # what is asked for goes to a board whatever the file says of it
        self.on_mistake: Callable[[UserError], None] | None = None  # of a file, where it may be
        self._find = find

    @property
    def machine(self) -> MachineFile:
        """The machine in force, where a fact of it is wanted: then there is one."""
        if self.found is None:
            raise UserError("no machine file")
        return self.found

    @property
    def path(self) -> Path | None:
        """The file in force, which is not read for this; None if there is none."""
        return self._find(self.named.machine)

    @cached_property
    def found(self) -> MachineFile | None:
        """The machine in force, None if there is none."""
        path = self.path
        if path is None and self.named.motors:
            raise AskedError("{motor} {name}: " + NO_MACHINE, name=self.named.motors[0])
        machine = None if path is None else self._load(path)
        if machine is not None:
            self._choose(machine)
        return machine

    def _load(self, path: Path) -> MachineFile | None:
        from pixstep.machine import files  # pydantic takes a while to load

        try:
            return files.MachineFile.load(path)
        except UserError as error:
            if self.on_mistake is None or self.named.motors:
                raise
            self.on_mistake(error)
            return None

    def _choose(self, machine: MachineFile) -> None:
        """Take the motors that are named; one that the file does not have is refused."""
        if self.named.own in machine.motors:
            self.named.motors = (self.named.own,)
        if self.any_board:
            self.named.units = ()
        if self.on_mistake and not self.named.motors:
            self.named.axes = ()  # any axis can be stopped, whatever the file has
        if self.named.any:
            self.motors = choose(machine, self.named)

    @property
    def used(self) -> MachineFile | None:
        """The machine, if something of it was asked for; it is not read only for this."""
        found: MachineFile | None = vars(self).get("found")
        return found

    @cached_property
    def motors(self) -> list[MotorTable]:
        """The motors that are named, else the one that lines are for."""
        return choose(self.machine, self.named)

    @property
    def motor(self) -> MotorTable:
        """The only motor. Raises UserError if several are chosen."""
        if len(self.motors) > 1:
            names = " and ".join(motor.name for motor in self.motors)
            raise UserError(f"motors {names}: this command takes one motor")
        return self.motors[0]

    @property
    def motors_in_force(self) -> list[MotorTable]:
        """The motors; none without a file that was used, or if nothing chooses one of several."""
        try:
            return [] if self.used is None else self.motors
        except UserError:
            return []

    @property
    def board(self) -> BoardTable:
        """The board of all motors that are chosen."""
        boards = self.boards
        if len(boards) > 1:
            raise UserError(f"motors on boards {' and '.join(sorted(boards))}: a run has one board")
        return next(iter(boards.values()))

    @property
    def boards(self) -> dict[str, BoardTable]:
        """The boards of the motors that are chosen, by name."""
        machine = self.machine
        if not self.named.any:
            there = boards_at(machine, self.named.units)
            if there or len(machine.boards) == 1:
                return there or machine.boards
        return {machine.board_name(motor): machine.board_of(motor) for motor in self.motors}

    def scale(self) -> Scale | None:
        """Return steps per unit of length; None without a machine, or if motors differ."""
        if self.found is None:
            return None
        scales = {motor.steps_per_unit for motor in self.motors}
        return scales.pop() if len(scales) == 1 else None

    def scale_if_known(self) -> Scale | None:
        """Return the same for what is only shown; None if nothing says it."""
        try:
            return self.scale()
        except UserError:
            return None

    def scales(self) -> dict[int, Scale]:
        """Return the scales of the motors on the board that is meant, by axis."""
        try:
            if self.found is None:
                return {}
            board = self.board
        except UserError:
            return {}
        return {
            motor.axis: motor.steps_per_unit
            for motor in self.machine.motors.values()
            if motor.steps_per_unit and self.machine.board_of(motor) is board
        }

    def several(self, name: str) -> tuple[Any, ...]:
        """Return the values that a field has so far, none or one or more."""
        value = self.values.get(name)
        if isinstance(value, tuple):
            return value
        return () if value is None else (value,)

    def many(self, name: str) -> bool:
        """True if a field takes several values."""
        return self.fields[name].many

    def other_kind(self) -> bool:
        """True if the caller says another kind of motor than the file."""
        words = ("plain",) if self.values.get("plain") else self.several("decode")
        return bool(set(words) - {motor.decode for motor in self.motors})


def named_by(
    fields: Mapping[str, Field], given: Mapping[str, Any], machine: str | None,
    motors: tuple[str, ...], *, own: bool,
) -> Named:  # fmt: skip
    """Return what a caller says of motors: `given` are the values of the request.

    A field `axis` is of lines that go to axes in a row, a field `axes` of the same with each axis.
    """
    table = "axis" in fields and "play" in fields and fields["play"].many
    csv = given.get("csv")
    lines = TABLE_AXES if table else 0
    if not table and isinstance(csv, tuple):
        lines = len(csv)
    elif not table and "axis" in fields:
        lines = 1
    named = Named(machine=machine, lines=lines, table=table, by_axis="axis" in fields)
    if own:
        named.own = given.get("motor")
    else:
        named.motors = motors
    for name in ("axis", "axes"):
        if name in fields and "--axis" in fields[name].names:
            named.axes = _numbers(given.get(name))
            break
    for name in ("unit", "units"):
        named.units = named.units or _numbers(given.get(name))
    return named


def _numbers(value: object) -> tuple[int, ...]:
    several = value if isinstance(value, tuple) else (value,)
    return tuple(one for one in several if isinstance(one, int))
