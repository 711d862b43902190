# SPDX-License-Identifier: MIT
"""One stop, then a look at what rests."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypedDict

from pixstep.board import modbus, run
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import PortBusyError
from pixstep.operations import bus
from pixstep.operations import machine_defaults as machine
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import ALL, UNITS, Known, OnPort, Units, some_axes
from pixstep.operations.desk import Desk, Rows
from pixstep.operations.facts import Facts
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result

_NEAR = range(1, 9)  # addresses that are looked at without being asked to
_NEAR_S = 0.15  # that each of them has, so that a busy computer misses none


class StoppedAxis(TypedDict):
    """Where an axis rests."""

    axis: int
    at_rest: bool
    position_steps: int | None


class StoppedBoard(TypedDict):
    """The axes of a board that were stopped; only their numbers if nobody has looked."""

    unit: int
    axes: list[StoppedAxis | int]


class StoppedBoards(TypedDict):
    """The boards that were looked at, or that acknowledged."""

    boards: list[StoppedBoard]


@operation("board stop")
class Stop(OnPort):
    """Stop what moves, at once, and forget what is queued.

    There is no ramp; the permit output goes off. Without --unit a broadcast, to which nobody
    replies, goes out before anything else, also beside another program that has the port open.
    Then the boards at addresses 1 to 8 and those of the machine file are looked at, with --unit all
    those at every address (20 s), and one that has not heard is stopped by its address. Positions
    stay known, but a load that is fast may run on. Exit status 0 if everything rests as far as was
    looked, else 1.
    """

    result = StoppedBoards

    units: Units | None = option(
        UNITS, "Addresses.", "--unit", default_text="broadcast to all",
        machine=machine.units_if_named,
    )  # fmt: skip
    axes: tuple[int, ...] = some_axes()
    look: bool = flag("Ask the boards afterwards whether they rest.", off="--no-look", default=True)

    @classmethod
    def prepare(cls, facts: Facts, say: Callable[[Iterable[str]], None]) -> None:
        """Let no board and no file keep anybody from stopping."""
        facts.any_board = True
        facts.on_mistake = lambda error: say((f"{error}: not used",))

    @property
    def everyone(self) -> bool:
        """True if a broadcast says it."""
        return self.units is None or (self.units == ALL and not self.axes)

    def run(self, desk: Desk) -> Result:
        """Stop, then look."""
        if self.units is None and self.axes:
            raise AskedError("{axes} needs {units}: a broadcast stops all axes of all boards")

        def first(found: Link) -> None:
            if self.everyone:
                found.board(1).stop_all()
                desk.tell(f"{self.port}: stop sent to all boards")

        try:
            with bus.opened(desk, self, first) as found:
                rows = desk.rows()
                self._each(desk, found, rows)
                return rows.result()
        except PortBusyError:
            if not self.everyone:
                raise
            return self._beside()

    def _each(self, desk: Desk, found: Link, rows: Rows) -> None:
        """Stop boards by their addresses, or look at those that were told together."""
        if self.units is not None and not self.everyone:
            bus.each_of(desk, found, self.units, lambda item: self._stop(found, item, rows))
        elif self.look:
            there = self._those_there(desk, found)
            bus.each_of(desk, found, there, lambda item: _look_again(desk, found, item, rows))

    def _beside(self) -> Result:
        """Send the broadcast on a port that another program has open; nobody can be asked then."""
        beside = modbus.Beside()
        Board(beside).stop_all()
        self.bus.send_beside(beside.frames)
        text = f"{self.port}: in use by another program: stop sent to all boards beside it"
        if self.look:
            raise BoardError(f"{text}, nobody has looked whether they rest")
        return Result({"boards": []}, text)

    def _those_there(self, desk: Desk, found: Link) -> tuple[int, ...]:
        """Return the addresses that answer: of all, or of those near at hand and those known."""
        if self.units == ALL:
            return bus.present(desk, found)
        wanted = sorted({*_NEAR, *bus.units_on(desk, self.port)})
        last = _NEAR[-1]
        others = "".join(f", {unit}" for unit in wanted if unit > last)
        return bus.present(
            desk,
            found,
            wanted,
            _NEAR_S,
            f"at addresses 1 to {last}{others}: `pixstep board stop --unit all` looks at every one",
        )

    def _stop(self, found: Link, item: Known, rows: Rows) -> None:
        """Stop axes of a board."""
        axes, unit = item.axes(self.axes), item.board.unit
        run.stop_axes(item.board, axes)
        if self.look:
            _tell(item, run.rests(item.board, axes, found.world), rows)
        else:
            rows.add({"unit": unit, "axes": axes}, f"board {unit}: stop acknowledged")


def _look_again(desk: Desk, found: Link, item: Known, rows: Rows) -> None:
    """Look at a board after a broadcast; stop by its address what still moves."""
    axes = item.axes(())
    rests = run.rests(item.board, axes, found.world)
    moving = [axis for axis, one in rests.items() if not one.at_rest]
    if moving:
        desk.complain(BoardError(f"board {item.board.unit}: it has not heard the broadcast"))
        run.stop_axes(item.board, moving)
        rests = run.rests(item.board, axes, found.world)
    _tell(item, rests, rows)


def _tell(item: Known, rests: dict[int, run.Rest], rows: Rows) -> None:
    """Say where the axes of a board rest; raises BoardError if one does not."""
    unit = item.board.unit
    axes: list[StoppedAxis] = [
        {"axis": axis, "at_rest": one.at_rest, "position_steps": one.position_steps}
        for axis, one in rests.items()
    ]
    where = ", ".join(
        f"axis {row['axis']} at position {row['position_steps']}" for row in axes if row["at_rest"]
    )
    if where:
        rows.add({"unit": unit, "axes": axes}, f"board {unit}: at rest: {where}")
    moving = [
        f"axis {axis} is {one.state} at position {one.position_steps}"
        for axis, one in rests.items()
        if not one.at_rest
    ]
    if moving:
        raise BoardError(f"board {unit}: NOT at rest: {', '.join(moving)}")
