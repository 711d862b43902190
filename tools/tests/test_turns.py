# SPDX-License-Identifier: MIT
"""Threads that share a bus: whose turn it is, what an interrupted one does, whose time passes."""

import contextlib
import threading
import time

import pytest

from pixstep.board.handle import Handle
from pixstep.board.port import InterruptedBusError, Turns
from pixstep.board.shared_time import Lender, lender_of

SOON_S = 5


class Waiter(threading.Thread):
    """A thread that wants one turn and notes when it had it."""

    def __init__(self, turns, had, name, *, urgent=False, feeds=False):
        super().__init__(daemon=True)
        self.turns, self.had, self.urgent, self.feeds = turns, had, urgent, feeds
        self.called, self.ended = name, None

    def run(self):
        favour = self.turns.favoured() if self.feeds else contextlib.nullcontext()
        try:
            with favour, self.turns.taken(urgent=self.urgent):
                self.had.append(self.called)
        except InterruptedBusError as error:
            self.ended = error

    def wait(self):
        """Start, and return once it waits for its turn."""
        before = len(self.turns._waiting)
        self.start()
        end_s = time.monotonic() + SOON_S
        while len(self.turns._waiting) == before:
            assert time.monotonic() < end_s
            time.sleep(0.001)
        return self


def test_turns_come_by_rank_and_in_order():
    turns, had = Turns(), []
    with turns, turns.taken(urgent=False):
        assert turns.mine
        waiting = [Waiter(turns, had, name).wait() for name in "abc"]
        waiting.append(Waiter(turns, had, "line", feeds=True).wait())
        waiting.append(Waiter(turns, had, "stop", urgent=True).wait())
        with turns:
            pass
        assert had == []
    for one in waiting:
        one.join(SOON_S)
    assert had == ["stop", "line", "a", "b", "c"]
    assert not turns.mine


def test_an_interrupted_thread_ends_where_it_waits_and_keeps_nobody():
    turns, had = Turns(), []
    with turns:
        first, second = (Waiter(turns, had, name).wait() for name in "ab")
        turns.interrupt(first.ident)
        first.join(SOON_S)
        assert isinstance(first.ended, InterruptedBusError)
    second.join(SOON_S)
    assert had == ["b"]
    turns.interrupt(threading.get_ident())
    with pytest.raises(InterruptedBusError), turns:
        had.append("never")
    with turns:  # it is told once
        had.append("again")
    assert had == ["b", "again"]


def test_what_belongs_together_is_not_interrupted():
    turns = Turns()
    with turns:
        turns.interrupt(threading.get_ident())
        with turns.taken(urgent=True):
            pass
    with pytest.raises(InterruptedBusError), turns:
        pass
    turns.interrupt(threading.get_ident())
    turns.forget(threading.get_ident())
    with turns:
        pass


class World:
    """Time that passes only in `wait`."""

    def __init__(self):
        self.time_s = 0.0

    def now_s(self):
        return self.time_s

    def wait(self, seconds):
        self.time_s += seconds


class Bus:
    """A bus of which nothing is asked."""

    def __init__(self):
        self.world, self.modbus = World(), self
        self.turns = Turns()


def ticking(bus, period_s, times, noted, name):
    """Return a motion that looks at its board every so often."""

    def make(course):
        course.begun()
        for _ in range(times):
            course.world.wait(period_s)
            noted.append((name, round(course.world.now_s(), 6)))
        return name

    return Handle(bus, [], make)


def test_several_motions_share_time_in_its_order():
    bus, noted = Bus(), []
    slow = ticking(bus, 0.3, 2, noted, "slow").begin()
    fast = ticking(bus, 0.1, 7, noted, "fast").begin()
    assert bus.world.now_s() == 0 and noted == []
    assert slow.wait() == "slow"
    assert noted == [
        ("fast", 0.1), ("fast", 0.2), ("slow", 0.3), ("fast", 0.3), ("fast", 0.4), ("fast", 0.5),
        ("slow", 0.6),
    ]  # fmt: skip
    assert not fast.over
    lender_of(bus).pass_time(0.05)
    assert bus.world.now_s() == pytest.approx(0.65) and len(noted) == 8
    assert fast.wait() == "fast" and len(noted) == 9


def test_a_motion_is_waited_for_in_the_time_of_its_boards():
    bus, noted = Bus(), []
    motion = ticking(bus, 0.4, 3, noted, "one").begin()
    with pytest.raises(TimeoutError, match=r"takes longer than 0\.5 s"):
        motion.wait(0.5)
    assert bus.world.now_s() == pytest.approx(0.5) and len(noted) == 1
    assert not motion.done and len(noted) == 2
    motion.halt()
    assert motion.over and len(noted) == 2


def test_a_thread_that_asks_of_its_own_motion_does_not_wait_for_itself():
    bus, seen = Bus(), []

    def make(course):
        course.world.wait(0.1)
        seen.append(handle.done)

    handle = Handle(bus, [], make)
    handle.begin()
    handle.wait()
    assert seen == [False]


def test_a_lender_without_motions_lets_time_pass():
    world = World()
    lender = Lender(world)
    assert not lender.advance()
    lender.pass_time(2)
    assert not lender.pass_until(threading.Event(), 1)
    assert world.now_s() == 3
