# SPDX-License-Identifier: MIT
"""Random pairs and triples of commands, many an hour: counted, judged, each to be had again.

A batch of trials shares one simulator. Trial `seed:index` always follows the same trials of its
batch, so that it happens again to the cycle.
"""

import random
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.progress import Progress, unseen
from pixstep.simulation.simulator import SimulatorError
from pixstep_dev.robustness.orders import lines, together, trials
from pixstep_dev.robustness.orders.guard import Guard
from pixstep_dev.robustness.orders.world import OrdersWorld

BATCH = 50
_DECADES = (10, 100, 1000, 10_000, 100_000)
_KEPT = 200  # complaints that an outcome holds


@dataclass(frozen=True)
class OrdersPlan:
    """So many trials of one board, from trial `first` on."""

    board: str
    count: int
    seed: int = 1
    first: int = 0
    estop: float = 0.0  # share of the trials in which the emergency stop is pressed
    together: bool = False  # axes armed together, instead of pairs of commands
    image: Path | None = None


@dataclass(frozen=True)
class Failure:
    """A trial that broke a promise; `seed:index` replays it."""

    seed: int
    index: int
    tried: tuple[str, ...]
    complaints: tuple[str, ...]

    @property
    def text(self) -> str:
        """One line."""
        more = f" (and {len(self.complaints) - 1} more)" if len(self.complaints) > 1 else ""
        return f"{self.seed}:{self.index} {', '.join(self.tried)}: {self.complaints[0]}{more}"


@dataclass
class OrdersOutcome:
    """What happened."""

    plan: OrdersPlan
    trials: int = 0
    edges: int = 0
    cycles: int = 0
    # Of a command and the next one.
    pairs: Counter[tuple[str, str]] = field(default_factory=Counter[tuple[str, str]])
    # Of trials, by the decade of steps/s that they stay below.
    speeds: Counter[int] = field(default_factory=Counter[int])
    faults: Counter[str] = field(default_factory=Counter[str])
    # Of axes armed together: all, none, split.
    started: Counter[str] = field(default_factory=Counter[str])
    failed: int = 0
    failures: list[Failure] = field(default_factory=list)


def run(plan: OrdersPlan, progress: Progress = unseen) -> OrdersOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = OrdersOutcome(plan)
    index = plan.first
    while index < plan.first + plan.count:
        end = min(index // BATCH * BATCH + BATCH, plan.first + plan.count)
        for _ in batch(plan, index, end, outcome):
            progress(outcome.trials / plan.count)
        index = end
    return outcome


def batch(
    plan: OrdersPlan, first: int, end: int, outcome: OrdersOutcome
) -> Iterator[trials.OrdersTrial]:
    """Do the trials of a batch from its beginning, count those from `first` on; yield each."""
    index = first // BATCH * BATCH
    while index < end:
        with OrdersWorld(plan.board, plan.image, clock_hz(plan, index)) as world:
            guard = Guard(world)
            good = True
            while good and index < end:
                trial = make(plan, index, world)
                begun, made = world.cycle, _edges(world)
                good = attempt(guard, trial)
                if index >= first:
                    outcome.cycles += world.cycle - begun
                    outcome.edges += _edges(world) - made
                    _count(outcome, trial, guard, index)
                    yield trial
                index += 1


def replay(plan: OrdersPlan, index: int, say: Callable[[str], None]) -> bool:
    """Do trial `index` again behind those of its batch, and tell of every action; True if good."""
    number = index // BATCH * BATCH
    good = True
    while number <= index:
        with OrdersWorld(plan.board, plan.image, clock_hz(plan, number)) as world:
            guard = Guard(world)
            good = True
            while good and number <= index:
                guard.say = say if number == index else None
                good = attempt(guard, make(plan, number, world))
                number += 1
    return good


def clock_hz(plan: OrdersPlan, index: int) -> int:
    """Return the pixel clock of a trial's batch."""
    rng = random.Random(f"{plan.board} clock {plan.seed}:{index // BATCH}")
    return rng.choice(lines.clock_hz(plan.board))


def make(plan: OrdersPlan, index: int, world: OrdersWorld) -> trials.OrdersTrial:
    """Return a trial by its number."""
    place = trials.TrialBoard(plan.board, world.axes, world.clock_hz)
    if plan.together:
        return together.make(random.Random(f"together {plan.seed}:{index}"), place)
    rng = random.Random(f"{plan.board} {plan.seed}:{index}")
    return trials.make(rng, place, plan.estop)


def attempt(guard: Guard, trial: trials.OrdersTrial) -> bool:
    """Do a trial and recover; False if anything did not hold: the simulator is then of no use."""
    guard.complaints.clear()
    guard.seen_faults.clear()
    guard.started = ""
    try:
        before = [guard.world.edges(axis).made for axis in range(guard.world.axes)]
        for action in trial.actions:
            guard.do(action)
        if isinstance(trial, together.TogetherTrial):
            guard.started = together.judge(guard, trial, before)
        return guard.recover() and not guard.complaints
    except SimulatorError as error:
        guard.complain(str(error))
        return False


def _edges(world: OrdersWorld) -> int:
    return sum(world.edges(axis).made for axis in range(world.axes))


def _count(outcome: OrdersOutcome, trial: trials.OrdersTrial, guard: Guard, index: int) -> None:
    outcome.trials += 1
    outcome.pairs.update(zip(trial.tried, trial.tried[1:], strict=False))
    outcome.speeds[next(top for top in _DECADES if trial.steps_s <= top)] += 1
    outcome.faults.update(guard.seen_faults)
    if guard.started:
        outcome.started[guard.started] += 1
    if guard.complaints:
        outcome.failed += 1
        if len(outcome.failures) < _KEPT:
            outcome.failures.append(
                Failure(outcome.plan.seed, index, trial.tried, tuple(guard.complaints))
            )
