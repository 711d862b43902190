# SPDX-License-Identifier: MIT
"""Give boards a command: arm, disarm, clear, enable, disable, permit."""

from typing import ClassVar, TypedDict

from pixstep.board import run
from pixstep.errors import UserError
from pixstep.operations import bus
from pixstep.operations.bus import Known, ToBoards, some_axes
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Choice, Whole
from pixstep.operations.request import argument, operation, option, shared_fields
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
                with bus.stopping([run.Lines(item.board, chosen)]):
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
