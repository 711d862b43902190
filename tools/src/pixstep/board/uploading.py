# SPDX-License-Identifier: MIT
"""A line checked as its board will check it, before anything is sent."""

from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import settings, values
from pixstep.board.client import Board, BoardError, Upload
from pixstep.errors import RefusedError
from pixstep.lines import linecheck
from pixstep.lines.line import Line
from pixstep.lines.linecheck import Finding, Limits
from pixstep.lines.rational import period_ticks
from pixstep.lines.runs import queue_entries

_RUNNING = ("armed", "running")


@dataclass(frozen=True)
class BoardLimits:
    """What a board says of itself that a line has to keep."""

    min_interval_ticks: int
    smooth_min_interval_ticks: int
    max_acceleration: int
    start_stop_steps: int
    pixel_hz: Fraction
    tick_hz: int

    def of(self, line: Line) -> Limits:
        """Return the limits for a line's decode rule."""
        smallest = self.smooth_min_interval_ticks if line.smooth else self.min_interval_ticks
        return Limits(
            # The board asks the acceleration of smooth lines only, reversals of plain ones.
            max_acceleration=(self.max_acceleration or None) if line.smooth else None,
            start_stop=None if line.smooth else (self.start_stop_steps or None),
            min_interval_ticks=smallest,
            period_ticks=period_ticks(self.pixel_hz, self.tick_hz),
        )


def limits(board: Board, pixel_hz: Fraction | None = None) -> BoardLimits:
    """Ask a board for its limits; at another pixel frequency than its own if one is given."""
    state, known = board.inputs(), settings.read(board)
    return BoardLimits(
        state["min_interval_ticks"],
        state["smooth_min_interval_ticks"],
        known["max_acceleration"],
        known["start_stop_steps"],
        pixel_hz or values.hz_of(known),
        board.tick_hz(),
    )


def check(line: Line, found: BoardLimits) -> list[Finding]:
    """Return the findings of a line; raises RefusedError naming the first that refuses it."""
    findings = linecheck.check(line, found.of(line))
    errors = [item for item in findings if item.severity == linecheck.ERROR]
    if errors:
        first = errors[0]
        where = f"pixel {first.pixel}" if first.pixel else "the line as a whole"
        raise RefusedError(
            f"{line.name}: line refused: {first.name} at {where}: {first.message} (nothing was "
            f"sent; `pixstep line check` shows all)"
        )
    return findings


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
