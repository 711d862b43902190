# SPDX-License-Identifier: MIT
"""A serial port: opened with errors that say what to do, and without resetting the board again.

The boards' USB chips reset the processor when a port is opened that was closed with HUPCL set, the
default. Opening clears it, so that only the first opening after plugging in resets the board.

Threads have a bus by `Turns`. A request and its reply belong together, so a thread has the bus for
a whole request, or for as many as must not be separated. A motion's own thread can be interrupted
there: between two requests no reply is on its way, and nothing was said by half.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from pixstep.errors import AskedText, UserError

_URGENT, _FEEDS, _ASKS = range(3)


class InterruptedBusError(BaseException):
    """This thread is to end what it does on the bus. No `except Exception` may swallow it."""


class Turns:
    """Threads that share a bus, by rank and order of asking; `with turns:` may be nested."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._owner: int | None = None
        self._depth = 0
        self._waiting: list[tuple[int, int]] = []  # rank and number, the lowest is next
        self._numbers = itertools.count()
        self._favoured: set[int] = set()
        self._interrupted: set[int] = set()

    def __enter__(self) -> Self:
        self._take(urgent=False)
        return self

    def __exit__(self, *_: object) -> None:
        self._give_back()

    @contextlib.contextmanager
    def taken(self, *, urgent: bool) -> Iterator[None]:
        """Have the bus; an urgent turn comes before all that wait for one."""
        self._take(urgent=urgent)
        try:
            yield
        finally:
            self._give_back()

    @contextlib.contextmanager
    def favoured(self) -> Iterator[None]:
        """Let this thread's turns come before those of others that are not urgent."""
        me = threading.get_ident()
        self._favoured.add(me)
        try:
            yield
        finally:
            self._favoured.discard(me)

    @property
    def mine(self) -> bool:
        """True if this thread has the bus."""
        return self._owner == threading.get_ident()

    def interrupt(self, thread: int) -> None:
        """Let InterruptedBusError end a thread when it asks for the bus the next time."""
        with self._changed:
            self._interrupted.add(thread)
            self._changed.notify_all()

    def forget(self, thread: int) -> None:
        """Take an interruption back that has not come, as of a thread that has ended."""
        with self._changed:
            self._interrupted.discard(thread)

    def raise_if_interrupted(self) -> None:
        """Raise InterruptedBusError, once, if this thread is to end."""
        me = threading.get_ident()
        if me in self._interrupted and not self.mine:
            self._interrupted.discard(me)
            raise InterruptedBusError

    def _take(self, *, urgent: bool) -> None:
        me = threading.get_ident()
        with self._changed:
            if self._owner != me:
                self.raise_if_interrupted()
                self._wait(urgent=urgent)
                self._owner = me
            self._depth += 1

    def _wait(self, *, urgent: bool) -> None:
        """Wait until nobody has the bus and this thread is the next one."""
        rank = _URGENT if urgent else _FEEDS if threading.get_ident() in self._favoured else _ASKS
        ticket = (rank, next(self._numbers))
        self._waiting.append(ticket)
        try:
            while self._owner is not None or min(self._waiting) != ticket:
                self._changed.wait()
                self.raise_if_interrupted()
        finally:
            self._waiting.remove(ticket)
            self._changed.notify_all()

    def _give_back(self) -> None:
        with self._changed:
            self._depth -= 1
            if not self._depth:
                self._owner = None
                self._changed.notify_all()


if TYPE_CHECKING:
    import serial

try:
    import termios
except ImportError:  # Windows
    termios = None  # type: ignore[assignment]

PARITIES = {"E": 2, "N": 0, "O": 1}  # by letter, the likeliest first: the value of the setting
BAUD, PARITY, NO_PARITY = 115_200, "E", "N"  # a board's own; that of a pseudo terminal
LEAST_BAUD, MOST_BAUD = 300, 4_000_000
LAST_UNIT = 247  # the highest Modbus address
TIMEOUT_S = 0.5
TIMEOUTS_S = (0.01, 60)  # the shortest that may be chosen, and the longest
RETRIES = 3
BOOT_S = 2.0  # of the boot loader, before it starts the firmware
_CFLAG = 2
_PTYS = ("/dev/pts/", "/dev/ttys")  # Linux, macOS

_BESIDE = getattr(os, "O_NOCTTY", 0) | getattr(os, "O_NONBLOCK", 0)
_BESIDE_TIMES, _BESIDE_S = 5, 0.03


class PortBusyError(UserError):
    """Another program has the port open."""


# What a port raises that went away, or cannot do what it was asked for.
TROUBLE: tuple[type[Exception], ...] = (OSError, ValueError, *((termios.error,) if termios else ()))


@dataclass(frozen=True)
class Port:
    """What a port is opened with; without a parity bit there are two stop bits.

    If no parity is chosen, it is even, and none on a pseudo terminal. If no time to wait for
    replies is chosen, it is TIMEOUT_S.
    """

    name: str
    baud: int = BAUD
    parity: str | None = None
    timeout_s: float | None = None

    @property
    def real_parity(self) -> str:
        """The parity to open the port with."""
        return self.parity or (NO_PARITY if is_pty(self.name) else PARITY)

    @property
    def stop_bits(self) -> int:
        """Stop bits of a character of 11 bits."""
        return 2 if self.real_parity == NO_PARITY else 1

    @property
    def text(self) -> str:
        """Name, rate and frame, for messages."""
        return f"{self.name} ({self.baud} baud, 8{self.real_parity}{self.stop_bits})"

    def at(self, baud: int, parity: str) -> Port:
        """Return the port at another rate and parity."""
        return replace(self, baud=baud, parity=parity)

    def open(self, timeout_s: float) -> tuple[serial.Serial, bool]:
        """Open it for this process alone.

        Raises UserError naming the port and why: it is missing, not allowed, in use, or cannot
        have this rate or parity. With the port comes whether the opening has reset a board that
        resets on opening.
        """
        parity = self.real_parity
        if is_pty(self.name) and parity != NO_PARITY:  # the system takes it now and then
            raise UserError(AskedText(
                "{name}: a pseudo terminal has no parity {letter}: {parity} N",
                name=self.name, letter=parity,
            ))  # fmt: skip
        import serial  # takes its time to load, which help need not wait for

        opened = None
        try:
            opened = serial.Serial(
                self.name,
                baudrate=self.baud,
                parity=parity,
                stopbits=self.stop_bits,
                timeout=timeout_s,
                write_timeout=timeout_s,
                exclusive=True,
            )
            has_reset = _hold_dtr(opened) and not is_pty(self.name)
        except TROUBLE as error:
            if opened:
                opened.close()
            kind = PortBusyError if _is_busy(error) else UserError
            raise kind(f"{self.name}: {self._reason(error)}") from None
        return opened, has_reset

    def require(self) -> None:
        """Raise UserError, as `open` does, if the port cannot be opened."""
        self.open(self.timeout_s or TIMEOUT_S)[0].close()

    def send_beside(self, frames: bytes) -> None:
        """Send frames to which nobody replies on a port that another program has open.

        They go out between that program's own, several times, since a board does not hear what
        comes while it replies. Raises UserError if the port cannot be written to.
        """
        try:
            opened = os.open(self.name, os.O_WRONLY | _BESIDE)
            try:
                for _ in range(_BESIDE_TIMES):
                    os.write(opened, frames)
                    time.sleep(_BESIDE_S)
            finally:
                os.close(opened)
        except OSError as error:
            raise UserError(f"{self.name}: {self._reason(error)}") from None

    def _reason(self, error: Exception) -> str:
        """Return in words why the port cannot be opened."""
        code = _code(error) or _code(error.__context__)
        if code == errno.ENOENT:
            return (
                "there is no such port: is the board plugged in? (`ls /dev/ttyACM* /dev/ttyUSB*`)"
            )
        if code == errno.EACCES and not Path(self.name).is_file():
            return "not allowed: add yourself to the group dialout (`sudo adduser $USER dialout`)"
        if _is_busy(error):
            return (
                "in use by another program, and a port has one user at a time: if that is a "
                "command of pixstep, Ctrl-C there stops what it moves, and so does `pixstep board "
                "stop` beside it"
            )
        if code in (errno.EACCES, errno.ENOTTY, errno.ENXIO, errno.EIO):
            return "not a serial port"
        if code == errno.EINVAL or isinstance(error, ValueError):
            return f"cannot do {self.baud} baud with parity {self.real_parity}"
        return os.strerror(code) if code else str(error)


def _code(error: BaseException | None) -> int | None:
    """Return the system's number of an error; a terminal's own errors have it as argument."""
    code = getattr(error, "errno", None)
    if termios and isinstance(error, termios.error):
        code = error.args[0]
    return code if isinstance(code, int) else None


def _is_busy(error: Exception) -> bool:
    """True if a port cannot be opened because another program has it."""
    code = _code(error) or _code(error.__context__)
    return code in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error)


def is_pty(name: str) -> bool:
    """True for a pseudo terminal, such as the simulator's."""
    return os.path.realpath(name).startswith(_PTYS)


def _hold_dtr(opened: serial.Serial) -> bool:
    """Keep DTR when the port is closed; return whether it was not kept before.

    Windows always drops it.
    """
    if not termios:
        return True
    flags = termios.tcgetattr(opened.fileno())
    was_dropped = bool(flags[_CFLAG] & termios.HUPCL)
    flags[_CFLAG] &= ~termios.HUPCL
    termios.tcsetattr(opened.fileno(), termios.TCSANOW, flags)
    return was_dropped
