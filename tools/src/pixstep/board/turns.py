# SPDX-License-Identifier: MIT
"""Who has the bus: threads ask one after the other, a stop goes first, what feeds a line next.

A request and its reply belong together, so a thread has the bus for a whole request, or for as many
as must not be separated. A motion's own thread can be interrupted there: between two requests no
reply is on its way, and nothing was said by half.
"""

import contextlib
import itertools
import threading
from collections.abc import Iterator
from typing import Self

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
