# SPDX-License-Identifier: MIT
"""In which line of a job the axes of a board are, by their counters and their positions.

`lines_done` counts the lines that a board has decoded, which is some pixels before they are made;
`pixel` and `position_steps` are the account of what is made. So an axis may still be in a line that
`lines_done` has counted. Where both fit, both are places of the axis, the earlier one first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from pixstep.board import registers as regs
from pixstep.jobs.history import Base
from pixstep.jobs.job import Job

MOVING = ("armed", "running")
ENDED = ("done", "loaded", "loading")  # at the end of a line, perhaps with another one queued
MOST_BLOCKS = 0x8000  # since a chain began; more is a count that has gone back
_WRAPS = 0x10000
_RING = 64  # entries that a board decodes ahead at most, each a pixel at most
_SLACK_STEPS = 2  # steps that the timer has and the account has not
_SLACK_PIXELS = 2  # of the ring's fill, which is of another instant


@dataclass(frozen=True)
class Place:
    """A line of the job and the pixel edges passed in it."""

    line: int
    pixel: int


@dataclass(frozen=True)
class Axis:
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
        return self.state in MOVING

    @property
    def counted(self) -> int:
        """Lines that were decoded since the chain began."""
        return (self.now["lines_done"] - self.base.lines_done) % _WRAPS

    @property
    def blocks(self) -> int:
        """Blocks that were taken since the chain began."""
        return (self.now["next_block"] - self.base.next_block) % _WRAPS

    @property
    def position_steps(self) -> int:
        """Where it is."""
        return self.now["position_steps"]


def places(job: Job, first: int, axis: Axis) -> list[Place]:
    """Return where an axis may be that runs lines from `first` on, the earliest place first.

    At the end of a line that nothing followed it is at pixel 0 of the next one. An axis without a
    place is not where any line of the job takes it.
    """
    if axis.state in ENDED or (not axis.moves and _is_at_end(job, first, axis)):
        newest = first + axis.counted
        at_end = axis.position_steps == end_of(job, newest - 1, axis.motor, first)
        return [Place(newest, 0)] if at_end else []
    return [*_inside(job, first, axis)]


def common(found: Iterable[list[Place]]) -> list[Place]:
    """Return the places in lines that are possible for all axes of a board."""
    several = [*found]
    lines = [{place.line for place in one} for one in several]
    shared = set.intersection(*lines) if lines else set()
    return [place for place in several[0] if place.line in shared] if shared else []


def end_of(job: Job, line: int, motor: str, first: int = 1) -> int:
    """Return where a motor is at the end of a line; before line `first` where that begins."""
    if line < first:
        return job.runs_of(first)[motor].start_steps
    return job.expected(line, motor)[-1]


def _inside(job: Job, first: int, axis: Axis) -> Iterator[Place]:
    """Yield the places in lines whose end the axis has not made."""
    newest, pixel = first + axis.counted, axis.now["pixel"]
    ahead = axis.now["ring_fill"] + _SLACK_PIXELS if axis.moves else _RING
    for line in range(max(first, newest - ahead // job.pixels - 1), newest + 1):
        unmade = (newest - line) * job.pixels - pixel  # of the pixels that were decoded
        if (line == newest or unmade <= ahead) and _fits(job, line, axis):
            yield Place(line, pixel)


def _fits(job: Job, line: int, axis: Axis) -> bool:
    """Whether a position is one that the motor passes in a line, about this pixel."""
    pixel, position = axis.now["pixel"], axis.position_steps
    if line > job.lines or pixel > job.pixels:
        return False
    table = (job.runs_of(line)[axis.motor].start_steps, *job.expected(line, axis.motor))
    near = table[max(0, pixel - 1) : pixel + 2]
    return min(near) - _SLACK_STEPS <= position <= max(near) + _SLACK_STEPS


def _is_at_end(job: Job, first: int, axis: Axis) -> bool:
    """Whether an axis that does not move was stopped before, or after, all that it has counted."""
    pixel = axis.now["pixel"]
    untouched = not axis.counted and not axis.blocks
    return untouched or (bool(axis.counted) and pixel == job.pixels)
