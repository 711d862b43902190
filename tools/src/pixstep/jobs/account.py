# SPDX-License-Identifier: MIT
"""In which line of a job the axes of a board are, by their counters and their positions.

`lines_done`, `pixel` and `position_steps` are the account of what an axis has made. Its registers
are read one after the other: where a seam passes between them, `pixel` is of the line before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pixstep.board import registers as regs
from pixstep.jobs.job import Job
from pixstep.jobs.run_log import Base

ENDED = ("done", "loaded", "loading")  # at the end of a line, perhaps with another one queued
MOST_BLOCKS = 0x8000  # since a chain began; more is a count that has gone back
WRAPS = 0x10000
_NONE_FOLLOWED = "none_followed"  # of an axis' line_error
_SLACK_STEPS = 2  # steps that the timer has and the account has not


@dataclass(frozen=True)
class LinePlace:
    """A line of the job and the pixel edges passed in it."""

    line: int
    pixel: int


@dataclass(frozen=True)
class JobAxis:
    """An axis of a job: its motor, where its chain of lines began, its registers now."""

    motor: str
    base: Base
    now: Mapping[str, int]

    @property
    def state(self) -> str:
        """The name of its state."""
        return regs.axis_state(self.now["axis_state"])

    @property
    def moves(self) -> bool:
        """True if it moves, or is about to."""
        return self.state in regs.MOVING_STATES

    @property
    def counted(self) -> int:
        """Lines that were made since the chain began."""
        return (self.now["lines_done"] - self.base.lines_done) % WRAPS

    @property
    def blocks(self) -> int:
        """Blocks that were taken since the chain began."""
        return (self.now["next_block"] - self.base.next_block) % WRAPS

    @property
    def lacked_a_line(self) -> bool:
        """True if its line said that another one follows, and none was queued at its end."""
        return regs.code_name(regs.line_errors(), self.now["line_error"]) == _NONE_FOLLOWED

    @property
    def has_gone_back(self) -> bool:
        """True if its counters are below those of the chain's beginning: it was reset."""
        return max(self.blocks, self.counted) > MOST_BLOCKS

    @property
    def position_steps(self) -> int:
        """Where it is."""
        return self.now["position_steps"]


def place_of(job: Job, first: int, axis: JobAxis) -> LinePlace | None:
    """Return where an axis is that runs lines from `first` on; None: where no line takes it.

    At the end of a line that nothing followed it is at pixel 0 of the next one.
    """
    newest = first + axis.counted
    if newest > job.lines + 1:  # a count that has gone back, or lines of others
        return None
    if axis.state in ENDED or (not axis.moves and _is_at_end(job, axis)):
        at_end = axis.position_steps == end_of(job, newest - 1, axis.motor, first)
        return LinePlace(newest, 0) if at_end else None
    for line in (newest, newest - 1):
        if line >= first and _fits(job, line, axis):
            return LinePlace(line, axis.now["pixel"])
    if not axis.counted and axis.position_steps == axis.base.position_steps:
        return LinePlace(first, 0)  # what was queued is discarded, `pixel` is of a line before
    return None


def place_of_board(places: Sequence[LinePlace | None]) -> LinePlace | None:
    """Return where the axes of a board are; None if they are not in one line.

    Of axes that were stopped at a seam one may be a pixel beyond it.
    """
    known = [place for place in places if place]
    if not known or len(known) < len(places):
        return None
    least, most = min(known, key=_order), max(known, key=_order)
    apart = most.line - least.line
    return least if not apart or (apart == 1 and most.pixel <= 1) else None


def _order(place: LinePlace) -> tuple[int, int]:
    return place.line, place.pixel


def end_of(job: Job, line: int, motor: str, first: int = 1) -> int:
    """Return where a motor is at the end of a line; before line `first` where that begins."""
    if line < first:
        return job.runs_of(first)[motor].start_steps
    return job.expected(line, motor)[-1]


def _fits(job: Job, line: int, axis: JobAxis) -> bool:
    """Whether a position is one that the motor passes in a line, about this pixel."""
    pixel, position = axis.now["pixel"], axis.position_steps
    if line > job.lines or pixel > job.pixels:
        return False
    table = (job.runs_of(line)[axis.motor].start_steps, *job.expected(line, axis.motor))
    near = table[max(0, pixel - 1) : pixel + 2]
    return min(near) - _SLACK_STEPS <= position <= max(near) + _SLACK_STEPS


def _is_at_end(job: Job, axis: JobAxis) -> bool:
    """Whether an axis that does not move was stopped before, or after, all that it has counted."""
    untouched = not axis.counted and not axis.blocks
    return untouched or (bool(axis.counted) and axis.now["pixel"] == job.pixels)
