# SPDX-License-Identifier: MIT
"""Rests of the pixel clock, from a second to ten hours.

The clock stops behind a line, time passes, the clock comes back. Then the board must answer in
time, must not have been reset, must have no fault, and a line that is armed must begin on a clock
edge, as ever. `go` comes before the clock is back, or behind that; a line that waits for it begins
on the edge that it names.

Simulating ten hours costs hours. A rest beyond SIMULATED_S is told to the firmware instead: what
counts time in its RAM is moved on as an idle board would have moved it, all between two
instructions.

    timer 0 overflows          clock.c, the clock of 4 us and of milliseconds
    idle_count, idle_seen      idle periods loaded and accounted for, of each axis
    loaded_ticks, delay_ticks  the account of time of each axis, what came before its stream

Nothing else changes in an idle board. The timers' own counters stand as they were: the rest is a
whole number of their periods. If the board was just writing its account, the words no longer agree;
that is seen and the rest is not counted.
"""

import random
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards
from pixstep.progress import Progress, unseen
from pixstep_dev.robustness.orders import lines, state
from pixstep_dev.robustness.orders.actions import (
    BoardOrder,
    ClockCommand,
    Frequency,
    Look,
    QueueBlock,
    Setting,
    Wait,
)
from pixstep_dev.robustness.orders.guard import Guard
from pixstep_dev.robustness.orders.world import IDLE_TICKS, OrdersWorld
from pixstep_trials import frames

SIMULATED_S = 2  # longer rests are told to the firmware
LONGEST_S = 36_000
OVERFLOW_TICKS = 16_384  # of timer 0, and whole idle periods
_REPLY_S = 0.005  # a reply begins behind the silence, at most
PLACE_CYCLES = 40  # a line's last edge from a pixel's end
_CLOCKS_HZ = (1, 5000)
_LINE_PX = 2
_COUNT = 4
_TOKEN = 77
_BACK_S = 0.3  # how long the clock is watched when it is back


@dataclass(frozen=True)
class RestsPlan:
    """So many rests of one board."""

    board: str
    count: int
    seed: int = 1
    first: int = 0
    image: Path | None = None


@dataclass
class RestsOutcome:
    """What happened."""

    plan: RestsPlan
    rests: int = 0
    uncounted: int = 0  # the board was just writing its account
    hours: float = 0.0
    slowest_cycles: int = 0  # reply behind the request's end, at most
    farthest_cycles: int = 0  # last edge of a line from its place
    lines: int = 0
    failures: list[str] = field(default_factory=list)


def run(plan: RestsPlan, progress: Progress = unseen) -> RestsOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = RestsOutcome(plan)
    for index in range(plan.first, plan.first + plan.count):
        rest = _Rest(plan, index, outcome)
        outcome.failures += [f"{plan.seed}:{index} {rest.text}: {text}" for text in rest.go()]
        progress((index - plan.first + 1) / plan.count)
    return outcome


def text(outcome: RestsOutcome) -> str:
    """Return what happened in two lines."""
    return (
        f"{outcome.plan.board}: {outcome.rests:,} rests, {outcome.hours:,.0f} hours together, "
        f"{len(outcome.failures):,} complaints; {outcome.uncounted:,} not counted\n"
        f"  replies {outcome.slowest_cycles:,} cycles behind the request at most, "
        f"{outcome.lines:,} lines behind a rest end within {outcome.farthest_cycles} cycles of "
        f"their place"
    )


class _Rest:
    """One rest, on a simulator of its own."""

    def __init__(self, plan: RestsPlan, index: int, outcome: RestsOutcome) -> None:
        rng = random.Random(f"rests {plan.board} {plan.seed}:{index}")
        low, high = _CLOCKS_HZ
        self.tick_hz = boards.load(plan.board).tick_hz
        self.hz = max(1, round(low * (high / low) ** rng.random()))
        self.seconds = float(LONGEST_S ** rng.random())
        self.phase = rng.randrange(self.tick_hz // self.hz)
        self.lines = self.hz <= max(lines.clock_hz(plan.board))
        self.token = self.lines and rng.random() < 0.3
        self.early = self.token and rng.random() < 0.5
        self.ahead = lines.go_ahead(self.tick_hz, self.hz) if self.token else 0
        self.outcome, self.plan = outcome, plan
        self.text = f"{self.hz} Hz, {self.seconds:.0f} s"
        if self.token:
            self.text += f", armed, go {'before' if self.early else 'behind'} the clock"

    def go(self) -> list[str]:
        """Do it; return what did not hold."""
        with OrdersWorld(self.plan.board, self.plan.image, self.hz) as self.world:
            self.guard = Guard(self.world)
            self.period = Fraction(self.tick_hz, self.hz)
            self.guard.do(Frequency(self.hz))
            self.guard.do(Setting("bus_timeout_ms", 0))  # nobody asks anything for long
            self._line_before()
            if not self._pass():
                self.outcome.uncounted += 1
                return []
            self._back()
            self.outcome.rests += 1
            self.outcome.hours += self.seconds / 3600
        return self.guard.complaints

    def _line_before(self) -> None:
        """One line that is over was the clock's reference; another may wait for go."""
        do = self.guard.do
        if self.lines:
            self._arm(None)
            do(Wait(int((_LINE_PX + 4) * self.period)))
            do(Look())
        if self.token:
            self._arm(_TOKEN)
        do(ClockCommand("off"))
        self.guard.model.expected.clear()
        do(Wait(int(self.period) + self.phase))
        do(Look())

    def _arm(self, token: int | None) -> None:
        for axis in range(self.world.axes):
            entries = ((0x21, 0), (0, 0), (_COUNT, _LINE_PX), (2, 0))
            self.guard.do(QueueBlock(axis, entries))
        self.guard.do(BoardOrder("arm", self.world.all_axes, token))

    def _pass(self) -> bool:
        """Let the time of the rest pass; False if the board's words do not agree afterwards."""
        if self.seconds <= SIMULATED_S:
            self.world.perform(Wait(int(self.seconds * self.tick_hz)))
            return True
        tell(self.world, int(self.seconds * self.tick_hz) // OVERFLOW_TICKS)
        self.world.perform(Wait(self.tick_hz // 100))
        agreed = told_well(self.world, self.guard.accounts, self.seconds)
        self.guard.note_time()
        return agreed

    def _back(self) -> None:
        """The clock is back: the board answers in time and has no fault; a line has its place."""
        world, do = self.world, self.guard.do
        before = self._counts()
        if self.early:
            do(BoardOrder("go", 0, _TOKEN, ahead=self.ahead))
            do(Look())
        do(ClockCommand(f"hz {self.hz}/1"))
        do(ClockCommand("on"))
        self.guard.model.expected.clear()
        zero = world.cycle
        until = world.cycle + int(max(_BACK_S * self.tick_hz, float(3 * self.period)))
        while world.cycle < until:
            self._ask()
            world.perform(Wait(random.Random(world.cycle).randrange(self.tick_hz // 100)))
        do(Look())
        if self.lines:
            self._line(zero, before)
        self.guard.recover()

    def _counts(self) -> list[int]:
        return [self.world.edges(axis).made for axis in range(self.world.axes)]

    def _ask(self) -> None:
        frame = frames.read_inputs(state.FIRST, state.words(self.world.axes))
        reply = self.world.ask(frame)
        sent = self.world.asked + len(frame) * self.world.byte_cycles
        took = self.world.told - sent
        self.outcome.slowest_cycles = max(self.outcome.slowest_cycles, took)
        if not reply.taken or took > self.world.silence_cycles + self.world.sim.cycles(_REPLY_S):
            self.guard.complain(f"reply {took} cycles behind the request")

    def _line(self, zero: int, before: list[int]) -> None:
        """Do a line, or look at the one that was told before the clock was back."""
        if not self.token:
            self._arm(None)
        elif not self.early:
            self.guard.do(BoardOrder("go", 0, _TOKEN, ahead=self.ahead))
        pixels = _LINE_PX + 4 + self.ahead
        self.guard.do(Wait(int(pixels * self.period) + self.tick_hz // 10))
        self.guard.do(Look())
        for axis, old in enumerate(before):
            edges = self.world.edges(axis)
            if edges.made - old != _COUNT * _LINE_PX:
                self.guard.complain(f"axis {axis}: {edges.made - old} edges of a line")
                continue
            off = int(self._off(edges.last - zero))
            self.outcome.lines += 1
            self.outcome.farthest_cycles = max(self.outcome.farthest_cycles, off)
            if off > PLACE_CYCLES:
                self.guard.complain(f"axis {axis}: its line ends {off} cycles from a clock edge")

    def _off(self, last: int) -> Fraction:
        """Return how far a line's last edge, so long behind the clock's return, is from its place.

        The place is the end of a pixel: whole periods from a clock edge. `go` before the return
        names the edge, counted from the first one that comes.
        """
        if self.early:
            return abs(last - (self.ahead + _LINE_PX) * self.period)
        off = last % self.period
        return min(off, self.period - off)


def tell(world: OrdersWorld, overflows: int) -> None:
    """Tell an idle board that so many overflows of timer 0 have passed."""
    ticks = overflows * OVERFLOW_TICKS
    world.add(world.coarse_overflows(), 4, overflows)
    for axis in range(world.axes):
        for address, size, unit in world.time_words(axis):
            world.add(address, size, ticks // unit)


def told_well(world: OrdersWorld, before: list[int], seconds: float) -> bool:
    """Whether every account of time has moved on by the rest."""
    ticks = int(seconds * world.tick_hz) // OVERFLOW_TICKS * OVERFLOW_TICKS
    for axis, old in enumerate(before):
        off = (world.account(axis) - old - ticks + (1 << 31)) % (1 << 32) - (1 << 31)
        if abs(off) > 2 * IDLE_TICKS:
            return False
    return True
