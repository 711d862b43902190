# SPDX-License-Identifier: MIT
"""Lines on their way into the queue of an axis, one request at a time: begun, armed, streamed.

Whoever drives several axes gives each its turn between two requests. The methods that ask the board
are therefore generators: each `yield` follows a request; it gives the seconds that may pass until
the next one, 0 at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain, islice

from pixstep.board import run
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.upload import Upload, pause_s
from pixstep.lines import runs

_AHEAD = 160  # entries that are made before the board has room for them
_LOADED = 2
_FIRST_BYTES = 56  # of the first block: a short one takes the bus less time before arm
_MOST_PAUSE_S = 0.1
_END = (runs.MARK_END, 0)
Entry = tuple[int, int]
Steps = Iterator[float]


class LazyUpload(Upload):
    """An upload whose entries are made when they are wanted; more can follow."""

    def __init__(
        self, board: Board, axis: int, entries: Iterable[Entry], state: dict[str, int]
    ) -> None:
        self._source = iter(entries)
        self.first_line = 0
        """Entries of the first whole line; 0 as long as its end is not made."""
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

    def _counted(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        for entry in entries:
            yield entry
            if not self.first_line and entry == _END:
                self.first_line = self._count  # with this one, which was added meanwhile


class Feed:
    """Lines of one axis: what is queued of them, and whether they are armed.

    `state` are the axis' registers as they have just been read.
    """

    def __init__(
        self, board: Board, axis: int, entries: Iterable[Entry], state: dict[str, int]
    ) -> None:
        self.board, self.axis = board, axis
        self._upload = LazyUpload(board, axis, entries, state)
        self._room = state["queue_free"] * runs.MOST_BYTES
        self._lines_done = state["lines_done"]

    @property
    def done(self) -> bool:
        """True when all there is has been accepted."""
        return self._upload.done

    def more(self, entries: Iterable[Entry]) -> None:
        """Let another line follow."""
        self._upload.more(entries)

    def begin(self) -> Steps:
        """Queue what the queue holds, and arm. Raises BoardError for what the board refuses.

        It is armed as soon as its first line is there and a part of the next one, for which the
        board waits: what is left comes while the first one runs.
        """
        upload, most = self._upload, _FIRST_BYTES
        while not (upload.done or 0 < upload.first_line < upload.accepted):
            sent = upload.push_into(min(self._room, most))
            if not sent:
                break
            self._room, most = self._room - sent, self._room
            yield 0.0
        run.arm(self.board, [self.axis], known=[(_LOADED, self._lines_done)])
        yield 0.0

    def begin_again(self, state: dict[str, int]) -> Steps:
        """Do the same for lines that came when those before them were over."""
        self._room = state["queue_free"] * runs.MOST_BYTES
        self._lines_done = state["lines_done"]
        yield from self.begin()

    def stream(self, pixel_s: float) -> Steps:
        """Queue what is left as the queue gets empty, and what follows; it never ends by itself."""
        while True:
            if self._upload.done:
                yield _MOST_PAUSE_S
                continue
            room = self.board.room(self.axis)[0]
            yield 0.0
            while room and not self._upload.done:
                sent = self._upload.push_into(room)
                if not sent:
                    break
                room -= sent
                yield 0.0
            yield pause_s([self._upload], pixel_s, _MOST_PAUSE_S)


def require_idle(state: str, axis: int) -> None:
    """Raise BoardError for an axis with a line of another program's."""
    if state in ("loaded", "armed", "running"):
        raise BoardError(
            f"axis {axis} is {state}: another program has a line there; let it end, or stop it"
        )


def lines_since(now: int, before: int) -> int:
    """Return how many lines were finished between two readings of lines_done."""
    return (now - before) & 0xFFFF
