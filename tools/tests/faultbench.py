# SPDX-License-Identifier: MIT
"""A simulated board that is to have a named fault, and everything a fault promises, asserted.

A test says by `@pytest.mark.provokes("starved")` which faults it provokes; conftest.py lets it pass
only if `FaultBench.assert_fault` was satisfied with each of them. docs/FAULTS.md names these tests.
"""

import contextlib
from collections.abc import Callable

from bench import QUIET_S, Bench
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep_trials.memory import Memory

asserted: set[str] = set()  # names of the faults asserted in the running test

# A fault is seen so many cycles after it was latched, at most.
LOOK_CYCLES = 1000
# From its code's being written to the end of what the firmware does about it.
LATCH_CYCLES = 1000
# One interval, the longest period of the timer, and a round of the main loop that stops the axes.
LAST_EDGE_CYCLES = 0x10000
_OUTPUT_PERMIT = 1 << 8


class FaultBench(Bench):
    """A board whose permit output is on when the test begins."""

    def __enter__(self):
        super().__enter__()
        self.memory = Memory(self.sim, self.name)
        self.switch_permit_on()
        return self

    def switch_permit_on(self):
        self.board.command("permit_on", [])
        assert self.permit_pin() and self.board.input("outputs") & _OUTPUT_PERMIT

    def permit_pin(self):
        """True if the permit pin is driven high."""
        return self.sim.command("permit 0").split()[1] == "1"

    def latched(self):
        """Code of the fault that the firmware has latched, read without its help."""
        return self.memory.read("fault.code")

    def poke(self, member, value):
        """Write a member of one of the firmware's variables, "limits.min_interval_ticks"."""
        self.memory.write(member, value)

    def peek(self, member):
        """Read a member of one of the firmware's variables."""
        return self.memory.read(member)

    @contextlib.contextmanager
    def main_loop_held(self):
        """Let nothing but interrupts run inside."""
        self.sim.command("hang 0 main")
        yield
        self.sim.command("hang 0 off")

    def until_true(self, done: Callable[[], bool], cycles=16_000_000, look=LOOK_CYCLES):
        """Let time pass, without a request, until done() holds."""
        limit = self.sim.cycle + cycles
        while not done():
            assert self.sim.cycle < limit, f"not in {cycles} cycles"
            self.sim.run(look)

    def run_into_fault(self, cycles=48_000_000):
        """Let time pass until a fault is latched; no request disturbs it."""
        self.until_true(self.latched, cycles)
        self.sim.run(LATCH_CYCLES)

    def assert_fault(self, name, axis=0, *, pixel, argument=0, known=True):
        """Assert what the fault latched just now says and promises.

        `pixel` and `argument` are a number or a range. `known`: the positions are the edges
        counted.
        """
        assert regs.code_name(regs.faults(), self.latched()) == name
        counts = self._counts()
        assert not self.permit_pin()
        # What a timer already held.
        self.sim.run(LAST_EDGE_CYCLES)
        last = self._counts()
        assert all(0 <= b - a <= 1 for a, b in zip(counts, last, strict=True)), (counts, last)
        self._assert_registers(name, axis, pixel, argument)
        self._assert_rest(last, known=known)
        asserted.add(name)

    def _counts(self):
        axes = range(boards.load(self.name).axes)
        return [self.count(axis) for axis in axes]

    def _assert_registers(self, name, axis, pixel, argument):
        said = self.board.inputs()
        code = next(fault.code for fault in regs.faults().values() if fault.name == name)
        assert said["fault_code"] == code
        assert said["fault_axis"] == axis
        assert said["fault_pixel"] in _range(pixel)
        assert said["fault_argument"] in _range(argument)
        masks = said["fault_mask_high"] << 16 | said["fault_mask"]
        assert masks & 1 << code
        assert not said["outputs"] & _OUTPUT_PERMIT

    def _assert_rest(self, counts, *, known):
        """No edge follows; nothing can be armed or switched on; positions are the edges."""
        self.sim.wait_s(QUIET_S)
        assert self._counts() == counts
        states = [self.state(axis) for axis in range(len(counts))]
        assert not {"armed", "running"} & set(states)
        for axis in range(len(counts)) if known else ():
            position = self.board.axis(axis)["position_steps"]
            assert position == self.sim.steps(0, axis), f"axis {axis}"


def _range(number):
    """Return a range for a number, or the range that is one already."""
    return range(number, number + 1) if isinstance(number, int) else number
