# SPDX-License-Identifier: MIT
"""The way of lines into the queues of axes.

A block whose reply was lost is repeated as it was (the board drops the copy); a line longer than
the queue is streamed: call `LineUpload.push`, or `feed` for several axes, again while it runs.

Boards since map 4 take blocks of packed entries, of a byte or little more for each pixel with a
count of its own; an older board takes runs of 4 bytes.
"""

from collections.abc import Iterable

from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BUSY, BoardError
from pixstep.lines import runs
from pixstep.lines.line import Line
from pixstep.lines.runs import queue_entries

_ILLEGAL_VALUE = 3
_HEAD = 2  # entries in front of a line's pixels, which are in full
_WORTH = 48  # bytes: for less room a block is not worth its request, unless it ends the line
_PAUSE = 0.3  # of the time in which a full queue runs dry, between two calls of feed()


class LineUpload:
    """The blocks of one line on their way into an axis' queue.

    `state` is what `Device.axis` says of it, if that has just been asked.
    """

    def __init__(
        self,
        board: Device,
        axis: int,
        entries: list[tuple[int, int]],
        state: dict[str, int] | None = None,
    ) -> None:
        self.board, self.axis = board, axis
        self._packed = board.packs()
        self._left: list[bytes] = []
        self._count = self._bytes = self._pixels = 0  # of the entries so far
        self._last = 0  # count of the newest one
        self._add(entries)
        state = state or board.axis(axis)
        self._block = self._first = state["next_block"]
        # Bytes that surely fit, a run being 4; None: to be asked for again.
        self._queue_bytes = state["queue_free"] * runs.MOST_BYTES
        self._free: int | None = self._queue_bytes
        self._open = 0  # entries of a block that may have been taken: its answer never came
        self.last: tuple[int, list[bytes]] | None = None

    @property
    def block(self) -> int:
        """Number of the block that is sent next."""
        return self._block

    @property
    def begun(self) -> bool:
        """True when the board has a part of the line."""
        return self._block != self._first

    @property
    def done(self) -> bool:
        """True when every entry has been accepted."""
        return not self._left

    @property
    def queued_pixels(self) -> float:
        """Pixels of this line that a full queue holds, by its entries so far."""
        return self._queue_bytes * self._pixels / max(1, self._bytes)

    def push(self) -> int:
        """Send blocks until all are accepted or one filled the queue; return entries accepted.

        What the board takes out of the queue meanwhile waits for the next call: fast pixels would
        otherwise keep this one busy to the end of the line. Raises LineRefusedByBoardError if the
        board refuses the line, NoReplyError if it does not answer: call again to go on.
        """
        before = len(self._left)
        room: int | None = None
        while self._left:
            repeats = bool(self._open)
            if room is None and not repeats:
                room = self._room()
            left, sent = self._step(room or 0)
            if not sent and self._open:  # the block before it goes first
                continue
            if not sent or not (left or repeats):
                break
            room = None if repeats else left
        return before - len(self._left)

    def push_into(self, room: int) -> int:
        """Send one block into a queue with so many free bytes; return the bytes sent.

        Nothing is sent for little room, unless it is enough for the rest of the line.
        """
        little = room < _WORTH and room < sum(map(len, self._left[:_WORTH]))
        if self.done or (little and not self._open):
            return 0
        self._free = None
        left, sent = self._step(room)
        return room - left if sent else 0

    def require_taken(self) -> None:
        """Send the last block again unless the board says that it has it, once all are accepted."""
        while self.done and self._is_behind(self.board.axis(self.axis)):
            self._go_back()
            self.push()

    def repeat_last(self) -> None:
        """Send the last block again, as a host does that lost the reply."""
        if self.last:
            self._write(*self.last)

    def _add(self, entries: Iterable[tuple[int, int]]) -> None:
        """Append entries, as they go to the board."""
        for entry in entries:
            data = self._encoded(entry) if self._packed else _run(entry)
            self._left.append(data)
            self._pixels += entry[1] if self._count >= _HEAD else 0
            self._bytes += len(data)
            self._count += 1

    def _encoded(self, entry: tuple[int, int]) -> bytes:
        data, self._last = runs.pack(entry, self._last if self._count >= _HEAD else None)
        return data

    def _step(self, room: int) -> tuple[int, bool]:
        """Send one block of what fits the room; return the room left, and whether it was taken."""
        # The same block with the same entries, or the board would drop others as a copy.
        size = self._open or self._fitting(room)
        if size == 0 or not self._send(self._left[:size]):
            return 0, False
        used = sum(map(len, self._left[:size]))
        del self._left[:size]
        fits = bool(self._left) and len(self._left[0]) <= room - used
        return (room - used if fits else 0), True

    def _fitting(self, room: int) -> int:
        """Return how many of the next entries fit the room, and a block."""
        most = regs.MAX_PACKED if self._packed else regs.MAX_ENTRIES * runs.MOST_BYTES
        room = min(room, most)
        count = 0
        for data in self._left:
            room -= len(data)
            if room < 0:
                break
            count += 1
        return count

    def _room(self) -> int:
        """Return the free bytes of the queue, as last known or asked for."""
        known, self._free = self._free, None
        if known is not None:
            return known
        if self._packed:
            return self.board.room(self.axis)[0]
        return self.board.axis(self.axis)["queue_free"] * runs.MOST_BYTES

    def _write(self, block: int, entries: list[bytes]) -> None:
        data = b"".join(entries)
        if self._packed:
            self.board.write_packed(self.axis, block, data)
        else:
            self.board.write_block(self.axis, block, [_words(entry) for entry in entries])

    def _send(self, entries: list[bytes]) -> bool:
        """Send one block; False if the board is busy (queue full).

        A request that was spoilt on its way and passes the checksum all the same (one in 65,536)
        is answered with an exception: what the board then says of its queue decides.
        """
        self._open, block = len(entries), self._block
        for last in (False, False, True):
            try:
                self._write(block, entries)
                break
            except BoardError as error:
                if error.code is None:
                    raise
                if error.code == BUSY:
                    self._open = 0
                    return False
                if self._taken_all_the_same(error, last):
                    break
                if self._block != block:
                    return False
        self._open = 0
        self.last = (self._block, entries)
        self._block = (self._block + 1) & 0xFFFF
        return True

    def _taken_all_the_same(self, error: BoardError, last: bool) -> bool:
        """Whether the board has a block that it answered with an exception; False: to be repeated.

        Raises what is really wrong: a refused line, a fault, or the exception itself.
        """
        state = self.board.axis(self.axis)
        name = regs.axis_state(state["axis_state"])
        if error.code == _ILLEGAL_VALUE and name == "refused":
            raise self.board.refusal(self.axis) from None
        if name == "fault":
            raise BoardError(
                f"board {self.board.unit}: axis {self.axis} takes no line: "
                f"{self.board.fault_advice()}"
            ) from None
        if state["next_block"] == (self._block + 1) & 0xFFFF:
            return True
        if self._is_behind(state):
            self._go_back()
            return False
        if self._block and state["next_block"] != self._block:
            self.board.require_no_reset(self.axis)
        if last and error.code == _ILLEGAL_VALUE and state["line_error"]:
            # A line that moves already is not in state refused: its axis runs dry.
            raise self.board.refusal(self.axis) from None
        if last or error.code != _ILLEGAL_VALUE or state["next_block"] != self._block:
            raise error
        return False

    def _is_behind(self, state: dict[str, int]) -> bool:
        """Whether a board lacks the last block: its reply was that to another one, which came late.

        Nothing but a reset takes the number of the next block back to 0, unless all of this line
        is in block 0.
        """
        block = (self._block - 1) & 0xFFFF
        lacks = self.last is not None and state["next_block"] == block
        return lacks and (block != 0 or self._first == 0)

    def _go_back(self) -> None:
        """Let the last block be sent again, as it was."""
        if self.last:
            self._block, entries = self.last
            self._left[:0] = entries
            self._open, self.last = len(entries), None


def begin(board: Device, lines: dict[int, Line], divider: int | None = None) -> list[LineUpload]:
    """Queue lines by axis, or as much of them as the queues hold; return what may be left.

    `divider` is how many clock edges a pixel has, if the lines are to say it. Call it where a
    signal stops the axes, or a part of a line stays in a queue. Raises
    LineRefusedByBoardError, and BoardError for an axis that will not load.
    """
    require_whole(board, list(lines))
    forget_refused(board, lines)
    uploads = []
    said = said_divider(board, divider)
    for axis, line in lines.items():
        upload = LineUpload(board, axis, queue_entries(line, said))
        upload.push()
        upload.require_taken()
        uploads.append(upload)
    return uploads


def said_divider(board: Device, divider: int | None) -> int | None:
    """Return the divider as lines say it; None for a board that has only the setting."""
    return divider if divider is not None and board.has("line_divider") else None


def require_whole(board: Device, axes: Iterable[int]) -> None:
    """Raise BoardError for the first axis with a part of a line, whose host was ended there."""
    for axis in axes:
        if regs.axis_state(board.axis(axis)["axis_state"]) == "loading":
            raise BoardError(
                f"board {board.unit}: axis {axis} has a part of a line queued, whose upload was "
                f"broken off: `pixstep board disarm --axis {axis}` discards it"
            )


def forget_refused(board: Device, axes: Iterable[int]) -> None:
    """Discard lines that the board has refused: until then it answers others as it did those."""
    for axis in axes:
        if regs.axis_state(board.axis(axis)["axis_state"]) == "refused":
            board.command("disarm", [axis])


def require_idle(board: Device, axes: Iterable[int]) -> None:
    """Raise BoardError for the first axis that has a line already: that one would be made first.

    For what queues a line and runs it at once.
    """
    axes = list(axes)
    require_whole(board, axes)
    forget_refused(board, axes)
    for axis in axes:
        state = regs.axis_state(board.axis(axis)["axis_state"])
        if state == "loaded":
            raise BoardError(
                f"board {board.unit}: axis {axis} has a line loaded, which would be made first: "
                f"`pixstep board start` starts it, `pixstep board disarm --unit {board.unit} "
                f"--axis {axis}` discards it"
            )
        if state in regs.MOVING_STATES:
            raise BoardError(
                f"board {board.unit}: axis {axis} is {state}: let it end, or stop it "
                f"(`pixstep board stop`)"
            )


def room(board: Device, axis: int, line: Line, divider: int | None = None) -> tuple[int, int]:
    """Return the queue entries that a line takes, and those that are free."""
    state = board.axis(axis)
    if not state["queue_free"]:
        raise BoardError(
            f"board {board.unit}: the queue of axis {axis} is full (`pixstep board disarm` forgets "
            f"what is in it)"
        )
    return len(queue_entries(line, said_divider(board, divider))), state["queue_free"]


def feed(uploads: Iterable[LineUpload]) -> int:
    """Fill the queues of axes of one board from lines that are longer; return the blocks sent.

    The queue with the most room is served first, block by block, until none is worth a block more.
    One short request asks for the room of all axes, so that several lines of kilohertz pixels share
    the bus fairly.
    """
    open_ones = {item.axis: item for item in uploads if not item.done}
    if not open_ones:
        return 0
    board = next(iter(open_ones.values())).board
    if not board.packs():
        return sum(bool(item.push()) for item in open_ones.values())
    found = board.room(count=max(open_ones) + 1)
    room = {axis: found[axis] for axis in open_ones}
    blocks = 0
    while room:
        axis = max(room, key=lambda item: room[item])
        sent = open_ones[axis].push_into(room[axis])
        blocks += bool(sent)
        room[axis] -= sent
        if not sent:
            del room[axis]
    return blocks


def pause_s(uploads: Iterable[LineUpload], pixel_s: float, most_s: float) -> float:
    """Return the seconds that may pass until `feed` is called again, `most_s` at most.

    A kilohertz line with a count of its own in each pixel empties a small queue in less.
    """
    open_ones = [item for item in uploads if not item.done]
    return min([most_s, *(_PAUSE * item.queued_pixels * pixel_s for item in open_ones)])


def _run(entry: tuple[int, int]) -> bytes:
    return b"".join((word & 0xFFFF).to_bytes(2) for word in entry)


def _words(data: bytes) -> tuple[int, int]:
    return runs.signed(int.from_bytes(data[:2]), 16), int.from_bytes(data[2:])
