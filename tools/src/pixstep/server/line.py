# SPDX-License-Identifier: MIT
"""The serial line of a server: its master gives way to a stop, as early as the wire allows.

A transaction that is on the wire is let through: a board hears nothing while it replies. Where no
reply comes, the stop does not wait for the time-out, only for as long as a board may take to begin.
"""

import contextlib
import os
import select
import threading

from pixstep.board.modbus import SerialClient, WriteTimeoutError
from pixstep.board.port import Port
from pixstep.board.rtu import Reply, RtuRequest

_BEGIN_S = 0.008  # after a request: a board that replies has begun, also one with much to do
_PAUSE_S = 0.02  # in a reply: adapters pass bytes on in pieces, at most so far apart


class UnsentError(WriteTimeoutError):
    """A request gave way to a stop before it went out."""


class CutShortError(Exception):
    """A request gave way to a stop while it waited for a reply that did not come."""


class SharedLine(SerialClient):
    """The master of a port whose requests give way; `frames` counts what it has sent."""

    def __init__(self, port: Port) -> None:
        super().__init__(port)
        self._home = port
        self._doubt_s = 0.0  # the longest time that a lost request waited for its reply
        self.frames = 0
        self._lock = threading.Lock()
        self._wake, self._waker = os.pipe()
        os.set_blocking(self._waker, False)
        self._calls = 0  # stops that wait
        self._urgent = False  # so is the request that is being made
        self._waits = False  # its frame is out, and no reply has come
        self._free_s = 0.0  # until then a reply may begin, or go on

    def call(self) -> int:
        """Ask for the line on behalf of a stop; return how many frames were sent before."""
        with self._lock:
            self._calls += 1
            frames = self.frames
        with contextlib.suppress(BlockingIOError):  # it is awake
            os.write(self._waker, b"!")
        return frames

    def answered(self) -> None:
        """Note that a stop that has called gets the line."""
        with self._lock:
            self._calls -= 1

    def begin(self, *, urgent: bool) -> None:
        """Begin another request."""
        self._urgent, self._waits = urgent, False

    @property
    def waits(self) -> bool:
        """True if a frame of the present request is out and no reply has come."""
        return self._waits

    def doubt(self, unit: int) -> None:
        """Note that a reply of a unit may still come, for as long as its request waited."""
        self._doubts.add(unit)
        self._doubt_s = max(self._doubt_s, self.patience[0])

    def _quiet(self, seconds: float) -> None:
        """Drop all that comes until the line has been quiet for as long as lost requests waited.

        One client's short requests must not cost the others their longer time.
        """
        super()._quiet(min(seconds, self._doubt_s or seconds))
        self._doubt_s = 0.0

    def go_to(self, baud: int, parity: str, *, stays: bool) -> None:
        """Go on at another rate; it `stays` because a board was set so."""
        if stays:
            self.follow(baud, parity)
            self._home = self.port
        else:
            self.reconfigure(baud, parity)

    def go_home(self) -> None:
        """Go back to the boards' own rate."""
        self.reconfigure(self._home.baud, self._home.real_parity)

    def write(self, frame: bytes) -> None:
        """Send bytes; raises UnsentError if a stop wants the line."""
        with self._lock:
            if self._calls and not self._urgent:
                raise UnsentError
            self.frames += 1
        super().write(frame)
        self._waits = True
        self._free_s = self.now_s() + self.lasts_s(len(frame)) + _BEGIN_S

    def read(self, wait_s: float) -> bytes:
        """Return the bytes that have come; raises CutShortError or UnsentError for a stop."""
        if self._calls and (self._waits or not self._urgent):
            left_s = self._free_s - self.now_s()
            if left_s <= 0:
                raise CutShortError if self._waits else UnsentError
            wait_s = min(wait_s, left_s)
        data = super().read(wait_s)
        if data:
            self._free_s = self.now_s() + _PAUSE_S
        return data

    def _attempt(self, request: RtuRequest) -> Reply | None:
        """Send a request once; its reply leaves the line free."""
        reply = super()._attempt(request)
        if reply:
            self._waits, self._free_s = False, 0.0
        return reply

    def _comes(self, wait_s: float) -> bool:
        """Wait for a byte, or until a stop calls."""
        if wait_s <= 0 or self.socket is None:
            return False
        port = self.socket.fileno()
        waiting = [port] if self._calls else [port, self._wake]
        ready = select.select(waiting, [], [], wait_s)[0]
        if self._wake in ready:
            os.read(self._wake, 4096)
        return port in ready
