# SPDX-License-Identifier: MIT
"""Play taken up at reversals: a transition of some points is laid over the motion of an axis.

The offset of the motor is 0 in the direction in which the play is taken up at the start and `play`
counts against that direction in the other. At a reversal it begins to change in the first point
that has moved the new way, by the same share of the play in every point: `steps` points take all of
it. A second reversal inside of a transition turns the offset back from where it is. Whole counts
are cut from the exact line, so that they never add up wrong; the velocities get the very
differences of the offsets, up to the point before the last.

    position       .-----        offset          ______       velocity    ----.
             -.   /                         ____/             added           |
               '-'                       __/                          --------'
                 reversal                  steps points
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.reversals.play import directions
from pixstep.trajectories import table
from pixstep.trajectories.table import AXES, Table

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")


@dataclass(frozen=True)
class AxisPlay:
    """The play of an axis in counts, and the points of a transition."""

    play: int
    steps: int = 64


@dataclass(frozen=True)
class Transition:
    """What happens at one reversal: records count from 0."""

    axis: int
    record: int  # the last one of the old direction
    direction: int
    points: int  # in which the offset changes
    counts: int  # by which it changes, signed
    missing: int  # of the play, because the next reversal came first


@dataclass(frozen=True)
class Compensated:
    """The motors' table, the offsets in it, and its transitions."""

    table: Table
    original: Table
    offsets: np.ndarray
    transitions: tuple[Transition, ...]
    taken_up: tuple[int, ...]  # by axis: the direction in which the play is taken up at the start


def initial_direction(made: Table, axis: int) -> int:
    """Return the direction of an axis' first motion; +1 for one that never moves."""
    counts = made.counts(axis)
    moving = np.flatnonzero(counts)
    return int(np.sign(counts[moving[0]])) if len(moving) else 1


def compensate(original: Table, plays: tuple[AxisPlay, ...]) -> Compensated:
    """Return the motors' table for the load's.

    Raises UserError for a transition of less than a point, RefusedError naming the record in which
    a motor would have to move further than a pixel can hold.
    """
    for axis, item in enumerate(plays):
        if item.steps < 1 or item.play < 0:
            raise UserError(
                f"axis {axis + 1}: a transition of {item.steps} points for a play of {item.play} "
                f"counts: at least 1 point and 0 counts"
            )
    taken_up = tuple(initial_direction(original, axis) for axis in range(AXES))
    offsets = np.zeros_like(original.positions)
    transitions: list[Transition] = []
    for axis, item in enumerate(plays):
        ways = np.array(directions(original.counts(axis).tolist()), dtype=np.int64)
        offsets[:, axis], found = _axis(ways, item, taken_up[axis], axis)
        transitions += found
    added = np.zeros_like(offsets)
    added[:-1] = np.diff(offsets, axis=0)
    made = table.made(
        original.positions + offsets, original.velocities + added, f"{original.name}, compensated"
    )
    ordered = sorted(transitions, key=lambda item: (item.record, item.axis))
    return Compensated(made, original, offsets, tuple(ordered), taken_up)


def _axis(
    ways: np.ndarray, item: AxisPlay, taken_up: int, axis: int
) -> tuple[np.ndarray, list[Transition]]:
    """Return an axis' offsets at every record, and its transitions.

    `ways` are the directions from each record to the next.
    """
    offsets = np.zeros(len(ways) + 1, dtype=np.int64)
    turns = np.flatnonzero(np.diff(np.concatenate([[taken_up], ways])))
    if not item.play or not np.any(ways):
        return offsets, []
    found = []
    for turn, following in pairwise([*turns.tolist(), len(ways)]):
        begin, end = turn + 1, min(following + 1, len(ways))
        goal = 0 if ways[turn] == taken_up else -taken_up * item.play
        ramp = _ramp(int(offsets[begin]), goal, item, end - begin)
        offsets[begin : end + 1] = ramp
        offsets[end + 1 :] = ramp[-1]
        moved = int(ramp[-1] - ramp[0])
        points = int(np.argmax(ramp == ramp[-1]))
        missing = abs(goal - int(ramp[-1]))
        found.append(Transition(axis, turn, int(ways[turn]), points, moved, missing))
    return offsets, found


def _ramp(start: int, goal: int, item: AxisPlay, points: int) -> np.ndarray:
    """Return the offsets of a record and of `points` behind it, on the way to a goal."""
    away = np.arange(points + 1, dtype=np.int64) * item.play // item.steps
    offsets: np.ndarray = start + np.sign(goal - start) * np.minimum(away, abs(goal - start))
    return offsets
