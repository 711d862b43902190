# SPDX-License-Identifier: MIT
"""Sessions on a bad line: no wrong value, no order made twice, no success told for a refusal."""

import random

import pytest

from bad_line import ANYHOW, IN_TURN, BadLine, QueueingBoard, VirtualMaster
from effort import cases
from fake_board import FakeWorld
from pixstep.board import orders, run, settings, upload
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
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
        self.line = BadLine(self.world, self.rng, faults, self.fake)
        self.board = Board(VirtualMaster(self.line))
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
            self.positions, self.setting, self.line_run, self.two_lines, self.refused, self.drivers,
            self.address, self.store, self.fault, self.stop,
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
        group = [run.Lines(self.board, [axis])]

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
