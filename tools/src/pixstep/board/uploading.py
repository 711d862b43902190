# SPDX-License-Identifier: MIT
"""A line checked as its board will check it, before anything is sent."""

from pixstep.board.client import Board, BoardError, Upload
from pixstep.board.limits import BoardLimits
from pixstep.errors import RefusedError
from pixstep.lines import linecheck
from pixstep.lines.line import Line
from pixstep.lines.linecheck import Finding
from pixstep.lines.runs import queue_entries


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
