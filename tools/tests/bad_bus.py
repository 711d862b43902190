# SPDX-License-Identifier: MIT
"""A bad line between the master and fake boards: replies late, lost, twice, in pieces, spoilt.

`BadBus` is in virtual time, so that thousands of sessions take seconds and a seed tells all. As a
rule the line keeps the order of what is on it, as wires and queues do. `Terminal` is a pseudo
terminal in real time, with a fake board and a plan of faults at its other end.
"""

import os
import pty
import select
import threading
import time
import tty
from dataclasses import dataclass

from fake_board import FakeBoard
from pixstep.board.modbus import Master
from pixstep_trials.noise import flip, lose_bytes
from pixstep_trials.wire import crc16

TIMEOUT_S = 0.5
REPLY_S = 0.004
STRAYS = (b"", b"\x00", b"\xff", b"\xff\xff", b"\x00\xff\x01", b"\x01\x04")


@dataclass(frozen=True)
class Faults:
    """How often a frame suffers from each fault."""

    lost_request: float = 0.03
    lost: float = 0.06
    late: float = 0.06
    twice: float = 0.06
    pieces: float = 0.06
    spoilt: float = 0.06
    strays: float = 0.1
    in_order: bool = True  # else each reply comes by itself, at most half a time-out too late


IN_TURN = Faults()
NO_FAULTS = Faults(*[0] * 7)
ANYHOW = Faults(late=0.15, in_order=False)


class QueueingBoard(FakeBoard):
    """A fake board that keeps a line queued after the one that runs, and counts beginnings."""

    def __init__(self, world, unit=1, kind="mega"):
        super().__init__(world, unit, kind)
        self.begun = [0] * len(self.axes)

    def start(self, axis):
        super().start(axis)
        self.begun[self.axes.index(axis)] += 1

    def next_pixel(self, axis):
        super().next_pixel(axis)
        if axis.state == "done" and axis.entries:
            axis.state = "loaded"


class BadBus:
    """The bytes on their way, in virtual time."""

    def __init__(self, world, rng, faults, *boards):
        self.world, self.rng, self.faults, self.boards = world, rng, faults, boards
        self.coming = []  # (time, bytes), in order
        self.requests = []

    def happens(self, share):
        return self.rng.random() < share

    def send(self, frame):
        """Let the boards answer a frame; the reply is under way then."""
        self.requests.append((self.world.time, frame))
        assert crc16(frame) == 0
        if self.happens(self.faults.lost_request):
            return
        for board in self.boards:
            reply = board.answer(frame[0], frame[1:-2])
            if reply:
                self.reply(reply)

    def reply(self, reply):
        """Put a reply under way, with its faults."""
        rng, faults = self.rng, self.faults
        after_s = REPLY_S
        if self.happens(faults.late):
            longest = rng.choice((0.02, 1.2, 3)) if faults.in_order else 1.45
            after_s = rng.uniform(0, longest) * TIMEOUT_S
        if self.happens(faults.lost):
            return
        if self.happens(faults.spoilt):
            reply = rng.choice((flip, lose_bytes))(rng, reply)
        if self.happens(faults.strays):
            reply = rng.choice(STRAYS) + reply + rng.choice(STRAYS)
        for again in range(1 + self.happens(faults.twice)):
            if again and faults.in_order:
                after_s += rng.choice((0.0, rng.uniform(0, 1.9) * TIMEOUT_S))
            self.pieces(reply, after_s)

    def pieces(self, reply, after_s):
        if self.faults.in_order and self.happens(self.faults.pieces) and len(reply) > 1:
            cut = self.rng.randrange(1, len(reply))
            self.put(reply[:cut], after_s)
            self.put(reply[cut:], after_s + self.rng.uniform(0, 0.08))
        else:
            self.put(reply, after_s)

    def put(self, data, after_s):
        at = self.world.time + after_s
        if self.faults.in_order:
            at = max([at, *(when for when, _ in self.coming[-1:])])
        self.coming.append((at, data))
        self.coming.sort(key=lambda item: item[0])

    def receive(self, wait_s):
        """Return what has come; if that is nothing, let time pass until something does."""
        if not self.coming or self.coming[0][0] > self.world.time:
            end = self.world.time + wait_s
            if self.coming and self.coming[0][0] <= end:
                end = self.coming[0][0]
            self.world.wait(end - self.world.time)
        found = b""
        while self.coming and self.coming[0][0] <= self.world.time:
            found += self.coming.pop(0)[1]
        return found


class VirtualMaster(Master):
    """The master on a bad line."""

    def __init__(self, line, retries=3):
        super().__init__(TIMEOUT_S, retries)
        self.line = line

    def write(self, frame):
        self.line.send(frame)

    def read(self, wait_s):
        return self.line.receive(wait_s)

    def now_s(self):
        return self.line.world.time


class RealWorld:
    """Time as it is, for a fake board."""

    @property
    def time(self):
        return time.monotonic()


class Terminal:
    """A pseudo terminal with fake boards behind it, Megas at the addresses from 1 on.

    `plan(number, frame, reply)` gets every request, counted from 1, with its reply, and returns
    what comes back: (seconds to wait first, bytes) one after the other.
    """

    def __init__(self, count=1):
        self.plan = lambda _number, _frame, reply: [(0, reply)]
        self.boards = [QueueingBoard(RealWorld(), unit) for unit in range(1, count + 1)]
        self.board = self.boards[0]
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)
        self.frames = []  # (time, bytes)
        self.over = False
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        heard = b""
        while True:
            if not select.select([self.master], [], [], 0.02)[0]:
                if self.over:
                    return
                heard = b""
                continue
            heard += os.read(self.master, 1024)
            while end := whole(heard):
                frame, heard = heard[:end], heard[end:]
                self.frames.append((time.monotonic(), frame))
                replies = [board.answer(frame[0], frame[1:-2]) or b"" for board in self.boards]
                reply = b"".join(replies)
                for wait_s, data in self.plan(len(self.frames), frame, reply):
                    time.sleep(wait_s)
                    os.write(self.master, data)

    def close(self):
        """Serve what has come, and end."""
        if not self.over:
            self.over = True
            self.thread.join()
            os.close(self.master)
            os.close(self.slave)


def whole(heard):
    """Return the length of the request that bytes begin with; 0 if it is not all there."""
    if len(heard) < 2:
        return 0
    form = {15: (9, 6), 16: (9, 6), 23: (13, 10)}.get(heard[1])
    if form is None:
        end = {17: 4, 22: 10, 43: 7}.get(heard[1], 8)
    elif len(heard) <= form[1]:
        return 0
    else:
        end = form[0] + heard[form[1]]
    return end if end <= len(heard) else 0
