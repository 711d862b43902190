# SPDX-License-Identifier: MIT
"""Which motors of a machine file are meant: by their names, by their axes, or the default one.

An axis is the motor that the file has there, and nothing else of the file then counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pixstep.errors import UserError

if TYPE_CHECKING:
    from pixstep.machine.model import BoardTable, MachineTables, MotorTable

TABLE_AXES = 2


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
        raise UserError(
            f"{named.lines} lines for 1 motor of {machine.path}: give --motor or --axis once for "
            f"each line, in their order (--machine none does without the file)"
        )
    motor = machine.default_motor()
    there = boards_at(machine, named.units)
    if there and machine.board_name(motor) not in there:
        raise UserError(
            f"--unit {_text(named.units)}: in {machine.path} that is board {' and '.join(there)}, "
            f"motor {motor.name}, which lines are for, is on board {machine.board_name(motor)}: "
            f"choose by --motor or --axis"
        )
    return [motor]


def _refuse_contradiction(
    machine: MachineTables, named: Named, motors: Sequence[MotorTable]
) -> None:
    """Raise UserError if --axis or --unit mean other motors than --motor."""
    for motor in motors:
        board = machine.board_of(motor)
        others = boards_at(machine, named.units)
        if others and machine.board_name(motor) not in others:
            raise UserError(
                f"--unit {_text(named.units)}: in {machine.path} motor {motor.name} "
                f"is on board {machine.board_name(motor)}, unit {board.unit}: leave --unit or "
                f"--motor out"
            )
    if named.lines > 1 and len(motors) != named.lines:
        raise UserError(
            f"{named.lines} lines for {len(motors)} motor{'s' if len(motors) > 1 else ''}: give "
            f"--motor once for each line, in their order"
        )
    mine, asked = [motor.axis for motor in motors], list(named.wanted)
    if asked and (mine if named.lines else sorted(mine)) != (
        asked if named.lines else sorted(set(asked))
    ):
        said = ", ".join(f"motor {motor.name} is axis {motor.axis}" for motor in motors)
        axes = " ".join(f"--axis {axis}" for axis in named.axes)
        raise UserError(f"{axes}: in {machine.path} {said}: leave --axis or --motor out")


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
        raise UserError(
            f"axis {axis}: {machine.path} has no motor on this axis: {have} (--machine none does "
            f"without the file)"
        )
    if len(found) > 1 and (named.lines or not named.units):
        have = ", ".join(f"{motor.name}{_of_board(machine, motor)}" for motor in found)
        raise UserError(f"axis {axis}: {machine.path} has motors {have}: choose by --motor")
    return found


def _of_board(machine: MachineTables, motor: MotorTable) -> str:
    return f" of board {machine.board_name(motor)}" if len(machine.boards) > 1 else ""


def boards_at(machine: MachineTables, units: Sequence[int]) -> dict[str, BoardTable]:
    """Return the file's boards at some addresses, by name."""
    return {name: board for name, board in machine.boards.items() if board.unit in units}


def _text(units: Sequence[int]) -> str:
    return ",".join(map(str, units))
