# SPDX-License-Identifier: MIT
"""The way of a line into an axis' queue.

A block whose reply was lost is repeated (the board drops the copy); a line longer than the queue
is streamed: call `Upload.push` again while it runs.
"""

from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.errors import BUSY, BoardError

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
        self.last: tuple[int, list[tuple[int, int]]] | None = None

    @property
    def done(self) -> bool:
        """True when every entry has been accepted."""
        return not self._left

    def push(self) -> int:
        """Send blocks until all are accepted or one filled the queue; return entries accepted.

        What the board takes out of the queue meanwhile waits for the next call: fast pixels would
        otherwise keep this one busy to the end of the line. Raises LineRefusedByBoardError if the
        board refuses the line.
        """
        before = len(self._left)
        while self._left:
            known, self._free = self._free, None
            free = self.board.axis(self.axis)["queue_free"] if known is None else known
            size = min(free, len(self._left), regs.MAX_ENTRIES)
            if size == 0 or not self._send(self._left[:size]):
                break
            del self._left[:size]
            if size == free:
                break
        return before - len(self._left)

    def _send(self, entries: list[tuple[int, int]]) -> bool:
        """Send one block; False if the board is busy (queue full)."""
        try:
            self.board.write_block(self.axis, self._block, entries)
        except BoardError as error:
            if error.code == BUSY:
                return False
            state = self.board.axis(self.axis)
            if error.code == _ILLEGAL_VALUE and regs.AXIS_STATES[state["axis_state"]] == "refused":
                raise self.board.refusal(self.axis) from None
            raise
        self.last = (self._block, entries)
        self._block = (self._block + 1) & 0xFFFF
        return True
