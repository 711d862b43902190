# SPDX-License-Identifier: MIT
"""A simulated board on a pixel clock of the test's own edges: any period, jitter, gaps, doubles."""

import random
from collections.abc import Callable
from fractions import Fraction

from bench import Bench
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.simulation.logs import read_edges

AHEAD_S = 0.25  # edges are laid so far ahead of the simulation,
MOST_AHEAD = 110  # but no more than these
HIGH_CYCLES = 200
SYNC = {"free": 0, "start": 1, "lock": 2}


class OwnClock:
    """Edges of a clock: `period(k)` cycles from edge k to the next, displaced by `jitter()`.

    `true` has the cycle of each edge without its displacement, `edges` those that reach the board.
    """

    def __init__(
        self,
        bench: Bench,
        period: Callable[[int], Fraction],
        jitter: Callable[[], float] = lambda: 0.0,
        keep: Callable[[int], bool] = lambda k: True,
        extra: Callable[[int], list[int]] = lambda k: [],
    ):
        self.sim, self.period, self.jitter = bench.sim, period, jitter
        self.keep, self.extra = keep, extra
        (self.pin,) = (p for p in boards.load(bench.name).pins if p.signal == "PIXEL_CLOCK")
        self.next = Fraction(bench.sim.cycle + 20_000)
        self.true: list[Fraction] = []
        self.edges: list[int] = []
        self.waiting: list[int] = []
        self.on = True
        bench.sim.command("clock off")
        self._run, self._transmit = bench.sim.run, bench.sim.transmit
        bench.sim.run, bench.sim.transmit = self.run, self.transmit

    def run(self, cycles):
        """Let time pass, with edges."""
        end = self.sim.cycle + cycles
        while self.sim.cycle < end:
            self.lay()
            self._run(min(end - self.sim.cycle, max(1, int(self.next) - self.sim.cycle) // 2 + 1))
        return self.sim.cycle

    def transmit(self, *words, **more):
        """Send a request, with edges."""
        self.lay()
        return self._transmit(*words, **more)

    def lay(self):
        """Lay edges for some time, or as many as the simulator remembers."""
        self.waiting = [at for at in self.waiting if at > self.sim.cycle]
        end = self.sim.cycle + AHEAD_S * self.sim.tick_hz
        while self.next < end and len(self.waiting) < MOST_AHEAD:
            k = len(self.true)
            self.true.append(self.next)
            at = int(self.next + Fraction(self.jitter()))
            if self.keep(k) and self.on:
                self._pulse(at)
            for more in self.extra(k) if self.on else ():
                self._pulse(at + more)
            self.next += self.period(k)

    def _pulse(self, at):
        self.edges.append(at)
        self.waiting.append(at)
        self.sim.pin(0, self.pin.port, self.pin.bit, 1, at)
        self.sim.pin(0, self.pin.port, self.pin.bit, 0, at + HIGH_CYCLES)


def gauss(seed, sigma):
    """Return a source of displacements, normally distributed, in cycles."""
    source = random.Random(seed)
    return lambda: source.gauss(0, sigma)


class LockBench(Bench):
    """A board whose lines are locked to a clock of the test's own."""

    def follow(self, sync="lock", **settings):
        """Write the settings of the lock."""
        for name, value in {"sync": SYNC[sync], **settings}.items():
            self.board.write_setting(name, value)

    def clock(self, period, **more):
        """Begin the clock, and let the filter settle."""
        self.sim.command("clock off")
        self.until(lambda: not self.board.input("status") & 1)
        steady = period if callable(period) else lambda k: Fraction(period)
        self.own = OwnClock(self, steady, **more)
        return self.own

    def settle(self, seconds=5):
        """Wait until the board has measured the clock, and the clock runs."""
        self.until(lambda: self.board.input("status") & 0x81 == 0x81, seconds)

    def last_steps(self, line, axis=0, before=0):
        """Cycles of the last step of each pixel, from the edges recorded.

        Of a line with backlash those behind its take-up are right.
        """
        self.sim.command("flush")
        rising = read_edges(self.edges_path).axis(0, axis).rising[before:]
        ends, total = [], line.backlash
        for count in line.counts:
            total += abs(count)
            ends.append(int(rising[total - 1]) if count else None)
        assert len(rising) == total
        return ends

    def fault_name(self):
        """Name of the latched fault."""
        return regs.code_name(regs.faults(), self.board.input("fault_code"))
