# SPDX-License-Identifier: MIT
"""Lines on their way into the queue of an axis, one request at a time: begun, armed, streamed.

Whoever drives several axes gives each its turn between two requests. The methods that ask the board
are therefore generators: each `yield` follows a request; it gives the seconds that may pass until
the next one, 0 at once.

What a drive wants of a board that boards cannot do yet: each in one place, and what it does.

A later board replaces the body of a function here, and nothing else.

A braking stop. Instead `stop` is the board's stop: the axis makes at most one STEP edge more,
whatever its speed. The position stays right by the count, but a motor that is faster than it can
stop at once slips. The record's STOP, the end of a jog and a new target while the motor moves stop
like this.

Set position. Instead `set_position` is an offset between the board's register and the record's raw
position. The drive keeps it; it is gone with the process, and RSTM and autosave bring the position
back. A homing makes it 0.

A jog on the board. Instead `motions.Jog` sends short lines that follow each other without a gap,
queued beyond what the board decodes ahead: 0.3 s at 2000 steps/s, 1.3 s of slow steps. A
change of speed begins after that time, and a motor whose host has died stops after it.

An encoder. There is none: EA_PRESENT is never set.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import chain, islice

from pixstep.board import run
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload, pause_s
from pixstep.lines import runs


def stop(board: Device, axis: int) -> None:
    """Stop an axis; raises BoardError if it is not known to have been."""
    run.stop_axes(board, [axis])


def set_position(position_steps: int, register_steps: int) -> int:
    """Return the offset by which a board's register shows a position."""
    return position_steps - register_steps


def clear_fault(board: Device, axes: int) -> None:
    """Clear the board's fault. Raises BoardError saying why that is not possible."""
    run.command(board, "clear_fault", list(range(axes)))


def discard(board: Device, axis: int) -> Steps:
    """Forget what is queued of a line that does not run."""
    run.command(board, "disarm", [axis])
    yield 0.0


_AHEAD = 160  # entries that are made before the board has room for them
_LOADED = 2
_FIRST_BYTES = 56  # of the first block: a short one takes the bus less time before arm
_MOST_PAUSE_S = 0.1
# Of what is queued before arm, and more for each other motion: it has its requests before the next
# block, and fast pixels would run dry meanwhile.
_LEAST_S, _OTHER_S = 0.03, 0.03
_DRY_S = 0.2  # a queue that is empty so soon is filled before other motions begin
_HURRY_BYTES = 64  # of a block for it: others may wait for theirs
_KEPT = 1024  # entries whose pixels are known: those that are made ahead, and a block before them
_END = (runs.MARK_END, 0)
Entry = tuple[int, int]
Steps = Iterator[float]


class LazyUpload(LineUpload):
    """An upload whose entries are made when they are wanted; more can follow."""

    def __init__(
        self, board: Device, axis: int, entries: Iterable[Entry], state: dict[str, int]
    ) -> None:
        self._source = iter(entries)
        self.first_line = 0
        """Entries of the first whole line; 0 as long as its end is not made."""
        self._ends_px: deque[int] = deque(maxlen=_KEPT)  # of each entry, from the first one on
        self._made_px = 0
        super().__init__(board, axis, [], state)

    @property
    def done(self) -> bool:
        """True when every entry so far has been accepted."""
        self._refill()
        return not self._left

    def more(self, entries: Iterable[Entry]) -> None:
        """Let entries follow: those of a line begin with its start mark."""
        self._source = chain(self._source, entries)

    def _refill(self) -> None:
        if len(self._left) < _AHEAD // 2:
            self._add(self._counted(islice(self._source, _AHEAD)))

    @property
    def accepted(self) -> int:
        """Entries that the board has accepted."""
        return self._count - len(self._left)

    @property
    def accepted_px(self) -> int:
        """How many pixels these entries are."""
        left = len(self._left)
        return self._ends_px[-1 - left] if left < len(self._ends_px) else 0

    def _counted(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        for entry in entries:
            self._made_px += entry[1]
            self._ends_px.append(self._made_px)
            yield entry
            if not self.first_line and entry == _END:
                self.first_line = self._count  # with this one, which was added meanwhile


class Feed:
    """Lines of one axis: what is queued of them, and whether they are armed.

    `state` are the axis' registers as they have just been read.
    """

    def __init__(
        self,
        board: Device,
        axis: int,
        entries: Iterable[Entry],
        state: dict[str, int],
        pixel_s: float,
    ) -> None:
        self.board, self.axis, self._pixel_s = board, axis, pixel_s
        self._upload = LazyUpload(board, axis, entries, state)
        self._room = state["queue_free"] * runs.MOST_BYTES
        self._lines_done = state["lines_done"]
        self._hurries = False

    @property
    def done(self) -> bool:
        """True when all there is has been accepted."""
        return self._upload.done

    def more(self, entries: Iterable[Entry]) -> None:
        """Let another line follow."""
        self._upload.more(entries)

    @property
    def lasts_s(self) -> float:
        """How long all lasts that the board has accepted so far, from the first pixel on."""
        return self._upload.accepted_px * self._pixel_s

    def left_s(self, since_start_s: float) -> float:
        """Return how long the queue still lasts, some time after the start; inf if that is enough.

        It is enough if all was sent, or if it lasts longer than other motions take to begin.
        """
        left_s = self.lasts_s - since_start_s
        self._hurries = left_s < _DRY_S and not self.done
        return left_s if self._hurries else math.inf

    def begin(self, others: int = 0) -> Steps:
        """Queue what the queue holds, and arm. Raises BoardError for what the board refuses.

        `others` is how many other motions share the bus. The axis is armed as soon as the first
        line is queued and a part of the next one, for which the board waits. The rest is queued
        while the first line runs.
        """
        upload, most = self._upload, _FIRST_BYTES
        least_s = self.lasts_s + _LEAST_S + _OTHER_S * others
        while not (
            upload.done or (0 < upload.first_line < upload.accepted and self.lasts_s >= least_s)
        ):
            sent = upload.push_into(min(self._room, most))
            if not sent:
                break
            self._room, most = self._room - sent, _HURRY_BYTES
            yield 0.0
        run.arm(self.board, [self.axis], known=[(_LOADED, self._lines_done)])
        yield 0.0

    def begin_again(self, state: dict[str, int]) -> Steps:
        """Do the same for lines that came when those before them were over."""
        self._room = state["queue_free"] * runs.MOST_BYTES
        self._lines_done = state["lines_done"]
        yield from self.begin()

    def stream(self) -> Steps:
        """Queue what is left as the queue gets empty, and what follows; it never ends by itself."""
        while True:
            if self._upload.done:
                yield _MOST_PAUSE_S
                continue
            room = self.board.room(self.axis)[0]
            yield 0.0
            while room and not self._upload.done:
                sent = self._upload.push_into(min(room, _HURRY_BYTES) if self._hurries else room)
                if not sent:
                    break
                room -= sent
                yield 0.0
            yield pause_s([self._upload], self._pixel_s, _MOST_PAUSE_S)


def require_idle(state: str, axis: int) -> None:
    """Raise BoardError for an axis with a line of another program's."""
    if state in ("loaded", "armed", "running"):
        raise BoardError(
            f"axis {axis} is {state}: another program has a line there; let it end, or stop it"
        )


def lines_since(now: int, before: int) -> int:
    """Return how many lines were finished between two readings of lines_done."""
    return (now - before) & 0xFFFF
