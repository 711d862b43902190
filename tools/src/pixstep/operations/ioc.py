# SPDX-License-Identifier: MIT
"""Motors as motor records of EPICS, with their drives: of boards on ports, or simulated ones."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NotRequired, TypedDict

from pixstep import natives, signals
from pixstep.board.port import BAUD, Port
from pixstep.errors import AskedText, UserError
from pixstep.ioc import common, saved, settings
from pixstep.lazy import lazy
from pixstep.machine import FILE_NAME, VARIABLE
from pixstep.motor_drive import BusDrives, Pacer
from pixstep.motor_drive.starting import motors_of
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk, log_of
from pixstep.operations.kinds import PATH, TEXT
from pixstep.operations.request import Request, flag, operation, option
from pixstep.operations.result import Result
from pixstep.server import remote

if TYPE_CHECKING:
    from pathlib import Path

    from pixstep.board.link import Link
    from pixstep.ioc import server
    from pixstep.machine.files import MachineFile
    from pixstep.machine.model import BoardTable
    from pixstep.motor_record import Drive
    from pixstep.server.journal import Log
    from pixstep.simulation.simulator import SimOptions
else:
    server = lazy("pixstep.ioc.server")


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


class ServedRecords(TypedDict):
    """What was served: names of records by motors; with --list the names of all PVs."""

    machine: str
    records: dict[str, str]
    pvs: NotRequired[list[str]]


@operation("ioc")
class Ioc(Request):
    """Serve the motors of a machine file as motor records of EPICS (Channel Access).

    Each motor of the file is a record of its own name, all fields of the motor record are PVs:
    PREFIX + NAME + .FIELD. Boards are reached through their server where `pixstep serve` runs. The
    usual variables say where it listens: EPICS_CAS_INTF_ADDR_LIST, EPICS_CA_SERVER_PORT. It ends by
    Ctrl-C, and stops what moves; docs/EPICS.md has the rest.
    """

    result = ServedRecords
    json_rows = "event, or the names as one document"
    needs_machine: ClassVar[bool] = True

    prefix: str | None = option(
        TEXT, "Prefix of the names of all records and PVs.", shown="P:",
        default_text="epics.prefix of the machine file, or none",
    )  # fmt: skip
    simulate: bool = flag("Simulate the boards: nothing moves but a model.")
    port: str | None = option(
        TEXT, "Serial port of all boards; simulated ones have none.", variable="PIXSTEP_PORT",
        default_text="those of the machine file",
    )  # fmt: skip
    state: Path | None = option(
        PATH, "File that keeps settings and positions over a restart.",
        default_text="beside the machine file, machine.ioc.json; none with --simulate",
    )  # fmt: skip
    list: bool = flag("List the names of all PVs, and end.")

    def run(self, desk: Desk) -> Result:
        """Serve until a signal comes."""
        machine = desk.facts.found
        if machine is None:
            raise AskedError(
                "no machine file: {machine} FILE, {variable}, or {name} in this folder (`pixstep "
                "machine new` begins one)",
                variable=VARIABLE, name=FILE_NAME,
            )  # fmt: skip
        prefix = self.prefix if self.prefix is not None else machine.epics.prefix or ""
        records = settings.record_names(machine, prefix)
        data: dict[str, Any] = {"machine": str(machine.path), "records": records}
        if self.list:
            pvs = common.all_names(prefix, records.values())
            return Result(data | {"pvs": pvs}, "\n".join(pvs))
        self._serve(desk, machine, prefix, records)
        return Result(data, f"{machine.path}: ended", told=True)

    def _serve(
        self, desk: Desk, machine: MachineFile, prefix: str, records: dict[str, str]
    ) -> None:
        kept = saved.Saved(self._state_of(machine))
        make = server.RecordServer  # says before anything is opened that a package is missing
        log = log_of(desk)
        try:
            with opened(machine, self.port, log, simulate=self.simulate) as drives:
                motors = [
                    server.MotorSpec(
                        record, settings.fields_of(machine, machine[name]), drives[name]
                    )
                    for name, record in records.items()
                ]
                found = make(motors, prefix, kept, log)
                try:
                    with signals.until_ctrl_c():
                        found.start()
                        found.wait()
                finally:
                    with signals.ignored():
                        found.close()
        finally:
            log.close()

    def _state_of(self, machine: MachineFile) -> Path | None:
        """Return the file of what is kept, None if nothing is."""
        if self.state or self.simulate:
            return self.state
        return machine.path.with_suffix(".ioc.json")
