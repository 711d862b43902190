# SPDX-License-Identifier: MIT
"""Which motors of a machine file a command line means: by --motor, by --axis, or the default one.

`read` takes what the command line says, before any default of it is asked for; `choose` finds the
motors. An axis is the motor that the file has there, and nothing else of the file then counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from pixstep.errors import UserError

if TYPE_CHECKING:
    from pixstep.machine.model import MachineBoard, Motor, Tables

_TABLE_AXES = 2
_IN_A_ROW = "axis"  # the parameter of commands whose lines go to axes in a row, or to those given
_AS_A_SET = "axes"  # that of commands that do the same with each axis


@dataclass
class Named:
    """What a command line says of motors.

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


def read(ctx: click.Context, args: Sequence[str]) -> Named | None:
    """Return what a command line says of axes, boards and lines; what is wrong is left out.

    None if it only asks for help. The values are read here before click asks for defaults, because
    those depend on them.
    """
    params = {param.name or "": param for param in ctx.command.params}
    try:
        words, _, _ = ctx.command.make_parser(ctx).parse_args(list(args))
    except click.UsageError:  # click will say so itself
        words = {}
    asks = ctx.command.get_help_option(ctx)
    if asks and words.get(asks.name or ""):
        return None
    table = _IN_A_ROW in params and bool(getattr(params.get("play"), "multiple", False))
    found = Named(lines=_TABLE_AXES if table else _lines(params, words), table=table)
    found.machine = _text_of(words, "machine") or params["machine"].resolve_envvar_value(ctx)
    if params["motor"].expose_value:
        found.own = _text_of(words, "motor")
    else:
        found.motors = _texts(words.get("motor"))
    for name in (_IN_A_ROW, _AS_A_SET):
        if name in params and getattr(params[name], "opts", []) == ["--axis"]:
            found.axes = tuple(_values(ctx, params[name], words))
    for name in ("unit", "units"):
        if name in params:
            found.units = tuple(_values(ctx, params[name], words))
    return found


def _lines(params: dict[str, click.Parameter], words: dict[str, object]) -> int:
    if _IN_A_ROW not in params:
        return 0
    files = words.get("csv")
    return len(files) if isinstance(files, (list, tuple)) else 1


def _texts(value: object) -> tuple[str, ...]:
    several = value if isinstance(value, (list, tuple)) else (value,)
    return tuple(one for one in several if isinstance(one, str))


def _text_of(words: dict[str, object], name: str) -> str | None:
    return next(iter(_texts(words.get(name))), None)


def _values(ctx: click.Context, param: click.Parameter, words: dict[str, object]) -> Iterator[int]:
    """Yield the numbers that a parameter has on the command line."""
    if not param.name or not isinstance(words.get(param.name), (str, list, tuple)):
        return
    try:
        value = param.type_cast_value(ctx, words[param.name])
    except click.BadParameter:
        return
    yield from (one for one in (value if isinstance(value, tuple) else (value,)) if one is not None)


def choose(machine: Tables, named: Named) -> list[Motor]:
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


def _refuse_contradiction(machine: Tables, named: Named, motors: Sequence[Motor]) -> None:
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


def _on_axis(machine: Tables, named: Named, axis: int) -> list[Motor]:
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


def _of_board(machine: Tables, motor: Motor) -> str:
    return f" of board {machine.board_name(motor)}" if len(machine.boards) > 1 else ""


def boards_at(machine: Tables, units: Sequence[int]) -> dict[str, MachineBoard]:
    """Return the file's boards at some addresses, by name."""
    return {name: board for name, board in machine.boards.items() if board.unit in units}


def _text(units: Sequence[int]) -> str:
    return ",".join(map(str, units))
