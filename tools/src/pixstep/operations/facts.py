# SPDX-License-Identifier: MIT
"""What a machine file says of one request: its motors, boards and clock.

A file is read only when something of it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.errors import UserError
from pixstep.machine import FILE_NAME, VARIABLE
from pixstep.operations import motor_choice
from pixstep.operations.motor_choice import TABLE_AXES, Named

if TYPE_CHECKING:
    from pixstep.lines.units import Scale
    from pixstep.machine.files import MachineFile
    from pixstep.machine.model import BoardTable, MotorTable
    from pixstep.operations.field import Field


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
            raise UserError(
                f"--motor {self.named.motors[0]}: no machine file: --machine FILE, "
                f"{VARIABLE}, or {FILE_NAME} in this folder "
                f"(`pixstep machine new` begins one)"
            )
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
            self.motors = motor_choice.choose(machine, self.named)

    @property
    def used(self) -> MachineFile | None:
        """The machine, if something of it was asked for; it is not read only for this."""
        found: MachineFile | None = vars(self).get("found")
        return found

    @cached_property
    def motors(self) -> list[MotorTable]:
        """The motors that are named, else the one that lines are for."""
        return motor_choice.choose(self.machine, self.named)

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
            there = motor_choice.boards_at(machine, self.named.units)
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
    lines = TABLE_AXES if table else 0
    if "axis" in fields and not table:
        csv = given.get("csv")
        lines = len(csv) if isinstance(csv, tuple) else 1
    named = Named(machine=machine, lines=lines, table=table)
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
