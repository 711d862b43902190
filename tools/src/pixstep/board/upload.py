# SPDX-License-Identifier: MIT
"""The way of a line into an axis' queue.

A block whose reply was lost is repeated as it was (the board drops the copy); a line longer than
the queue is streamed: call `Upload.push` again while it runs.
"""

from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.errors import BUSY, BoardError
from pixstep.lines.line import Line
from pixstep.lines.runs import queue_entries

_ILLEGAL_VALUE = 3


class Upload:
    """The blocks of one line on their way into an axis' queue.

    `state` is what `Board.axis` says of it, if that has just been asked.
    """

    def __init__(
        self,
        board: Board,
        axis: int,
        entries: list[tuple[int, int]],
        state: dict[str, int] | None = None,
    ) -> None:
        self.board, self.axis = board, axis
        self._left = list(entries)
        state = state or board.axis(axis)
        self._block = state["next_block"]
        self._free: int | None = state["queue_free"]  # None: to be asked for again
        self._open = 0  # entries of a block that may have been taken: its answer never came
        self.last: tuple[int, list[tuple[int, int]]] | None = None

    @property
    def block(self) -> int:
        """Number of the block that is sent next."""
        return self._block

    @property
    def done(self) -> bool:
        """True when every entry has been accepted."""
        return not self._left

    def push(self) -> int:
        """Send blocks until all are accepted or one filled the queue; return entries accepted.

        What the board takes out of the queue meanwhile waits for the next call: fast pixels would
        otherwise keep this one busy to the end of the line. Raises LineRefusedByBoardError if the
        board refuses the line, NoReplyError if it does not answer: call again to go on.
        """
        before = len(self._left)
        while self._left:
            if self._open:
                # The same block with the same entries, or the board would drop others as a copy.
                free, size = None, self._open
            else:
                free = self._room()
                size = min(free, len(self._left), regs.MAX_ENTRIES)
            if size == 0 or not self._send(self._left[:size]):
                break
            del self._left[:size]
            if size == free:
                break
        return before - len(self._left)

    def _room(self) -> int:
        """Return the free entries of the queue, as last known or asked for."""
        known, self._free = self._free, None
        return self.board.axis(self.axis)["queue_free"] if known is None else known

    def _send(self, entries: list[tuple[int, int]]) -> bool:
        """Send one block; False if the board is busy (queue full).

        A request that was spoilt on its way and passes the checksum all the same (one in 65,536)
        is answered with an exception: what the board then says of its queue decides.
        """
        self._open = len(entries)
        for last in (False, False, True):
            try:
                self.board.write_block(self.axis, self._block, entries)
                break
            except BoardError as error:
                if error.code is None:
                    raise
                if error.code == BUSY:
                    self._open = 0
                    return False
                if self._taken_all_the_same(error, last):
                    break
        self._open = 0
        self.last = (self._block, entries)
        self._block = (self._block + 1) & 0xFFFF
        return True

    def _taken_all_the_same(self, error: BoardError, last: bool) -> bool:
        """Whether the board has a block that it answered with an exception; False: to be repeated.

        Raises what is really wrong: a refused line, a fault, or the exception itself.
        """
        state = self.board.axis(self.axis)
        name = regs.axis_state(state["axis_state"])
        if error.code == _ILLEGAL_VALUE and name == "refused":
            raise self.board.refusal(self.axis) from None
        if name == "fault":
            raise BoardError(
                f"board {self.board.unit}: axis {self.axis} takes no line: "
                f"{self.board.fault_advice()}"
            ) from None
        if state["next_block"] == (self._block + 1) & 0xFFFF:
            return True
        if last and error.code == _ILLEGAL_VALUE and state["line_error"]:
            # A line that moves already is not in state refused: its axis runs dry.
            raise self.board.refusal(self.axis) from None
        if last or error.code != _ILLEGAL_VALUE or state["next_block"] != self._block:
            raise error
        return False


def begin(board: Board, lines: dict[int, Line]) -> list[Upload]:
    """Queue lines by axis, or as much of them as the queues hold; return what may be left.

    Raises LineRefusedByBoardError, and BoardError for an axis that will not load.
    """
    uploads = []
    for axis, line in lines.items():
        upload = Upload(board, axis, queue_entries(line))
        upload.push()
        uploads.append(upload)
    return uploads


def room(board: Board, axis: int, line: Line) -> tuple[int, int]:
    """Return the queue entries that a line takes, and those that are free."""
    state = board.axis(axis)
    if not state["queue_free"]:
        raise BoardError(
            f"board {board.unit}: the queue of axis {axis} is full (`pixstep board disarm` forgets "
            f"what is in it)"
        )
    return len(queue_entries(line)), state["queue_free"]
