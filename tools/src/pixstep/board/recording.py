# SPDX-License-Identifier: MIT
"""The per-pixel records of lines, read along while they run.

A board keeps the newest records only. How many of them a host can read before they are overwritten
depends on the pixel frequency, the axes and the baud rate: where that is not all of them, the board
is told to keep every Nth (setting record_every), and every deviation besides.
"""

import contextlib
import math
from collections.abc import Callable, Iterator
from fractions import Fraction

from pixstep.board import registers as regs
from pixstep.board import settings, values
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.board.logs import AxisLog, Row
from pixstep.board.run import Lines
from pixstep.board.upload import Upload, feed

EVERY = "record_every"
_MOST_EVERY = 10_000  # of the setting
_BITS = 11  # of a byte on the line: start, eight, parity, stop
_FRAME = 13  # bytes of a request and around the words of its reply
_LATENCY_S = 0.01  # from a request to the next, beside the bytes
_POLL_S = 0.08  # between two looks, of whoever follows a line, on a host that has more to do
_KEPT = 0.9  # the share of the time for which a board keeps a record, from look to look
_OFTEN = 0.4  # the same, as it is aimed at
_MOST_S = 0.5
_PIXEL_BYTES = 1.5  # of a line that goes over the bus at the same time, at most,
_MOST_SHARE = 0.75  # which takes so much of its time from the records, never more

Take = Callable[[Row], None]


class Recorder:
    """What reads the records of one board's lines; `run.follow` asks it to look.

    `take` gets each record once, those of an axis in their order.
    """

    def __init__(self, board: Board, axes: list[int], take: Take, pixel_s: float) -> None:
        self._board, self._take = board, take
        found = board.axes(max(axes) + 1)
        self.logs = [AxisLog(board, axis, found[axis]["lines_done"] + 1) for axis in axes]
        self.every = board.setting(EVERY)
        self._pause_s = min(_MOST_S, _OFTEN * board.record_capacity() * self.every * pixel_s)
        self._due_s = 0.0

    @property
    def rows(self) -> dict[int, int]:
        """How many records there are, by axis."""
        return {log.axis: log.rows for log in self.logs}

    @property
    def missed(self) -> dict[int, int]:
        """How many were overwritten before they were read, by axis."""
        return {log.axis: log.missed for log in self.logs}

    def look_if_due(self, world: World, uploads: list[Upload]) -> None:
        """Read what is new, if it is time for that; what is left of lines is sent in between."""
        now_s = world.now_s()
        if now_s >= self._due_s:
            self._due_s = now_s + self._pause_s
            self.look(uploads)

    def look(self, uploads: list[Upload], *, ended: bool = False) -> None:
        """Read what is new; `ended` if no line makes any more."""
        for log in self.logs:
            block = self._board.short_record_block(log.axis)
            for row in log.take(block, ended=ended) if block else ():  # else at the next look
                self._take(row)
            if not ended:
                feed(uploads)


def every_of(hz: Fraction, axes: int, capacity: int, baud: int, *, streamed: bool) -> int:
    """Return every how many pixels a record can be read before a board overwrites it.

    `hz` is the frequency of pixels, `axes` the number of axes, `capacity` how many records a board
    keeps of each; `streamed` if their lines are sent meanwhile.
    """
    record_words = regs.RECORD_HEAD + capacity * regs.RECORD_REGISTERS
    frames = [_FRAME + 2 * record_words] * axes + [_FRAME + 2 * regs.AXIS_STRIDE * axes, 2 * _FRAME]
    if streamed:
        frames += [2 * _FRAME] * axes  # after each axis the queues are asked for room
    look_s = sum(frames) * _BITS / baud + len(frames) * _LATENCY_S
    share = float(hz) * axes * _PIXEL_BYTES * _BITS / baud if streamed else 0.0
    unread_s = _POLL_S + look_s / (1 - min(share, _MOST_SHARE))
    return min(_MOST_EVERY, max(1, math.ceil(float(hz) * unread_s / (_KEPT * capacity))))


@contextlib.contextmanager
def recorded(
    lines: Lines, take: Take, *, streamed: bool = True, queued: bool = False
) -> Iterator[Recorder | None]:
    """Let `run.follow` read the records of lines; yield what does, None of a board without any.

    Enter it when the board's clock is set and before the lines are queued; once they are `queued`
    the board keeps as many records as it was set to. `streamed` says that lines may be longer than
    a queue. The board is set back after the lines, if no fault forbids that; not where they are
    locked to the clock or the clock is gated, because a board measures its clock anew after every
    change of a setting.
    """
    board = lines.board
    capacity = board.record_capacity()
    if not capacity:
        yield None
        return
    known = settings.read(board)
    hz = values.hz_of(known) / settings.divider_of(known)
    before = wanted = known[EVERY]
    if not queued:
        baud = 100 * known["baud_100"]
        wanted = max(before, every_of(hz, len(lines.axes), capacity, baud, streamed=streamed))
    if wanted != before:
        board.write_setting(EVERY, wanted)
    lines.recorder = Recorder(board, lines.axes, take, float(1 / hz))
    try:
        yield lines.recorder
    finally:
        lines.recorder = None
        if wanted != before and not (settings.locks(known) or settings.gate_of(known)):
            with contextlib.suppress(BoardError), board.once():
                board.write_setting(EVERY, before)
