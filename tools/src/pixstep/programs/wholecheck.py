# SPDX-License-Identifier: MIT
"""A plan's lines checked as a board does, to their ends, while they are planned."""

from collections.abc import Sequence

from pixstep.board.limits import BoardLimits
from pixstep.lines.core import Checker, Code
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import IDLE_PIXEL
from pixstep.programs.entries import MotorEntries
from pixstep.programs.motors import PlanMotor
from pixstep.programs.pixels import Counts

_MOST = 20  # errors of a motor that are kept
_ALL = 1 << 31  # more entries than there are


class WholeCheck:
    """The lines of all motors, each by the limits of its board; memory does not grow with them."""

    def __init__(self, motors: Sequence[PlanMotor], bounds: Sequence[BoardLimits]) -> None:
        self._lines = [_LineCheck(*pair) for pair in zip(motors, bounds, strict=True)]

    def add(self, counts: Counts) -> None:
        """Take the counts of some pixels, a column for each motor."""
        for index, line in enumerate(self._lines):
            line.add(counts[:, index])

    def end(self) -> list[list[Code]]:
        """Return the first errors of each motor's line, which is over."""
        return [line.end() for line in self._lines]


class _LineCheck:
    def __init__(self, motor: PlanMotor, bounds: BoardLimits) -> None:
        self._entries = MotorEntries(motor, 0)
        limits = bounds.of(Line((), SMOOTH if motor.smooth else PLAIN))
        self._checker = Checker(limits.of_board())
        self._errors: list[Code] = []

    def add(self, counts: Counts) -> None:
        self._entries.add(counts)
        if not self._entries.unknown:
            self._check(over=False)

    def end(self) -> list[Code]:
        self._entries.way = self._entries.way or 1  # one that never moves may have either
        self._check(over=True)
        return self._errors

    def _check(self, *, over: bool) -> None:
        found = self._checker.more(self._entries.take(_ALL, whole=True, over=over))
        # A line of counts does not tell the backlash, which an idle pixel is about.
        errors = [code for code in found if code.is_error and code.name != IDLE_PIXEL]
        self._errors += errors[: _MOST - len(self._errors)]
