# SPDX-License-Identifier: MIT
"""The per-pixel records of an axis as they come: each once, and how many came too fast to see.

A board keeps only the newest records of each axis, of every pixel or thinned by the setting
record_every. They are numbered by their pixel in the line, and which line it is follows from
lines_done: the records of a line that moves or was stopped by a fault belong to the one behind
those done. The board counts the records that a line has made, so what was overwritten unread is
known exactly.
"""

from dataclasses import dataclass

from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.state import Record, Records

HEADER = "line,axis,pixel,expected_steps,actual_steps,edge_error_ticks"
_TRIES = 4
_WORD = 0xFFFF
_UNFINISHED = ("running", "fault")
_MOVING = ("armed", "running")


@dataclass(frozen=True)
class Row:
    """One record; `line` counts the axis' lines since reset, from 1."""

    line: int
    axis: int
    record: Record

    @property
    def text(self) -> str:
        """The row of the CSV file."""
        found = self.record
        return (
            f"{self.line},{self.axis},{found.pixel},{found.expected_steps},"
            f"{found.actual_steps},{found.edge_error_ticks}"
        )


class AxisLog:
    """The records of one axis, read again and again.

    The newest record of a line that moves is held back until the next look: the error of its clock
    edge may not be known yet. `line` is the number of the line that is read from its beginning, 0
    if that is to be found out.
    """

    def __init__(self, board: Board, axis: int, line: int = 0) -> None:
        self._board, self.axis = board, axis
        self._line = line
        self._pixel = 0  # of the newest record that was given out
        self._made = 0  # records of the line that were given out or missed
        self._held: Record | None = None
        self.rows = 0
        self.missed = 0
        self.state = ""

    def poll(self) -> list[Row]:
        """Return the records that have come since the last time.

        Raises BoardError as the board does.
        """
        line, block = self._read()
        return self.take(block, line, ended=self.state not in _MOVING)

    def take(self, block: Records, line: int | None = None, *, ended: bool) -> list[Row]:
        """Return the new records of a block; `ended` if the line makes no more.

        Without the number of the line it is the same one, or the next if pixels count anew.
        """
        records = block.records
        anew = bool(records) and records[-1].pixel < self._pixel
        if line is None:
            line = self._line + anew
        before = []
        if line != self._line or anew:
            before = self._rows([self._held] if self._held else [])
            self._line, self._pixel, self._made, self._held = line, 0, 0, None
        fresh = [record for record in records if record.pixel > self._pixel]
        if self._held and (not fresh or fresh[0].pixel > self._held.pixel):
            fresh.insert(0, self._held)  # overwritten since
        if not fresh:
            return before
        self.missed += (block.made - self._made - len(fresh)) & _WORD
        self._made, self._held = block.made, None
        if not ended:
            self._held = fresh.pop()
            self._made -= 1
        return before + self._rows(fresh)

    def _rows(self, records: list[Record]) -> list[Row]:
        """Give records out."""
        self.rows += len(records)
        if records:
            self._pixel = records[-1].pixel
        return [Row(self._line, self.axis, record) for record in records]

    def _read(self) -> tuple[int, Records]:
        """Return the line and its records, of one moment."""
        before = (self._number(), self.state)
        for _ in range(_TRIES):
            records = self._board.record_block(self.axis)
            # A line that ended meanwhile may have made its last records behind those just read.
            after = (self._number(), self.state)
            if after == before:
                break
            before = after
        return before[0], records

    def _number(self) -> int:
        """Return the number of the line that the records belong to."""
        found = self._board.axis(self.axis)
        self.state = regs.axis_state(found["axis_state"])
        if self.state in _UNFINISHED:
            return found["lines_done"] + 1
        # Until the next line begins, the records are those of the last.
        return max(self._line, found["lines_done"], 1)
