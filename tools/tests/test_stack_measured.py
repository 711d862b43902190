# SPDX-License-Identifier: MIT
"""The worst stack counted on each image against the highest one seen while it is driven hard."""

import random
from fractions import Fraction

import pytest
import sizes

from bench import Bench
from effort import cases
from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.simulated_board import SerialLoad
from pixstep_trials import lines

pytestmark = pytest.mark.usefixtures("simulator")
HZ = Fraction(100)
ROUNDS = cases(3, 6)
PEAK = 60_000  # steps/s of all axes together, in smooth lines
SEEK, DOWN, END = 0x81, (3, 0), (2, 0)
# Of the counted stack so much at least must have been seen, or the count says little: it adds up
# interrupts that need a coincidence of a few cycles each: on a board of four axes seven of them,
# and one more where it makes a clock of its own.
SEEN = {"uno": 0.55, "m1284": 0.4, "mega": 0.36}


class Driven(Bench):
    """A board in a round of everything at once; `used` is its stack's high-water mark, bytes."""

    def __init__(self, board, seed):
        self.name, self.rng = board, random.Random(f"stack {board} {seed}")
        super().__init__(board, range(boards.load(board).axes), HZ, plants={(0, 0): "home=900"})

    def used(self):
        return self.sim.stats()["boards"][0]["stack_used_bytes"]

    def attempt(self, method, *arguments):
        """Ask for something that the board may refuse: that takes a way of its own."""
        try:
            return method(*arguments)
        except BoardError:
            return None

    def every_command(self):
        for name, code in regs.COMMANDS.items():
            key = 0x5AFE if name in ("store", "default_settings") else 0
            self.attempt(self.board.write, regs.COMMAND_BASE, [self.rng.randint(0, 15), code, key])

    def settings(self):
        """All of them, as they are, and one out of range."""
        count = max(r.address + r.words for r in self.board.map.holdings if r.address < 0x100)
        words = self.board.read_holdings(0, count)
        self.attempt(self.board.write, 0, words)
        self.attempt(self.board.write, 4, [0, 0])
        self.attempt(self.board.read_inputs, 0x500, 3)

    def own_clock(self):
        """Make a clock where the board can: the handler of its edges lets others in."""
        if self.board.has("clock_out"):
            self.board.write_setting("clock_out_hz", 2000)

    def smooth_lines(self):
        """Every axis smooth, the serial line saturated meanwhile."""
        line = lines.at_peak(lines.count_at(PEAK // len(self.axes), HZ), HZ, 0.1)
        uploads = {axis: self.load(line, axis) for axis in self.axes}
        self.arm()
        load = SerialLoad(self.board, self.axes, uploads)
        while any(self.state(axis) in ("armed", "running") for axis in self.axes):
            for upload in uploads.values():
                self.attempt(upload.push)
            load.until(self.sim, self.sim.cycle + self.pixel_ticks)

    def seek_beside_lines(self):
        """A switch, the clock, four step interrupts and the serial line, all at any time."""
        self.own_clock()
        for axis in self.axes[1:]:
            self.load(Line((25, -25) * 12, PLAIN), axis)
        entries = [(SEEK, 0), (0, 0), (10, 1), (60, 30), DOWN, (10, 1), END]
        LineUpload(self.board, 0, entries).push()
        self.arm()
        while self.state() in ("armed", "running"):
            self.attempt(self.board.records, 0)

    def emergency_stop(self):
        """In the middle of a reply, while every axis turns to and fro."""
        self.own_clock()
        (pin,) = [one for one in boards.load(self.name).pins if one.signal == "ESTOP"]
        for axis in self.axes:
            self.load(Line((25, -25) * 12, PLAIN), axis)
        self.arm()
        self.run_until_steps(self.count() + 100)
        for level, wait in ((0, 30_000), (1, 60_000)):
            at = self.sim.cycle + self.rng.randint(1, wait)
            self.sim.command(f"pin 0 {pin.port} {pin.bit} {level} at {at}")
            for _ in range(4):
                self.board.inputs()
        assert self.fault() == "estop"

    def recover(self):
        """Whatever has become of it: everything cleared, and the settings as they were."""
        self.sim.run(200_000)
        self.attempt(self.board.command, "stop", self.axes)
        self.sim.run(200_000)
        self.attempt(self.board.command, "clear_fault", self.axes)
        self.attempt(self.board.command, "discard", self.axes)
        self.sim.run(4_000_000)  # a record may be on its way to the EEPROM
        self.attempt(self.board.command, "enable", self.axes)
        self.attempt(self.board.write_setting, "clock_out_hz", 0)
        self.board.set_pixel_hz(self.hz)

    def everything(self):
        for deed in (self.settings, self.smooth_lines, self.seek_beside_lines,
                     self.every_command, self.emergency_stop, self.every_command):  # fmt: skip
            deed()
            self.recover()


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_no_more_stack_is_used_than_was_counted(board, capsys):
    counted = sizes.measure(board, natives.image(board))
    seen = 0
    for seed in range(ROUNDS):
        with Driven(board, seed) as bench:
            bench.everything()
            seen = max(seen, bench.used())
    with capsys.disabled():
        print(f"\n{board}: stack seen {seen}, counted {counted.worst_stack} bytes", end=" ")
    assert SEEN[board] * counted.worst_stack <= seen <= counted.worst_stack
