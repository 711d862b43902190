# SPDX-License-Identifier: MIT
"""Give boards a command: arm, disarm, clear, enable, disable, permit, stop."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import ClassVar, TypedDict

from pixstep.board import modbus, run
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import PortBusyError
from pixstep.errors import UserError
from pixstep.operations import bus
from pixstep.operations import machine_defaults as machine
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import ALL, UNITS, Known, OnPort, ToBoards, Units, some_axes
from pixstep.operations.desk import Desk, ResultRows
from pixstep.operations.facts import Facts
from pixstep.operations.kinds import Choice, Whole
from pixstep.operations.request import argument, flag, operation, option, shared_fields
from pixstep.operations.result import Result

TOKEN = Whole(1, 0xFFFF)


class CommandedBoard(TypedDict):
    """Which axes of a board were given the command."""

    unit: int
    axes: list[int]


class CommandedBoards(TypedDict):
    """The boards that were given the command."""

    boards: list[CommandedBoard]


@shared_fields
class _Simple(ToBoards):
    """A command to some axes of some boards."""

    result = CommandedBoards
    code: ClassVar[str]
    done: ClassVar[str]

    axes: tuple[int, ...] = some_axes()

    def run(self, desk: Desk) -> Result:
        """Give the command to each board."""
        rows = desk.rows()

        def give(item: Known) -> None:
            chosen, unit = item.axes(self.axes), item.board.unit
            run.command(item.board, self.code, chosen)
            rows.add(
                {"unit": unit, "axes": chosen}, f"board {unit}: {bus.axes_text(chosen)} {self.done}"
            )

        bus.each_board(desk, self, give)
        return rows.result()


@operation("board disarm")
class Disarm(_Simple):
    """Disarm axes and discard their queues."""

    code, done = "disarm", "disarmed"


@operation("board enable")
class Enable(_Simple):
    """Switch drivers on: their motors hold."""

    code, done = "enable", "enabled"


@operation("board disable")
class Disable(_Simple):
    """Switch drivers of axes at rest off."""

    code, done = "disable", "disabled"


@operation("board arm")
class Arm(ToBoards):
    """Arm loaded axes by hand, with a token if wanted.

    They start on the next pixel clock edge, or on go if there is a token. `pixstep board start`
    does this for several boards at once. Without --axis all loaded ones. A board that gets no
    request for `bus_timeout_ms` (3 s by default) while an axis is armed or moves stops.
    """

    result = CommandedBoards

    axes: tuple[int, ...] = some_axes()
    token: int | None = option(TOKEN, "Wait after arming for `go` with this token.")

    def run(self, desk: Desk) -> Result:
        """Arm the axes of each board."""
        rows = desk.rows()
        with bus.boards(desk, self) as (_found, known):
            for item in known:
                chosen, unit = self._chosen(item), item.board.unit
                with bus.stopping([run.LinesOfBoard(item.board, chosen)]):
                    run.arm(item.board, chosen, self.token or 0)
                    bus.note_play(desk, item.board, chosen)
                rows.add(
                    {"unit": unit, "axes": chosen}, f"board {unit}: {bus.axes_text(chosen)} armed"
                )
                bus.note_unattended(desk, item.board)
        return rows.result()

    def _chosen(self, item: Known) -> list[int]:
        """Return the axes to arm: those named, else all that are loaded."""
        if self.axes:
            return item.axes(self.axes)
        chosen = run.loaded(item.board, item.who.axis_count)
        if not chosen:
            raise UserError(f"board {item.board.unit}: no axis has a line loaded")
        return chosen


class ClearedBoard(TypedDict):
    """The fault that was cleared; None if none was latched."""

    unit: int
    cleared: str | None


class ClearedBoards(TypedDict):
    """The boards that were cleared."""

    boards: list[ClearedBoard]


@operation("board clear")
class Clear(ToBoards):
    """Clear the latched fault.

    Refused while its cause lasts, as a pressed emergency stop does.
    """

    result = ClearedBoards

    def run(self, desk: Desk) -> Result:
        """Clear the fault of each board."""
        rows = desk.rows()

        def clear(item: Known) -> None:
            unit, before = item.board.unit, item.board.fault_text()
            run.command(item.board, "clear_fault", [0])
            done = f"cleared: {before}" if before else "no fault was latched"
            rows.add({"unit": unit, "cleared": before or None}, f"board {unit}: {done}")

        bus.each_board(desk, self, clear)
        return rows.result()


class PermittedBoard(TypedDict):
    """Whether a board's permit output is on."""

    unit: int
    permit: str


class PermittedBoards(TypedDict):
    """The boards that were switched."""

    boards: list[PermittedBoard]


@operation("board permit")
class Permit(ToBoards):
    """Switch the permit output, the gate of a laser or spindle.

    Every fault and every stop switches it off.
    """

    result = PermittedBoards

    state: str = argument(Choice(["on", "off"]))

    def run(self, desk: Desk) -> Result:
        """Switch the output of each board."""
        rows = desk.rows()

        def switch(item: Known) -> None:
            run.command(item.board, f"permit_{self.state}", [0])
            unit = item.board.unit
            text = f"board {unit}: permit output {self.state}"
            rows.add({"unit": unit, "permit": self.state}, text)

        bus.each_board(desk, self, switch)
        return rows.result()


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

    def _each(self, desk: Desk, found: Link, rows: ResultRows) -> None:
        """Stop boards by their addresses, or look at those that were told together."""
        if self.units is not None and not self.everyone:
            bus.each_of(desk, found, self.units, lambda item: self._stop(found, item, rows))
        elif self.look:
            there = self._those_there(desk, found)
            bus.each_of(desk, found, there, lambda item: _look_again(desk, found, item, rows))

    def _beside(self) -> Result:
        """Send the broadcast on a port that another program has open; nobody can be asked then."""
        beside = modbus.Beside()
        Device(beside).stop_all()
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

    def _stop(self, found: Link, item: Known, rows: ResultRows) -> None:
        """Stop axes of a board."""
        axes, unit = item.axes(self.axes), item.board.unit
        run.stop_axes(item.board, axes)
        if self.look:
            _tell(item, run.rests(item.board, axes, found.world), rows)
        else:
            rows.add({"unit": unit, "axes": axes}, f"board {unit}: stop acknowledged")


def _look_again(desk: Desk, found: Link, item: Known, rows: ResultRows) -> None:
    """Look at a board after a broadcast; stop by its address what still moves."""
    axes = item.axes(())
    rests = run.rests(item.board, axes, found.world)
    moving = [axis for axis, one in rests.items() if not one.at_rest]
    if moving:
        desk.complain(BoardError(f"board {item.board.unit}: it has not heard the broadcast"))
        run.stop_axes(item.board, moving)
        rests = run.rests(item.board, axes, found.world)
    _tell(item, rests, rows)


def _tell(item: Known, rests: dict[int, run.Rest], rows: ResultRows) -> None:
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
