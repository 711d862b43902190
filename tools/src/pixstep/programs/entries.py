# SPDX-License-Identifier: MIT
"""The counts of a motor as a board gets them: queue entries, made while the plan goes on."""

from collections import deque

import numpy as np

from pixstep.lines.runs import (
    MARK_END,
    MARK_NEGATIVE,
    MARK_SMOOTH,
    MARK_START,
    MARK_WAIT_FOR_EDGE,
    MAX_REPEAT,
    head_entries,
)
from pixstep.programs.motors import PlanMotor
from pixstep.programs.pixels import Counts

Entry = tuple[int, int]


def of_line(counts: Counts, motor: PlanMotor) -> Counts:
    """Return counts as a line file has them: a smooth line's are unsigned."""
    if motor.smooth:
        return np.abs(counts)
    return -counts if motor.negative else counts


class MotorEntries:
    """The queue entries of one motor that are planned and not taken yet."""

    def __init__(self, motor: PlanMotor, way: int) -> None:
        self.motor = motor
        self.divider: int | None = None  # that its line says
        self.way = way  # the direction in which the motor moves; 0 if it is not known yet
        self.pixels = 0  # of the entries that wait
        self.steps = 0  # of all that was planned, there and back
        self._runs: deque[Entry] = deque()
        self._begun = self._ended = False

    def add(self, counts: Counts) -> None:
        """Take the counts of some pixels."""
        total = int(counts.sum())
        self.way = self.way or (total > 0) - (total < 0)
        self.pixels += len(counts)
        self.steps += int(np.abs(counts).sum())
        line = of_line(counts, self.motor)
        starts = np.flatnonzero(np.diff(line, prepend=line[0] - 1))
        lengths = np.diff(starts, append=len(line))
        for count, repeat in zip(line[starts].tolist(), lengths.tolist(), strict=True):
            self._add(count, repeat)

    def _add(self, count: int, repeat: int) -> None:
        if self._runs and self._runs[-1][0] == count:
            repeat += self._runs.pop()[1]
        while repeat > MAX_REPEAT:
            self._runs.append((count, MAX_REPEAT))
            repeat -= MAX_REPEAT
        self._runs.append((count, repeat))

    @property
    def unknown(self) -> bool:
        """True while the entry that begins a line cannot be made."""
        return self.motor.smooth and not self.way

    def take(self, most: int, *, whole: bool, over: bool) -> list[Entry]:
        """Return up to so many entries; the last run only if it can grow no more, or not `whole`.

        `over` says that no more counts will come.
        """
        found = [] if self._begun else head_entries(self._mark(), (0, 0), self.divider)
        self._begun = True
        kept = 1 if whole and not over else 0
        while len(self._runs) > kept and len(found) < most:
            found.append(self._runs.popleft())
            self.pixels -= found[-1][1]
        if over and not self._runs and not self._ended:
            self._ended = True
            found.append((MARK_END, 0))
        return found

    def _mark(self) -> int:
        mark = MARK_START | MARK_WAIT_FOR_EDGE
        if self.motor.smooth:
            mark |= MARK_SMOOTH
            if (self.way < 0) != self.motor.negative:
                mark |= MARK_NEGATIVE
        return mark
