# SPDX-License-Identifier: MIT
"""The drives of a machine's motors: of boards on ports, or of simulated boards."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from pixstep import natives
from pixstep.board.port import BAUD, Port
from pixstep.errors import AskedText, UserError
from pixstep.motor_drive import BusDrives, Pacer
from pixstep.motor_drive.of_machine import motors_of
from pixstep.server import remote

if TYPE_CHECKING:
    from pathlib import Path

    from pixstep.board.link import Link
    from pixstep.machine.files import MachineFile
    from pixstep.machine.model import BoardTable
    from pixstep.motor_record import Drive
    from pixstep.server.journal import Log
    from pixstep.simulation.simulator import SimOptions

_LOAD = "home=2000,hyst=8,play={}"  # a simulated load: its home switch, its play in steps


@contextlib.contextmanager
def opened(
    machine: MachineFile, port: str | None, log: Log, *, simulate: bool
) -> Iterator[Mapping[str, Drive]]:
    """Yield a drive for each motor, by the motors' names; motors that move are stopped at the end.

    `port` is in place of what the machine file says. Raises UserError if a port cannot be opened.
    """
    with contextlib.ExitStack() as stack:
        found: dict[str, Drive] = {}
        if simulate:
            found.update(stack.enter_context(simulated(machine)))
        else:
            for place, boards in _ports(machine, port).items():
                found.update(stack.enter_context(_on_port(machine, place, boards, log)))
        yield found


def _ports(machine: MachineFile, port: str | None) -> dict[Port, dict[str, BoardTable]]:
    """Return the boards that have motors, by the ports that they are on."""
    used = dict.fromkeys(machine.board_name(motor) for motor in machine.motors.values())
    found: dict[Port, dict[str, BoardTable]] = {}
    for name in used:
        board = machine.boards[name]
        place = port or board.port
        if place is None:
            raise UserError(AskedText(
                "{path}: board {name} has no port: {port} PORT, or port in [boards.{name}]",
                path=machine.path, name=name,
            ))  # fmt: skip
        bus = Port(place, board.baud or BAUD, board.parity, None)
        found.setdefault(bus, {})[name] = board
    return found


@contextlib.contextmanager
def _on_port(
    machine: MachineFile, port: Port, boards: Mapping[str, BoardTable], log: Log
) -> Iterator[Mapping[str, Drive]]:
    """Yield the drives of the boards of a port, through its server if one runs."""
    link = remote.open_bus(port, lambda text: log.tell("port", says=text))
    try:
        units = {name: board.unit for name, board in boards.items()}
        with _drives(machine, link, units) as found:
            log.tell("port", open=port.name, boards=" ".join(sorted(boards)))
            yield found
    finally:
        link.close()


@contextlib.contextmanager
def simulated(machine: MachineFile, edges: Path | None = None) -> Iterator[BusDrives]:
    """Yield the drives of simulated boards, whose time passes as the wall clock's.

    `edges` is a file for all edges of the boards.
    """
    from pixstep.simulation.simulated_board import (
        SimLink,  # which those without a simulator do not need
    )
    from pixstep.simulation.simulator import SimulatorError

    units = {name: unit for unit, name in enumerate(machine.boards, 1)}
    options = sim_options(machine)
    with SimLink(replace(options, edges=edges) if edges else options) as link:
        with Pacer(link), _drives(machine, link, units) as found:
            yield found
        with contextlib.suppress(SimulatorError):
            link.simulator.quit()


def sim_options(machine: MachineFile) -> SimOptions:
    """Return what the simulator of a machine is started with."""
    from pixstep.simulation.simulator import SimOptions

    places = {name: place for place, name in enumerate(machine.boards)}
    kinds = [board.kind for board in machine.boards.values()]
    plants = {
        (places[machine.board_name(motor)], motor.axis): _LOAD.format(motor.backlash_steps)
        for motor in machine.motors.values()
    }
    boards = [(kind, natives.image(kind)) for kind in kinds]
    return SimOptions(boards, machine.clock_hz, plants=plants)


def _drives(machine: MachineFile, link: Link, units: Mapping[str, int]) -> BusDrives:
    """Return the drives of the motors of some boards; `units` are their addresses by name."""
    return BusDrives(
        link,
        motors_of(machine, units),
        clock_hz=machine.clock_hz,
        divider=machine.clock.edges,
        kinds={unit: machine.boards[name].kind for name, unit in units.items()},
    )
