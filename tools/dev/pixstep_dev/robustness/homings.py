# SPDX-License-Identifier: MIT
"""Homing and measure-play by switches that bounce, on mechanics of every kind.

Every plant has play, a hysteresis, a delay of its contact and bounces of its own; half of the
switches are limit switches too. Its load is put somewhere. The axis homes from there; then the play
is measured. Both must be right to a step:

    contact  ______/-\\_/--\\_/---------    2 to 10 more edges within 1 to 20,000 ticks, as it
                   |<- bounce ->|         closes and as it opens
    step     __|__________________|___    a step of the slow legs takes longer than that
"""

import random
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.board import boards
from pixstep.board.errors import BoardError
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.moves import homing, legs, play_measurement
from pixstep.moves.fast import Acceleration
from pixstep.moves.legs import shared_limits
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard

PIXEL_HZ = Fraction(200)
BOUNCES = (2, 4, 6, 8, 10)
FILTERS_US = (1000, 2000)  # one is longer than any bouncing, one is not
MOST_BOUNCE_TICKS = 20_000
_RAMP = Acceleration((2, 12, 30, 44, 60), haps=5, source="the campaign's profile")
_SLOW = {PLAIN: 1, SMOOTH: 2}  # steps/px: 40,000 ticks a step at least
_MOST_DELAY_TICKS = 16_000  # beside the bounces, so that both are shorter than a slow step
_MOST_START = 1200
_TRAVEL = 3500  # either way
_OVER = 1000  # beyond a limit switch that is sought quickly
_SHARED = 0.5
_SETTLE_S = 0.02
_AT_ONCE = 10  # plants on one simulator


@dataclass(frozen=True)
class HomingsPlan:
    """So many plants on one board; `bounces_ticks`: the shortest and the longest bouncing."""

    board: str
    plants: int
    seed: int = 1
    bounces_ticks: tuple[int, int] = (1, MOST_BOUNCE_TICKS)


@dataclass
class HomingsOutcome:
    """What happened. `complaints` is empty if every switch was found to a step."""

    plan: HomingsPlan
    plants: int = 0
    homed_off_steps: dict[int, int] = field(default_factory=dict)  # so often so far away
    play_off_steps: dict[int, int] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class HomingPlant:
    """The mechanics of one axis, lengths in steps, times in ticks."""

    axis: int
    direction: int
    shared: bool  # the home switch is the limit switch of its direction, too
    joined: bool  # and it is on the pin of that limit as well
    decode: str
    play: int
    hysteresis: int
    start: int
    delay: int
    bounce: int
    bounce_ticks: int
    seed: int

    @property
    def knobs(self) -> str:
        """The plant as the simulator takes it: in minus direction it closes at low positions."""
        return (
            f"home=0,hyst={self.hysteresis},travel={self.travel},over={_OVER},play={self.play},"
            f"active={'high' if self.direction < 0 else 'low'},start={self.start},"
            f"delay={self.delay},bounce={self.bounce},bounce_ticks={self.bounce_ticks},"
            f"seed={self.seed}"
        )

    @property
    def travel(self) -> str:
        """From one limit switch to the other: the pin of a shared one trips as that closes.

        The simulator's limit switches have no hysteresis. A step further in, a limit is never
        tripped where the home switch has opened.
        """
        ends = [-_TRAVEL, _TRAVEL]
        if self.shared and self.joined:
            ends[self.direction > 0] = 1 if self.direction > 0 else -self.hysteresis - 1
        return "..".join(map(str, ends))

    @property
    def limit(self) -> str:
        """The limit that the home switch is, too."""
        return "none" if not self.shared else "plus" if self.direction > 0 else "minus"

    @property
    def closes_at(self) -> int:
        """Where the motor is as the switch closes: in minus direction it pulls the load."""
        return 0 if self.direction > 0 else -self.hysteresis - self.play

    def plan(self) -> legs.HomingPlan:
        """Return how it is to be homed."""
        request = legs.HomingRequest(
            self.axis,
            self.direction,
            slow=_SLOW[self.decode],
            search_steps=3 * _TRAVEL,
            decode=self.decode,
        )
        return legs.plan(_RAMP, request, PIXEL_HZ)


def plant(rng: random.Random, plan: HomingsPlan, direction: int) -> HomingPlant:
    """Return random mechanics whose contact moves within a slow step."""
    bounce = rng.choice(BOUNCES)
    shortest, longest = plan.bounces_ticks
    ticks = round(shortest * (longest / shortest) ** rng.random())
    return HomingPlant(
        axis=rng.randrange(boards.load(plan.board).axes),
        direction=direction,
        shared=rng.random() < _SHARED and boards.load(plan.board).all_features,
        joined=rng.random() < _SHARED,
        decode=rng.choice((PLAIN, SMOOTH)),
        play=rng.choice((0, rng.randint(1, 60), rng.randint(61, 1500))),
        hysteresis=rng.randint(0, 40),
        start=rng.randint(-_MOST_START, _MOST_START),
        delay=rng.choice((0, rng.randint(0, _MOST_DELAY_TICKS))),
        bounce=bounce,
        bounce_ticks=max(bounce, ticks),
        seed=rng.randrange(1 << 32),
    )


def run(plan: HomingsPlan, progress: Progress = unseen) -> HomingsOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = HomingsOutcome(plan)
    rng = random.Random(f"{plan.seed} {plan.board}")
    direction = 1
    while outcome.plants < plan.plants:
        many = min(_AT_ONCE, plan.plants - outcome.plants)
        plants = [plant(rng, plan, direction) for _ in range(many)]
        _try_all(plan.board, plants, outcome, progress)
        direction = -direction
    return outcome


def _try_all(
    name: str, plants: list[HomingPlant], outcome: HomingsOutcome, progress: Progress
) -> None:
    """Home and measure plants of one direction, one after the other on one simulator."""
    first = {(0, axis): plants[0].knobs for axis in range(boards.load(name).axes)}
    with SimulatedBoard(name, PIXEL_HZ, plants=first) as run:
        run.set_up(PIXEL_HZ, [*range(boards.load(name).axes)])
        # What closes at high positions in plus direction closes at low ones in minus direction.
        run.board.write_setting("inputs_inverted", 0 if plants[0].direction > 0 else 2)
        run.board.write_setting("input_filter_us", FILTERS_US[plants[0].seed % 2])
        for found in plants:
            _try(run, found, outcome)
            outcome.plants += 1
            progress(outcome.plants / outcome.plan.plants)


def _try(run: SimulatedBoard, plant: HomingPlant, outcome: HomingsOutcome) -> None:
    """Put the load of a plant somewhere, home it and measure its play."""
    word = shared_limits(0, plant.axis, plant.limit)
    run.board.write_setting("home_is_limit", word)
    run.simulator.knobs(0, plant.axis, plant.knobs)
    run.simulator.wait_s(_SETTLE_S)
    try:
        homing.home(run.board, plant.plan(), PIXEL_HZ, run.link.world)
        off = run.simulator.plant(0, plant.axis)[0] - plant.closes_at
        _note(outcome, outcome.homed_off_steps, plant, "homed", off)
        found = play_measurement.measure(
            run.board, plant.plan(), PIXEL_HZ, run.link.world, repeat=2
        )
        for apart in found.plays:
            off = round(apart) - plant.play - plant.hysteresis
            _note(outcome, outcome.play_off_steps, plant, "play", off)
    except (BoardError, UserError) as error:
        outcome.complaints.append(f"plant {outcome.plants}: {error}: {plant}")
        run.board.command("clear_fault", [])


def _note(
    outcome: HomingsOutcome, counts: dict[int, int], plant: HomingPlant, what: str, off: int
) -> None:
    counts[off] = counts.get(off, 0) + 1
    if abs(off) > 1:
        outcome.complaints.append(f"plant {outcome.plants}: {what} {off} steps off: {plant}")
