# SPDX-License-Identifier: MIT
"""Sessions on a bad line: no wrong value, no order made twice, no success told for a refusal."""

import random
from itertools import pairwise

import pytest

from bad_bus import (
    ANYHOW,
    IN_TURN,
    NO_FAULTS,
    REPLY_S,
    TIMEOUT_S,
    BadBus,
    QueueingBoard,
    VirtualMaster,
)
from effort import cases
from fake_board import FakeWorld
from pixstep.board import orders, run, scan, settings, upload
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, NoReplyError
from pixstep.lines.line import PLAIN, Line

SESSIONS = cases(150, 2000)
OTHER_UNITS = (5, 9)


class Session:
    """What a host does in some minutes on a bad line, each thing checked against the board."""

    def __init__(self, seed, faults=IN_TURN):
        self.rng = random.Random(seed)
        self.world = FakeWorld()
        self.fake = QueueingBoard(self.world)
        self.fake.clock = True
        self.fake.values["pixel_period_ticks"] = 800_000  # a twentieth of a second
        self.line = BadBus(self.world, self.rng, faults, self.fake)
        self.board = Device(VirtualMaster(self.line))
        self.given_up = 0
        for number, axis in enumerate(self.fake.axes, 1):
            axis.position = 8 * number

    def attempt(self, action):
        """Do something; return whether it came to its end. Giving up is allowed on such a line."""
        try:
            action()
        except BoardError as error:
            assert error.code is None, error  # nothing here is refused
            self.given_up += 1
            return False
        return True

    def go(self):
        kinds = (
            self.positions, self.words, self.setting, self.line_run, self.two_lines, self.refused,
            self.drivers, self.address, self.store, self.fault, self.stop,
        )  # fmt: skip
        for _ in range(6):
            self.rng.choice(kinds)()
            self.recover()

    def recover(self):
        """Have the axes at rest and empty again, beside the line."""
        self.world.wait(20)
        self.fake.tick()
        for axis in self.fake.axes:
            axis.state, axis.entries, axis.repeat = "empty", [], 0
        self.fake.fault = (0, 0, 0, 0)
        self.board.unit = self.fake.holdings[0]

    def positions(self):
        for axis in self.rng.sample(range(4), 4):
            found = []
            if self.attempt(lambda axis=axis, found=found: found.append(self.board.axis(axis))):
                assert found[0]["position_steps"] == self.fake.axes[axis].position

    def words(self):
        """Some words of the head of the map, as many as other requests ask for."""
        for _ in range(4):
            first, count = self.rng.randrange(1, 4), self.rng.randrange(1, 8)
            found = []
            if self.attempt(
                lambda at=first, size=count, found=found: found.extend(
                    self.board.read_inputs(at, size)
                )
            ):
                assert found == self.fake.read(True, first, count)

    def setting(self):
        name = self.rng.choice(("dir_hold_us", "dir_setup_us", "bus_timeout_ms", "idle_off_ms"))
        value = self.rng.randrange(100, 999)
        if self.attempt(lambda: self.board.write_setting(name, value)):
            assert self.fake.setting(name) == value
        other = self.rng.choice(("dir_hold_us", "dir_setup_us", "bus_timeout_ms", "idle_off_ms"))
        found = []
        if self.attempt(lambda: found.append(self.board.setting(other))):
            assert found == [self.fake.setting(other)]

    def counts(self):
        return tuple(self.rng.randrange(1, 60) for _ in range(self.rng.choice((3, 20, 300))))

    def line_run(self):
        """Upload and run a line, shorter or longer than a time-out, or than the queue."""
        axis = self.rng.randrange(4)
        mine, counts = self.fake.axes[axis], self.counts()
        before, begun = mine.position, self.fake.begun[axis]
        self.fake.holdings[3] = self.rng.choice((5, 30, 1000) if len(counts) < 100 else (20,))
        group = [run.LinesOfBoard(self.board, [axis])]

        def do():
            with run.stopped_on_failure(group):
                group[0].uploads += upload.begin(self.board, {axis: Line(counts, PLAIN)})
                run.arm(self.board, [axis])
                run.follow(group, self.world)

        done = self.attempt_streamed(do)
        self.fake.tick()
        assert self.fake.begun[axis] - begun <= 1
        if done:
            assert mine.position - before == sum(counts)

    def attempt_streamed(self, do):
        """As `attempt`; a queue may run dry here, since a bad line is too slow to fill it."""
        try:
            do()
        except BoardError as error:
            assert error.code is None or "starved" in str(error), error
            return False
        return True

    def two_lines(self):
        """An order to arm starts the first of two queued lines, and never the second too."""
        mine = self.fake.axes[0]
        self.fake.holdings[3] = self.rng.choice((30, 1000))

        def load():
            for counts in ((5, 6), (7, 8, 9)):
                upload.begin(self.board, {0: Line(counts, PLAIN)})

        if not self.attempt(load):
            return
        before, begun = mine.position, self.fake.begun[0]
        done = self.attempt(lambda: run.arm(self.board, [0]))
        self.world.wait(5)
        self.fake.tick()
        assert self.fake.begun[0] - begun <= 1
        if done:
            assert (mine.position - before, mine.state) == (11, "loaded")

    def refused(self):
        """Nothing is loaded: an order to arm is refused, and never told as done."""
        orders_before = self.rng.random() < 0.5
        if orders_before:
            self.attempt(lambda: self.board.command("enable", [0]))
        with pytest.raises(BoardError):
            run.arm(self.board, [self.rng.randrange(4)])

    def drivers(self):
        for _ in range(2):
            name = self.rng.choice(("enable", "disable"))
            if self.attempt(lambda name=name: self.board.command(name, [2])):
                assert bool(self.fake.drivers >> 2 & 1) == (name == "enable")

    def address(self):
        old = settings.defaults() | {"unit_address": self.board.unit}
        new = old | {"unit_address": self.rng.choice(OTHER_UNITS)}
        wanted = settings.changes(old, new)
        if self.attempt(lambda: settings.write(self.board, old, wanted)):
            assert self.fake.holdings[0] == new["unit_address"] == self.board.unit

    def store(self):
        before = self.fake.serial
        if self.attempt(lambda: settings.store(self.board, self.world)):
            assert self.fake.serial == before + 1
        assert self.fake.serial <= before + 1

    def fault(self):
        self.fake.latch("limit_plus", 1, 0, 3)
        if self.attempt(lambda: orders.clear_fault(self.board)):
            assert self.fake.fault[0] == 0

    def stop(self):
        self.fake.holdings[3] = 5
        if not self.attempt(
            lambda: upload.begin(self.board, {1: Line((5,) * 100, PLAIN)})
        ) or not self.attempt(lambda: run.arm(self.board, [1])):
            return
        if self.attempt(lambda: run.stop_axes(self.board, [1])):
            assert self.fake.axes[1].state == "empty"


@pytest.mark.parametrize("part", range(10))
def test_sessions_on_a_bad_line(part):
    given_up = 0
    for seed in range(part, SESSIONS, 10):
        session = Session(seed, ANYHOW if seed % 4 == 3 else IN_TURN)
        try:
            session.go()
        except AssertionError as error:
            error.add_note(f"seed {seed}")
            raise
        given_up += session.given_up
    assert given_up < SESSIONS  # of 6 things each, done in 10 parts


# The reply to the fence comes twice, and looks like the one that is awaited.
@pytest.mark.parametrize("seed", [565, 1401])
def test_a_fence_does_not_look_like_what_is_asked_next(seed):
    Session(seed, IN_TURN).go()


def lossy(*lost):
    """Return a line on which the replies to some requests are lost, from 0 on, and a board."""
    line = BadBus(FakeWorld(), random.Random(1), NO_FAULTS)
    line.boards = (QueueingBoard(line.world), QueueingBoard(line.world, 2))
    line.reply = lambda reply: len(line.requests) - 1 in lost or line.put(reply, REPLY_S)
    return line, Device(VirtualMaster(line))


def waits(line):
    """Return how long after the one before it each request went out."""
    return [after - before for (before, _), (after, _) in pairwise(line.requests)]


def test_the_line_is_quiet_for_a_time_out_after_a_repetition():
    line, board = lossy(0)
    assert board.setting("dir_hold_us") == board.setting("dir_setup_us") == 20
    first, again, fence, last = (frame for _, frame in line.requests)
    assert first == again and fence[1] == 4 and last not in (first, fence)
    lost, quiet, soon = waits(line)
    assert lost >= TIMEOUT_S and quiet >= TIMEOUT_S and soon < 3 * REPLY_S


def test_another_board_is_asked_after_the_quiet_too_but_needs_no_fence():
    line, board = lossy(0)
    board.setting("dir_hold_us")
    Device(board.modbus, 2).setting("dir_hold_us")
    _, quiet = waits(line)
    assert quiet >= TIMEOUT_S


def test_a_scan_of_silent_addresses_waits_for_no_quiet():
    line, board = lossy()
    with scan.quickly(board.modbus, 0.08):
        found = scan.scan(board.modbus, range(1, 20))
    assert [one.unit for one in found] == [1, 2]
    assert len(line.requests) == 19 and max(waits(line)) < 0.1


def test_a_good_line_has_no_waits_and_few_fences():
    line, board = lossy()
    group = [run.LinesOfBoard(board, [0])]
    group[0].uploads += upload.begin(board, {0: Line((5, 6) * 20, PLAIN)})
    run.arm(board, [0])
    run.follow(group, line.world)
    heads = [frame for _, frame in line.requests if frame[1:4] == b"\x04\0\0" and frame[4] == 0]
    assert len(heads) < len(line.requests) / 4


def test_a_stop_goes_out_without_quiet_and_is_looked_after():
    line, board = lossy(0, 1)
    with pytest.raises(NoReplyError), board.once():
        board.input("status")
    run.stop_axes(board, [0])
    stops = [(at, frame) for at, frame in line.requests if frame[1] == 16]
    assert stops[0][0] - line.requests[0][0] < TIMEOUT_S + 3 * REPLY_S
    assert len(stops) == 1  # it has been heard, which a look behind a fence has shown
