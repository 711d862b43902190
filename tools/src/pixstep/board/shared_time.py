# SPDX-License-Identifier: MIT
"""The boards' time as the threads of motions and their caller share it.

Time that passes by itself needs nothing but waits that can be ended. Time that passes only while
someone waits for it, as that of simulated boards, is lent to one thread at a time, always to the
one that has to wake first: the same calls then give the same motion, cycle by cycle.
"""

import sys
import threading
from typing import Protocol
from weakref import WeakKeyDictionary

from pixstep.board.link import Link, WallClock, World
from pixstep.board.port import Turns

_CHANGES_S = 0.0005
_SLICE_S = 0.2  # of a wait in which a signal may come: Windows lets none into a longer one


class SharedTime(World, Protocol):
    """The time of one motion: its thread waits in it, its caller lets it pass."""

    def enter(self) -> None:
        """Begin: the thread calls this first."""

    def leave(self) -> None:
        """End: the thread calls this last."""

    def wake(self) -> None:
        """End the thread's wait."""

    def advance(self) -> None:
        """Let a thread go on a little, if none does by itself."""

    def pass_until(self, event: threading.Event, seconds: float | None) -> bool:
        """Let time pass until something has happened; False if it has not in time."""

    async def pass_until_async(self, event: threading.Event, seconds: float | None) -> bool:
        """Do the same while other tasks go on."""


def of_link(link: Link) -> SharedTime:
    """Return the time of one motion on a bus."""
    turns = link.modbus.turns
    if isinstance(link.world, WallClock):
        return _Passing(turns)
    return _Lent(lender_of(link), turns)


class _Passing(WallClock):
    """Time that passes by itself."""

    def __init__(self, turns: Turns) -> None:
        self._turns, self._woken = turns, threading.Event()

    def wait(self, seconds: float) -> None:
        """Let time pass; an interrupted thread does not wait."""
        if self._woken.wait(seconds):
            self._woken.clear()
            self._turns.raise_if_interrupted()

    def enter(self) -> None:
        """Let Python change threads quickly."""
        _quick.begin()

    def leave(self) -> None:
        """Let it change as before."""
        _quick.end()

    def wake(self) -> None:
        """End the thread's wait."""
        self._woken.set()

    def advance(self) -> None:
        """Nothing to do."""

    def pass_until(self, event: threading.Event, seconds: float | None) -> bool:
        """Wait for something."""
        end_s = None if seconds is None else self.now_s() + seconds
        while not event.is_set():
            left_s = self._left_s(end_s)
            if left_s <= 0:
                return False
            event.wait(left_s)
        return True

    async def pass_until_async(self, event: threading.Event, seconds: float | None) -> bool:
        """Wait for something in a thread of the loop's."""
        import asyncio  # takes its time to load

        end_s = None if seconds is None else self.now_s() + seconds
        while not event.is_set():
            left_s = self._left_s(end_s)
            if left_s <= 0:
                return False
            await asyncio.to_thread(event.wait, left_s)
        return True

    def _left_s(self, end_s: float | None) -> float:
        return _SLICE_S if end_s is None else min(_SLICE_S, end_s - self.now_s())


class _QuickChanges:
    """How long a thread that computes keeps Python's lock from others, as long as motions last.

    A request takes the lock some ten times. Beside a program that computes without a pause it takes
    24 ms where Python changes threads every 5 ms, as it does by itself, 12 ms here, and 8 ms
    beside one that waits.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._motions, self._before_s = 0, 0.0

    def begin(self) -> None:
        """A motion begins."""
        with self._lock:
            if not self._motions:
                self._before_s = sys.getswitchinterval()
                sys.setswitchinterval(min(self._before_s, _CHANGES_S))
            self._motions += 1

    def end(self) -> None:
        """A motion ends."""
        with self._lock:
            self._motions -= 1
            if not self._motions:
                sys.setswitchinterval(self._before_s)


_quick = _QuickChanges()


class Lender:
    """Lends the time of a bus, which passes only when someone waits, to the threads of motions."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.changed = threading.Condition()
        self.running: _Lent | None = None
        self.waiting: list[_Lent] = []

    def advance(self, end_s: float | None = None) -> bool:
        """Let the thread that has to wake first go on until it waits again; False if none has to.

        `end_s` is how late it may have to wake. A motion's own thread has the time already.
        """
        me = threading.get_ident()
        if any(one.thread == me for one in self.waiting):
            return True
        with self.changed:
            self.changed.wait_for(self._is_back)  # of an advance that a signal has ended
            first = min(self.waiting, key=_wakes_s, default=None)
            if first is None or (end_s is not None and first.wakes_s > end_s):
                return False
            self._wait_until(first.wakes_s)
            self.running = first
            self.changed.notify_all()
            self.changed.wait_for(self._is_back)
        return True

    def pass_time(self, seconds: float) -> None:
        """Let time pass; motions go on meanwhile."""
        end_s = self.world.now_s() + seconds
        while self.advance(end_s):
            pass
        self._wait_until(end_s)

    def pass_until(self, event: threading.Event, seconds: float | None) -> bool:
        """Let time pass until something has happened; False if it has not in time."""
        end_s = self.end_s(seconds)
        while not event.is_set():
            if not self.advance(end_s):
                self._wait_until(end_s or 0.0)
                break
        return event.is_set()

    def end_s(self, seconds: float | None) -> float | None:
        """Return when so many seconds from now are over."""
        return None if seconds is None else self.world.now_s() + seconds

    def _wait_until(self, time_s: float) -> None:
        left_s = time_s - self.world.now_s()
        if left_s > 0:
            self.world.wait(left_s)

    def _is_back(self) -> bool:
        return self.running is None


class _Lent:
    """The time of one thread. `wakes_s` is when it has to go on."""

    def __init__(self, lender: Lender, turns: Turns) -> None:
        self._lender, self._turns = lender, turns
        self.thread = 0
        self.wakes_s = lender.world.now_s()
        self._woken = False
        lender.waiting.append(self)

    def now_s(self) -> float:
        """Return seconds since any fixed instant."""
        return self._lender.world.now_s()

    def wait(self, seconds: float) -> None:
        """Give the time back until so much of it has passed; not while the thread has the bus."""
        if self._turns.mine:
            self._lender.world.wait(seconds)
            return
        with self._lender.changed:
            self.wakes_s = self.now_s() + (0.0 if self._woken else seconds)
            self._give_back()
            self._await()
            self._woken = False
        self._turns.raise_if_interrupted()

    def enter(self) -> None:
        """Wait for the caller."""
        with self._lender.changed:
            self.thread = threading.get_ident()
            self._await()

    def leave(self) -> None:
        """Give the time back for good."""
        with self._lender.changed:
            self._lender.waiting.remove(self)
            self._give_back()

    def wake(self) -> None:
        """Let the thread be the next one; one that does not wait yet will not wait long."""
        with self._lender.changed:
            self._woken = True
            self.wakes_s = self.now_s()

    def advance(self) -> None:
        """Let the next thread go on until it waits again."""
        self._lender.advance()

    def pass_until(self, event: threading.Event, seconds: float | None) -> bool:
        """Let threads go on until something has happened."""
        return self._lender.pass_until(event, seconds)

    async def pass_until_async(self, event: threading.Event, seconds: float | None) -> bool:
        """Do the same, other tasks in between."""
        import asyncio

        end_s = self._lender.end_s(seconds)
        while not event.is_set():
            if not self._lender.advance(end_s):
                return False
            await asyncio.sleep(0)
        return True

    def _give_back(self) -> None:
        self._lender.running = None
        self._lender.changed.notify_all()

    def _await(self) -> None:
        self._lender.changed.wait_for(lambda: self._lender.running is self)


def _wakes_s(one: _Lent) -> float:
    return one.wakes_s


_lenders: "WeakKeyDictionary[Turns, Lender]" = WeakKeyDictionary()


def lender_of(link: Link) -> Lender:
    """Return who lends the time of a bus, the same one for all of its motions."""
    return _lenders.setdefault(link.modbus.turns, Lender(link.world))
