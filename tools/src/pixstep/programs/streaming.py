# SPDX-License-Identifier: MIT
"""A plan that is uploaded while it is planned and while it runs: no length needs memory."""

from collections import deque
from collections.abc import Iterator
from itertools import chain, groupby, islice

from pixstep.board.boardrun import BoardRun, Watch
from pixstep.board.device import Board
from pixstep.board.upload import Upload
from pixstep.errors import UserError
from pixstep.lines.runs import (
    MARK_END,
    MARK_NEGATIVE,
    MARK_SMOOTH,
    MARK_START,
    MARK_WAIT_FOR_EDGE,
    MAX_REPEAT,
)
from pixstep.programs.motors import PlanMotor
from pixstep.programs.plan import Plan
from pixstep.programs.results import of_line

_AHEAD = 512  # entries that wait for the board's queue


class Entries:
    """The queue entries of every motor's line, from one plan that all of them draw on."""

    def __init__(self, plan: Plan) -> None:
        self.pixels = 0  # that have been planned
        self._parts = plan.counts()
        self._motors = plan.setup.motors
        self._waiting: list[deque[int]] = [deque() for _ in self._motors]
        self._ways = [0] * len(self._motors)

    def of(self, index: int) -> Iterator[tuple[int, int]]:
        """Yield the entries of a motor: its marks, and its runs as far as they are asked for."""
        motor = self._motors[index]
        counts = self._counts(index)
        first = list(islice(counts, 1))
        while motor.smooth and not self._ways[index] and self._more():
            pass
        yield self._mark(motor, index), 0
        yield 0, 0
        for count, group in groupby(chain(first, counts)):
            while repeat := sum(1 for _ in islice(group, MAX_REPEAT)):
                yield count, repeat
        yield MARK_END, 0

    def _mark(self, motor: PlanMotor, index: int) -> int:
        mark = MARK_START | MARK_WAIT_FOR_EDGE
        if motor.smooth:
            mark |= MARK_SMOOTH
            if (self._ways[index] < 0) != motor.negative:
                mark |= MARK_NEGATIVE
        return mark

    def _counts(self, index: int) -> Iterator[int]:
        waiting = self._waiting[index]
        while waiting or self._more():
            while waiting:
                yield waiting.popleft()

    def _more(self) -> bool:
        """Plan some more pixels for all motors; False at the end."""
        part = next(self._parts, None)
        if part is None:
            return False
        self.pixels += len(part)
        for index, motor in enumerate(self._motors):
            self._waiting[index].extend(of_line(part[:, index], motor).tolist())
            total = int(part[:, index].sum())
            self._ways[index] = self._ways[index] or (total > 0) - (total < 0)
        return True


class StreamedUpload(Upload):
    """An upload whose entries are made when the board has room for them."""

    def __init__(self, board: Board, axis: int, entries: Iterator[tuple[int, int]]) -> None:
        super().__init__(board, axis, [])
        self._source = entries

    @property
    def done(self) -> bool:
        """True when every entry has been accepted."""
        self._refill()
        return not self._left

    def push(self) -> int:
        """Send blocks until the queue is full or the plan is over; return entries accepted."""
        accepted = 0
        while True:
            self._refill()
            now = super().push()
            accepted += now
            if not now or self._left:
                return accepted

    def _refill(self) -> None:
        self._add(islice(self._source, max(0, _AHEAD - len(self._left))))


def stream(run: BoardRun, plan: Plan, watch: Watch | None = None) -> bool:
    """Run a plan on one board while it is planned; return whether the board ended it.

    The board is set up by the caller. Raises UserError for motors of several boards' axes, and
    BoardError as the board does.
    """
    axes = [motor.axis for motor in plan.setup.motors]
    if len(set(axes)) < len(axes):
        raise UserError(f"axes {', '.join(map(str, axes))}: a program streams to one board")
    entries = Entries(plan)
    run.uploads = {
        axis: StreamedUpload(run.board, axis, entries.of(index)) for index, axis in enumerate(axes)
    }
    for upload in run.uploads.values():
        upload.push()
    run.board.command("arm", sorted(axes))
    run.deadline_s = float("inf")
    return run.follow(watch)
