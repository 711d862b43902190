# SPDX-License-Identifier: MIT
"""In which line of a job the axes of a board are, by their counters and their positions.

`lines_done` counts the lines that a board has decoded, which is some pixels before they are made;
`pixel` and `position_steps` are the account of what is made. So an axis may still be in a line that
`lines_done` has counted. Where both fit, both are places of the axis, the earlier one first.
Whoever has seen `pixel` begin again at a seam knows that the axis is beyond it, and says so by
`least`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from pixstep.board import registers as regs
from pixstep.jobs.history import Base
from pixstep.jobs.job import Job

ENDED = ("done", "loaded", "loading")  # at the end of a line, perhaps with another one queued
MOST_BLOCKS = 0x8000  # since a chain began; more is a count that has gone back
WRAPS = 0x10000
_TICK_HZ = 16_000_000  # of the slowest board
_RING = 255  # entries that a board decodes ahead at most
_PERIOD_TICKS = 0x10000  # of an entry, at most: a pixel without steps takes several
_SLACK_STEPS = 2  # steps that the timer has and the account has not
_SLACK_ENTRIES = 16  # of the ring's fill, which is of another instant


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
        return self.state in regs.MOVING_STATES

    @property
    def counted(self) -> int:
        """Lines that were decoded since the chain began."""
        return (self.now["lines_done"] - self.base.lines_done) % WRAPS

    @property
    def blocks(self) -> int:
        """Blocks that were taken since the chain began."""
        return (self.now["next_block"] - self.base.next_block) % WRAPS

    @property
    def has_gone_back(self) -> bool:
        """True if its counters are below those of the chain's beginning: it was reset."""
        return max(self.blocks, self.counted) > MOST_BLOCKS

    @property
    def position_steps(self) -> int:
        """Where it is."""
        return self.now["position_steps"]


def places(job: Job, first: int, axis: Axis, least: int = 0) -> list[Place]:
    """Return where an axis may be that runs lines from `first` on, the earliest place first.

    It is in line `least` or a later one. At the end of a line that nothing followed it is at pixel
    0 of the next one. An axis without a place is not where any line of the job takes it.
    """
    if axis.state in ENDED or (not axis.moves and _is_at_end(job, first, axis)):
        newest = first + axis.counted
        if newest > job.lines + 1:
            return []
        at_end = axis.position_steps == end_of(job, newest - 1, axis.motor, first)
        return [Place(newest, 0)] if at_end else []
    found = [*_inside(job, max(first, least), axis, first + axis.counted)]
    if not found and not axis.counted and axis.position_steps == axis.base.position_steps:
        return [Place(first, 0)]  # what was queued is discarded, `pixel` is of a line before
    return found


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


def _inside(job: Job, least: int, axis: Axis, newest: int) -> Iterator[Place]:
    """Yield the places in lines whose end the axis has not made."""
    pixel = axis.now["pixel"]
    ring = axis.now["ring_fill"] + _SLACK_ENTRIES if axis.moves else _RING
    for line in range(max(least, newest - ring // job.pixels - 1), newest + 1):
        if not _fits(job, line, axis):
            continue
        if line == newest or _entries(job, line, pixel, newest, axis.motor) <= ring:
            yield Place(line, pixel)


def _entries(job: Job, line: int, pixel: int, newest: int, motor: str) -> int:
    """Return the fewest entries in which a board can decode from a pixel to the end of a line."""
    still = -(-_TICK_HZ // int(job.pixel_hz) // _PERIOD_TICKS) or 1
    found = 0
    for number in range(line, newest):
        counts = job.line(number)[motor].counts
        left = counts[pixel:] if number == line else counts
        found += sum(1 if count else still for count in left)
    return found


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
