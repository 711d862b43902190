# SPDX-License-Identifier: MIT
"""Which boards the page of `pixstep watch --web` shows: of a run, a port or a machine file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from pixstep.board.port import BAUD, Port
from pixstep.operations.live.eye import AxisName, Spot

if TYPE_CHECKING:
    from pixstep.machine.model import MachineTables


def of_machine(
    machine: MachineTables, port: str, boards: Iterable[str], served: bool
) -> list[Spot]:
    """Return some boards of a machine, those of a port together; `port` is instead of the file's.

    A board without a port is left out.
    """
    found: dict[str, tuple[Port, list[int]]] = {}
    for name in boards:
        board = machine.boards[name]
        place = port or board.port
        if place:
            made = Port(place, board.baud or BAUD, board.parity)
            found.setdefault(place, (made, []))[1].append(board.unit)
    return [
        Spot(made, tuple(dict.fromkeys(units)), names_on(machine, place), served)
        for place, (made, units) in found.items()
    ]


def names_on(machine: MachineTables | None, port: str) -> dict[tuple[int, int], AxisName]:
    """Return what a machine file calls axes of the boards on a port."""
    found = {}
    for motor in machine.motors.values() if machine else ():
        assert machine is not None
        board = machine.boards[machine.board_name(motor)]
        if board.port in (None, port):
            scale = motor.steps_per_unit
            about = (scale.length, float(scale.steps_per_unit)) if scale else ()
            found[board.unit, motor.axis] = AxisName(motor.name, *about)
    return found
