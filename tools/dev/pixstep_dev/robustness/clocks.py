# SPDX-License-Identifier: MIT
"""Pixel clocks of another frequency than the board is set to: never followed without a word.

A trial takes a clock of 0.24 to 4.2 times the frequency set. It comes while the board rests and
has measured the right clock, or in the middle of a line. Within 8 of its edges, or 20 ms where
those are sooner, the board must have said so: a locked line is refused, or a fault is latched. A
line that is armed meanwhile must end in a fault within its first 8 pixels. No line may end as if
nothing had been.

The two modes tolerate what is near: `lock` its tolerance, `start` a sixteenth of the period.
"""

import contextlib
import random
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.board import registers as regs
from pixstep.board import snapshot
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard

LOWEST, HIGHEST = 0.24, 4.2
TOLERATED = {"lock": 0.011, "start": 0.0626}
NAMED_EDGES, NAMED_S = 8, 0.020
NEAR_EDGES = 10  # with `lock` within NEAR of the frequency, where the phase has jumped as well
NEAR = 0.1
# A change of some per mille beyond the tolerance, behind a jump of the phase that it takes back.
CLOSE_EDGES, CLOSE = 20, 0.02
_RATES_HZ = (10, 2000)
_LINE_PX = 4000
_AT_ONCE = 40
_ROUND_S = 0.006  # the board's main loop comes by
_ARMED_S = 0.01


@dataclass(frozen=True)
class ClocksPlan:
    """So many wrong clocks at one board."""

    board: str
    clocks: int
    seed: int = 1


@dataclass
class ClocksOutcome:
    """What happened. `complaints` is empty if every promise was kept."""

    plan: ClocksPlan
    clocks: int = 0
    in_motion: int = 0
    named: dict[str, int] = field(default_factory=dict)  # by what named it
    complaints: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class ClocksTrial:
    """One wrong clock."""

    sync: str
    hz: int
    factor: float
    moves: bool
    phase: float  # of the period at which it comes

    @property
    def text(self) -> str:
        """All of it in words."""
        when = "in motion" if self.moves else "at rest"
        return f"sync {self.sync}, {self.hz} Hz times {self.factor:.3f} {when}"

    @property
    def named_s(self) -> float:
        """The time within which it must be named."""
        off = abs(self.factor - 1) if self.sync == "lock" else 1.0
        edges = CLOSE_EDGES if off < CLOSE else NEAR_EDGES if off < NEAR else NAMED_EDGES
        # The clock's own edge comes up to a period after the change.
        return max(NAMED_S, (edges + 1) / (self.hz * self.factor)) + _ROUND_S


def make(rng: random.Random) -> ClocksTrial:
    """Return a random trial."""
    sync = rng.choice(tuple(TOLERATED))
    low, high = _RATES_HZ
    factor = 1.0
    while abs(factor - 1) <= TOLERATED[sync]:
        factor = LOWEST * (HIGHEST / LOWEST) ** rng.random()
    return ClocksTrial(
        sync, round(low * (high / low) ** rng.random()), factor, rng.random() < 0.5, rng.random()
    )


def run(plan: ClocksPlan, progress: Progress = unseen) -> ClocksOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = ClocksOutcome(plan)
    rng = random.Random(f"clocks {plan.seed} {plan.board}")
    while outcome.clocks < plan.clocks:
        with _bench(plan.board) as bench:
            for _ in range(min(_AT_ONCE, plan.clocks - outcome.clocks)):
                bench.try_clock(make(rng), outcome)
                outcome.clocks += 1
                progress(outcome.clocks / plan.clocks)
    return outcome


@contextlib.contextmanager
def _bench(board: str) -> Iterator["ClocksBench"]:
    with SimulatedBoard(board, Fraction(100)) as run:
        yield ClocksBench(run)


class ClocksBench:
    """A board on a clock that changes."""

    def __init__(self, run: SimulatedBoard) -> None:
        self.sim, self.board, self.world = run.simulator, run.board, run.link.world
        self.board.write_setting("bus_timeout_ms", 60_000)

    def try_clock(self, trial: ClocksTrial, outcome: ClocksOutcome) -> None:
        """Give the board the right clock, then the wrong one, and see what it says."""
        self._set(trial)
        outcome.in_motion += trial.moves
        try:
            if trial.moves:
                self._arm_and_run(trial)
                self._change(trial)
                self.world.wait(trial.named_s)
                name = self._fault()
            else:
                self._change(trial)
                self.world.wait(trial.named_s)
                name = self._refused_at_rest(trial)
        except BoardError as error:
            name = ""
            outcome.complaints.append(f"{trial.text}: {error}")
        else:
            if not name:
                outcome.complaints.append(f"{trial.text}: not named, axis {self._state()}")
        outcome.named[name] = outcome.named.get(name, 0) + 1
        self._recover()

    def _set(self, trial: ClocksTrial) -> None:
        """Set the board to the right clock, and let it know that clock."""
        self.sim.clock(f"hz {trial.hz}")
        self.board.set_pixel_hz(Fraction(trial.hz))
        self.board.write_setting("sync", regs.SYNCS[trial.sync])
        self.world.wait(3 / trial.hz)
        if trial.sync == "lock":
            snapshot.await_measured(self.board, self.world, 1 / trial.hz)
        else:
            self.world.wait(3 / trial.hz)
        LineUpload(self.board, 0, queue_entries(Line((2,) * _LINE_PX, PLAIN))).push()

    def _change(self, trial: ClocksTrial) -> None:
        """Make the clock another one, at any phase of its period."""
        self.world.wait(trial.phase / trial.hz)
        wrong = Fraction(trial.hz) * Fraction(trial.factor).limit_denominator(1000)
        self.sim.clock(f"hz {wrong.numerator}/{wrong.denominator}")

    def _arm_and_run(self, trial: ClocksTrial) -> None:
        self.board.command("arm", [0])
        end_s = self.world.now_s() + 60 / trial.hz + 1
        while self._state() != "running":
            if self.world.now_s() > end_s:
                raise BoardError(f"does not start: {self._state()} {self._fault()}")
            self.world.wait(1 / trial.hz)
        self.world.wait(4 / trial.hz)

    def _refused_at_rest(self, trial: ClocksTrial) -> str:
        """Return what keeps a line from following the clock; empty if it runs."""
        try:
            self.board.command("arm", [0])
        except BoardError:
            return "refused"
        self.world.wait(max(trial.named_s, 6 / (trial.hz * trial.factor) + _ARMED_S))
        name, pixel = self._fault(), self.board.axis(0)["pixel"]
        if not name or pixel > NAMED_EDGES:
            return ""
        return f"{name} in pixel {pixel}" if pixel else f"{name} before the first step"

    def _fault(self) -> str:
        return self.board.fault_name()

    def _state(self) -> str:
        return regs.axis_state(self.board.axis(0)["axis_state"])

    def _recover(self) -> None:
        for name in ("stop", "clear_fault", "discard"):
            self.world.wait(0.02)
            with contextlib.suppress(BoardError):
                self.board.command(name, [0])
