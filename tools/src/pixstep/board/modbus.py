# SPDX-License-Identifier: MIT
"""The master of a bus with boards: each reply belongs to its request, or it is dropped.

A Modbus reply to a read does not say which registers it is of, so a late one looks like the reply
to the next read. The master therefore keeps account of what may still come:

* While a request waits, bytes before its reply are skipped, and a request without a readable reply
  is repeated as it was: the reply to any of them will do. An exception will not, since another of
  them may have been carried out: the request is sent once more when the line is clear.
* After a request that was repeated, or had no reply, the line has to be quiet for a time-out
  before another request goes out.
* A *fence* follows: a short read of a length that no other request of late has had. Its reply comes
  after all that was on its way, which is dropped. A request whose reply would look like that of
  another one of late goes out after a fence too, for replies that come twice.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import select
import struct
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Protocol

from pixstep.board import rtu
from pixstep.board.port import NO_PARITY, RETRIES, TIMEOUT_S, TROUBLE, Port, Turns, is_pty
from pixstep.board.rtu import Reply, RtuRequest

if TYPE_CHECKING:
    import serial

MOST_WORDS = 125  # of one read, by Modbus
REPLY_S = 0.025  # how long a simulated master waits for the first byte
_POLL_S = 0.005  # the longest wait of one read of a port where it cannot be waited for else
_QUIET_S = 0.03  # without a byte: the reply on its way has ended
_QUIET_LIMIT_S = 0.3
_GAP_S = 0.1  # a reply that has begun may pause so long, also past its time-out
_CHARACTER_BITS = 11
_SILENCE_S = 0.002  # in front of a request: what comes right behind a reply is heard in it
_FENCE_WORDS = range(1, 17)  # of the head of the map, which every board has
_FENCE_TRIES = 3
_LATE = 2  # time-outs: a reply that comes twice has come by then
_LATER = 1.5  # time-outs from a request to the end of the quiet after it, at least
_KEPT_BYTES = 1024  # of what was heard without a reply in it
_BABBLE = 10  # time-outs in which the line does not become quiet: it never will


class RequestError(Exception):
    """A request had no reply that could be read."""


class LineGoneError(Exception):
    """The port went away."""


class WriteTimeoutError(LineGoneError):
    """The port is there and takes no bytes."""


class Client:
    """What requests go through. `place` is the bus's name for messages.

    `heard` is how many bytes came back for the last request, at most for one of its repetitions.
    `most_words` is how many registers one read may ask for: a bus that is shared wants short ones.
    `more_follows` says that another request follows at once, for which others should wait.
    """

    place = ""
    most_words = MOST_WORDS
    more_follows = False

    def __init__(self, timeout_s: float, retries: int) -> None:
        # How long a reply may take, seconds, and how often a request without one is repeated.
        self.patience = (timeout_s, retries)
        self.heard = 0
        self.turns = Turns()  # of the threads that ask

    def ask(self, unit: int, pdu: bytes, *, urgent: bool = False) -> Reply:
        """Send a request, again if need be, and return its reply; raises RequestError for none.

        An urgent one goes out at once, whatever may still be on its way. Its reply counts only if
        it cannot be another one's.
        """
        raise NotImplementedError

    def tell(self, pdu: bytes, unit: int = 0) -> None:
        """Send a request to which nobody replies, at once: to all units if no other is given."""
        raise NotImplementedError

    def close(self) -> None:
        """Give the bus back."""

    def settle(self) -> None:
        """Wait until a request that was broken off is over: nothing to wait for here."""

    def reconfigure(self, baud: int, parity: str) -> None:
        """Go on at another rate and parity: nothing to change here."""

    def follow(self, baud: int, parity: str) -> None:
        """Go on as a board's new settings say."""
        self.reconfigure(baud, parity)

    @contextlib.contextmanager
    def patient(self, timeout_s: float | None = None, retries: int | None = None) -> Iterator[None]:
        """Let the client have another patience, as long as this lasts."""
        before = self.patience
        self.patience = (
            before[0] if timeout_s is None else timeout_s,
            before[1] if retries is None else retries,
        )
        try:
            yield
        finally:
            self.patience = before


class Master(Client):
    """The account of replies that may still come, on any line that takes and brings bytes."""

    def __init__(self, timeout_s: float, retries: int) -> None:
        super().__init__(timeout_s, retries)
        self._asked_s = self._heard_s = 0.0  # when the last request went out, the last reply came
        self._spare = b""  # bytes behind the last reply
        self._doubts: set[int] = set()  # units of which a reply may still come
        self._loud = False  # the line has to be quiet before another request goes out
        self._under_way = False  # a request has begun, and is not over unless it was broken off
        self._late: dict[tuple[int, bytes], tuple[float, bytes]] = {}  # replies of late: when, PDU
        self._fences = itertools.cycle(_FENCE_WORDS)

    def connect(self) -> None:
        """Make the line ready, if it is not."""

    def write(self, frame: bytes) -> None:
        """Send bytes."""
        raise NotImplementedError

    def read(self, wait_s: float) -> bytes:
        """Return the bytes that have come; if there are none, wait for some, at most so long."""
        raise NotImplementedError

    def now_s(self) -> float:
        """Return seconds since any fixed instant."""
        return time.monotonic()

    def lasts_s(self, count: int) -> float:
        """Return how long so many bytes take on the line."""
        del count
        return 0.0

    def ask(self, unit: int, pdu: bytes, *, urgent: bool = False) -> Reply:
        """Send a request, again if need be, and return its reply."""
        request = RtuRequest(unit, pdu)
        self.heard = 0
        self.connect()
        self._under_way = True
        self._drop_spare(0 if urgent else _SILENCE_S)
        doubted = unit in self._doubts or self._is_like_another(request)
        if not urgent:
            self._clear_up(request)
        try:
            reply = self._ask(request)
            while reply.exception is not None and unit in self._doubts and not urgent:
                # One of the repetitions may have been taken: only the reply to a last one tells.
                self._clear_up(request)
                reply = self._ask(request)
        except WriteTimeoutError:  # it has not gone out
            raise
        except BaseException:
            self._doubts.add(unit)
            raise
        if urgent and doubted:
            self._doubts.add(unit)
            raise RequestError
        self._under_way = False
        return reply

    def tell(self, pdu: bytes, unit: int = 0) -> None:
        """Send a request to which nobody replies."""
        self._forget_what_is()
        self._under_way = True
        self.write(RtuRequest(unit, pdu).frame)
        self._under_way = False

    def forget(self) -> None:
        """Expect nothing more of what was asked so far: at another rate it cannot be read."""
        self._doubts.clear()
        self._late.clear()
        self._spare, self._loud = b"", False

    def _forget_what_is(self) -> None:
        """Take what was read before for old: another request may change it."""
        self._late = {key: (when, b"") for key, (when, _) in self._late.items()}

    def _ask(self, request: RtuRequest) -> Reply:
        """Send a request until its reply comes."""
        for repetition in range(self.patience[1] + 1):
            if repetition:
                self._doubts.add(request.unit)
                self._loud = True
            reply = self._attempt(request)
            if reply:
                self._note(request, reply)
                return reply
        raise RequestError

    def _attempt(self, request: RtuRequest) -> Reply | None:
        """Send a request once and return its reply, None if none comes that can be read."""
        frame = request.frame
        self.write(frame)
        self._asked_s = self.now_s()
        end_s = self._asked_s + self.patience[0] + self.lasts_s(len(frame))
        last_s = end_s + max(self.patience[0], _GAP_S)
        heard, count = b"", 0
        while (left_s := end_s - self.now_s()) > 0:
            data = self.read(left_s)
            if not data:
                continue
            count += len(data)
            self.heard = max(self.heard, count)
            heard = (heard + data)[-_KEPT_BYTES:]
            reply = request.reply(heard)
            if reply:
                self._spare, self._heard_s = heard[reply.end :], self.now_s()
                return reply
            end_s = min(last_s, max(end_s, self.now_s() + _GAP_S))
        return None

    def _note(self, request: RtuRequest, reply: Reply) -> None:
        """Keep what the reply looks like: should it come twice, no other request may take it."""
        now_s = self.now_s()
        if _changes(request):
            self._forget_what_is()
        looks = request.shape if reply.exception is None else reply.pdu[:1]
        self._late[request.unit, looks] = (now_s, request.pdu)

    def _is_like_another(self, request: RtuRequest) -> bool:
        """True if the reply of another request of late would be taken for that of this one."""
        begin_s = self.now_s() - _LATE * self.patience[0]
        self._late = {key: item for key, item in self._late.items() if item[0] >= begin_s}
        if _is_block(request):  # a false reply shows: blocks have numbers
            return False
        found = self._late.get((request.unit, request.shape))
        refused = (request.unit, bytes([request.function | rtu.EXCEPTION])) in self._late
        same = not _changes(request) and found is not None and request.pdu == found[1]
        return refused or (found is not None and not same)

    def _clear_up(self, request: RtuRequest) -> None:
        """Let what may still come pass, so that the next reply is that to this request."""
        doubted = request.unit in self._doubts
        if doubted or self._loud:
            self._quiet(self.patience[0])
        if doubted or self._is_like_another(request):
            self._fence(request)

    def _quiet(self, seconds: float) -> None:
        """Drop all that comes until the line has been quiet for so long.

        What was repeated last has more time than that, for lines that do not keep the order. Raises
        RequestError if it never is.
        """
        end_s = self.now_s() + _BABBLE * seconds
        least_s = self._asked_s + _LATER * seconds - self.now_s()
        while data := self.read_for(max(seconds, least_s)):
            least_s = self._asked_s + _LATER * seconds - self.now_s()
            self.heard = max(self.heard, len(data))
            if self.now_s() > end_s:
                raise RequestError
        self._loud = False

    def read_for(self, seconds: float) -> bytes:
        """Return the next bytes that come in a time; none if none do."""
        end_s = self.now_s() + seconds
        while (left_s := end_s - self.now_s()) > 0:
            data = self.read(left_s)
            if data:
                return data
        return b""

    def _fence(self, request: RtuRequest) -> None:
        """Ask a unit what no request of late has asked, and not the next one; drop all before."""
        unit = request.unit
        for _ in range(min(self.patience[1] + 1, _FENCE_TRIES)):
            fence = self._new_fence(request)
            reply = self._attempt(fence)
            if reply:
                self._doubts.discard(unit)
                self._late = {key: item for key, item in self._late.items() if key[0] != unit}
                self._note(fence, reply)
                self._drop_spare(_SILENCE_S)
                return
            self._doubts.add(unit)
            self._quiet(self.patience[0])
        raise RequestError

    def _new_fence(self, request: RtuRequest) -> RtuRequest:
        """Return a fence that looks like no reply of late, and not like that to a request."""
        unit = request.unit
        for words in itertools.islice(self._fences, len(_FENCE_WORDS)):
            fence = RtuRequest(unit, struct.pack(">BHH", rtu.READ_INPUTS, 0, words))
            if fence.shape != request.shape and (unit, fence.shape) not in self._late:
                break
        return fence

    def _drop_spare(self, silence_s: float) -> None:
        """Drop what has come behind the last reply; a whole frame there means that more may."""
        spare, self._spare = self._spare, b""
        left_s = self._heard_s + silence_s - self.now_s()
        while len(spare) < _KEPT_BYTES and (data := self.read_for(left_s) or self.read(0)):
            spare += data
            left_s = silence_s
        if spare and rtu.frame_in(spare):
            self._doubts.update(unit for unit, _ in self._late)
            self._loud = True


def _changes(request: RtuRequest) -> bool:
    """True if a request writes what readings depend on."""
    if request.function == rtu.WRITE:
        return not _is_block(request)
    return request.function in (
        rtu.WRITE_COIL, rtu.WRITE_ONE, rtu.WRITE_COILS, rtu.MASK_WRITE, rtu.WRITE_AND_READ,
    )  # fmt: skip


def _is_block(request: RtuRequest) -> bool:
    """True for a block to the queue window, which the board numbers."""
    return request.pdu[:3] == bytes([rtu.WRITE, 0x10, 0x00])


class SerialClient(Master):
    """The master of a serial port."""

    def __init__(self, port: Port, *, retries: int = RETRIES) -> None:
        super().__init__(port.timeout_s or TIMEOUT_S, retries)
        self.port = port
        self.place = port.text
        self.socket: serial.Serial | None = None

    def connect(self) -> None:
        """Open the port unless it is open; raises UserError saying why it cannot be."""
        self.connect_reset()

    def connect_reset(self) -> bool:
        """Open the port unless it is open; return whether that has reset a board."""
        if self.socket is not None:
            return False
        self.socket, has_reset = self.port.open(self.patience[0])
        self.socket.timeout = _POLL_S
        return has_reset

    def close(self) -> None:
        """Give the port back."""
        if self.socket:
            self.socket.close()
        self.socket = None

    def lasts_s(self, count: int) -> float:
        """Return how long so many bytes take on the line."""
        return count * _CHARACTER_BITS / self.port.baud

    def write(self, frame: bytes) -> None:
        """Send bytes; raises LineGoneError if the port takes none."""
        import serial

        self.connect()
        assert self.socket is not None
        try:
            self.socket.write(frame)
        except serial.SerialTimeoutException:
            raise WriteTimeoutError from None
        except TROUBLE:
            self._lose()

    def read(self, wait_s: float) -> bytes:
        """Return the bytes that have come; if there are none, wait for some for a little."""
        if self.socket is None:
            return b""
        try:
            waiting = self.socket.in_waiting
            if not waiting and not self._comes(wait_s):
                return b""
            return bytes(self.socket.read(max(1, waiting)))
        except TROUBLE:
            self._lose()
            return b""

    def _comes(self, wait_s: float) -> bool:
        """Wait for a byte, at most so long; False if none comes, or if that cannot be told."""
        if wait_s <= 0 or self.socket is None:
            return False
        if os.name != "posix":  # a read waits itself, for the port's own time
            return True
        return bool(select.select([self.socket.fileno()], [], [], wait_s)[0])

    def _lose(self) -> None:
        """Close a port that went away, so that a later request tries to open it again."""
        with contextlib.suppress(*TROUBLE):
            self.close()
        self.socket = None
        raise LineGoneError from None

    def settle(self) -> None:
        """Let the bytes on their way in both directions pass, and drop those that came.

        A request that was broken off leaves them; the next one would run into them. Behind one that
        is over there is nothing to wait for.
        """
        if self.socket is None or not self._under_way:
            return
        self._under_way = False
        with contextlib.suppress(*TROUBLE, LineGoneError):
            self.socket.flush()
            end_s = self.now_s() + _QUIET_LIMIT_S
            while self.read_for(_QUIET_S) and self.now_s() < end_s:
                pass

    def reconfigure(self, baud: int, parity: str) -> None:
        """Go on at another rate and parity."""
        self.port = self.port.at(baud, parity)
        self.place = self.port.text
        self.forget()
        self.close()
        self.connect()

    def follow(self, baud: int, parity: str) -> None:
        """Go on as a board's new settings say; a pseudo terminal has no parity to change."""
        self.reconfigure(baud, NO_PARITY if is_pty(self.port.name) else parity)


class Beside(Client):
    """A client that only tells, on a port that another program has open."""

    def __init__(self) -> None:
        super().__init__(TIMEOUT_S, 0)
        self.frames = b""

    def tell(self, pdu: bytes, unit: int = 0) -> None:
        """Keep the frame of a request to which nobody replies."""
        self.frames += RtuRequest(unit, pdu).frame


class Pipe(Protocol):
    """What a simulated bus can do."""

    def transmit(self, data: bytes, timeout_cycles: int | None = None) -> bytes:
        """Send a frame and return the reply, empty for none."""

    def cycles(self, seconds: float) -> int:
        """Return a time in cycles."""

    def command(self, text: str) -> str:
        """Give a command and return its answer."""


class SimClient(Client):
    """A Modbus RTU client whose bytes go through the simulator's control pipe.

    A request and its reply are one `tx` command, so that no reply can come late, simulated time
    advances by exactly what they take, and a run is deterministic.
    """

    def __init__(self, simulator: Pipe, *, retries: int = RETRIES) -> None:
        super().__init__(TIMEOUT_S, retries)
        self._simulator = simulator
        self.requests = 0
        self.lost = 0

    def follow(self, baud: int, parity: str) -> None:
        """Let the simulated bus go on as a board's new settings say."""
        self._simulator.command(f"baud {baud} {parity}")

    def ask(self, unit: int, pdu: bytes, *, urgent: bool = False) -> Reply:
        """Send a request, again if need be, and return its reply."""
        del urgent
        request = RtuRequest(unit, pdu)
        self.heard = 0
        for _ in range(self.patience[1] + 1):
            reply = request.reply(self._transmit(request.frame))
            if reply:
                return reply
        raise RequestError

    def tell(self, pdu: bytes, unit: int = 0) -> None:
        """Send a request to which nobody replies."""
        self._transmit(RtuRequest(unit, pdu).frame)

    def _transmit(self, frame: bytes) -> bytes:
        self.requests += 1
        reply = self._simulator.transmit(frame, self._simulator.cycles(REPLY_S))
        self.heard = max(self.heard, len(reply))
        self.lost += not reply
        return reply
