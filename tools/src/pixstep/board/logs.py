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
    """The records of one axis, read again and again."""

    def __init__(self, board: Board, axis: int) -> None:
        self._board, self.axis = board, axis
        self._line = 0  # none yet
        self._pixel = 0
        self._made = 0  # records of the line that came before the last look
        self.rows = 0
        self.missed = 0
        self.state = ""

    def poll(self) -> list[Row]:
        """Return the records that have come since the last time."""
        line, block = self._read()
        records = block.records
        again = bool(records) and records[-1].pixel < self._pixel  # a line after one stopped
        if line != self._line or again:
            first_look = self._line == 0
            self._line = line
            # What was there before the first look is not missed.
            self._pixel = records[0].pixel - 1 if first_look and records else 0
            self._made = block.made - len(records) if first_look else 0
        fresh = [record for record in records if record.pixel > self._pixel]
        if fresh:
            self.missed += (block.made - self._made - len(fresh)) & _WORD
            self._made = block.made
            self._pixel = fresh[-1].pixel
        self.rows += len(fresh)
        return [Row(line, self.axis, record) for record in fresh]

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
