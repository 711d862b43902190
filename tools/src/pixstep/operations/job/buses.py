# SPDX-License-Identifier: MIT
"""The boards of a job, at the ports of the machine file; a job beside them and beside the file."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from pixstep.board.errors import BoardError
from pixstep.board.port import BAUD, Port
from pixstep.errors import UserError
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.facts import NO_MACHINE
from pixstep.operations.request import Request
from pixstep.server import remote

if TYPE_CHECKING:
    from pixstep.board.link import Link
    from pixstep.jobs.comparison import ComparisonRow
    from pixstep.jobs.job import Job
    from pixstep.jobs.machine_copy import MachineCopy
    from pixstep.machine.files import MachineFile
    from pixstep.operations.facts import Facts

BusOf = Callable[[str], "Link"]


class Compares(Request):
    """A request that compares a job with the machine file in force."""

    @classmethod
    def prepare(cls, facts: Facts, say: Callable[[Iterable[str]], None]) -> None:
        """Read the machine file here: what it has that nobody knows is a difference, no mistake."""
        facts.on_mistake = lambda error: None


def today(facts: Facts) -> MachineCopy:
    """Return the machine file in force. Raises UserError if there is none, or for a wrong value."""
    from pixstep.jobs.machine_copy import MachineCopy

    path = facts.path
    if path is None:
        raise AskedError(NO_MACHINE)
    try:
        return MachineCopy.of(path.read_bytes(), path)
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


@contextlib.contextmanager
def opened(
    desk: Desk, machine: MachineFile, port: str | None, timeout: float | None
) -> Iterator[BusOf]:
    """Yield what opens the bus of a board by its name, each bus once; a bus of the caller's is it.

    `port` is instead of those of the machine file. Raises UserError if nothing says the port.
    """
    found: dict[str, Link] = {}

    def bus_of(name: str) -> Link:
        if desk.link is not None:
            return desk.link
        table = machine.boards[name]
        place = port or table.port
        if place is None:
            raise AskedError(
                "{path}: board {name} has no port: {port} PORT, or port in [boards.{name}]",
                path=machine.path, name=name,
            )  # fmt: skip
        if place not in found:
            asked = Port(place, table.baud or BAUD, table.parity, timeout)
            found[place] = remote.open_bus(asked, lambda text: desk.say((text,)))
            stack.callback(found[place].close)
        return found[place]

    with contextlib.ExitStack() as stack:
        yield bus_of


def compared(job: Job, machine: MachineFile, bus_of: BusOf) -> list[ComparisonRow]:
    """Return the rows of all boards of a job."""
    from pixstep.jobs import on_boards

    rows: list[ComparisonRow] = []
    for name in boards_of(job, machine):
        try:
            board = bus_of(name).board(machine.boards[name].unit)
            rows += on_boards.with_board(job, machine, name, board, board.who())
        except BoardError as error:
            rows.append(on_boards.absent(name, str(error)))
    return rows


def boards_of(job: Job, machine: MachineFile) -> Iterator[str]:
    """Yield the boards of a job's motors that the machine has today, each once."""
    names = (machine.board_name(machine[name]) for name in job.motors if name in machine.motors)
    yield from dict.fromkeys(names)
