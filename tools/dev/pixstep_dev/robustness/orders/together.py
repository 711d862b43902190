# SPDX-License-Identifier: MIT
"""Axes armed together start together or not at all, whatever blocks come in between.

Two to four axes get the same line. Blocks that are repeated, refused, missing, too late or too big
and writes that are refused come before the axes are armed, between that and the start, and in
motion. All axes make the same edges, or none makes any; at the same cycles where they wait for the
pixel clock.
"""

import random
from dataclasses import dataclass

from pixstep.board import boards
from pixstep_dev.robustness.orders import lines
from pixstep_dev.robustness.orders.actions import (
    ASK,
    TELL,
    Action,
    BoardOrder,
    Coils,
    Entries,
    Frequency,
    Look,
    QueueBlock,
    Setting,
    Wait,
)
from pixstep_dev.robustness.orders.guard import Guard
from pixstep_dev.robustness.orders.trials import OrdersTrial, TrialBoard

DISTURBANCES = ("repeated", "skipped", "refused", "malformed", "late", "setting", "coil", "nothing")
_SPREAD_CYCLES = 16  # between the timers of the axes, which start two cycles after each other
_TOKEN = 77
_FASTEST = 20_000  # steps/s, of four axes
_STARTS_CYCLES = 480_000
_DONE_S = 0.05


@dataclass(frozen=True)
class TogetherTrial(OrdersTrial):
    """A trial with the axes that start together."""

    mask: int = 0
    clocked: bool = False


def make(rng: random.Random, place: TrialBoard) -> TogetherTrial:
    """Return a random trial."""
    tick_hz = boards.load(place.board).tick_hz
    clocked = rng.random() < 0.6
    hz = place.clock_hz if clocked else 30
    axes = sorted(rng.sample(range(place.axes), rng.randint(2, place.axes)))
    mask = sum(1 << axis for axis in axes)
    steps_s = hz * int((_FASTEST / hz) ** rng.random())
    entries = _line(steps_s // hz, clocked=clocked)
    token = _TOKEN if rng.random() < 0.4 else None
    tried = tuple(rng.choice(DISTURBANCES) for _ in range(3))
    made: list[Action] = [Frequency(hz, TELL), *[QueueBlock(axis, entries) for axis in axes]]
    made += [_disturbance(rng, tried[0], rng.choice(axes), entries, armed=False)]
    made += [BoardOrder("arm", mask, token, ASK), Wait(rng.randrange(_STARTS_CYCLES))]
    ahead = lines.go_ahead(tick_hz, hz) if token else 0
    made += [_disturbance(rng, tried[1], rng.choice(axes), entries, armed=True)]
    if token:
        made += [Wait(rng.randrange(_STARTS_CYCLES)), BoardOrder("go", 0, token, TELL, ahead)]
    made += [Wait(rng.randrange(_STARTS_CYCLES))]
    made += [_disturbance(rng, tried[2], rng.choice(axes), entries, armed=True)]
    lasts = (4 + ahead) * tick_hz // hz + _STARTS_CYCLES
    made += [
        Wait(lasts + (2 * tick_hz // hz if clocked else 0)),
        Look(),
        Wait(int(_DONE_S * tick_hz)),
        Look(),
    ]
    return TogetherTrial(tuple(made), tried, steps_s, mask, clocked)


def _line(count: int, *, clocked: bool) -> Entries:
    """A line of two pixels, which ends with its last edge at the same tick on every axis."""
    return ((0x21 if clocked else 0x01, 0), (0, 0), (count, 2), (2, 0))


def _disturbance(
    rng: random.Random, name: str, axis: int, entries: Entries, *, armed: bool
) -> Action:
    how = rng.choice((ASK, TELL))
    # An axis at rest is refused for good by a bad block: then the arming must be refused as well.
    match name:
        case "repeated":
            return QueueBlock(axis, entries, -1, how)
        case "skipped":
            return QueueBlock(axis, entries, rng.choice((1, 2, 7)), how)
        case "refused":
            return QueueBlock(axis, ((1, 0), (0, 0), (20_000, 1), (2, 0)), 0, how)
        case "malformed":
            return QueueBlock(axis, ((0x7FFF, 0),), 0, how)
        case "late" if armed:
            return QueueBlock(axis, _line(3, clocked=True)[:3], 0, how)
        case "setting":
            return Setting("backlash_policy", rng.choice((1, 2)), how)
        case "coil":
            return Coils(axis, (0,), how) if armed else Coils(0, (1,) * 4, how)
    return Wait(0)


def judge(guard: Guard, trial: TogetherTrial, before: list[int]) -> str:
    """Compare the axes; return "all", "none" or "split"."""
    world = guard.world
    axes = [axis for axis in range(world.axes) if trial.mask >> axis & 1]
    edges = [world.edges(axis) for axis in axes]
    made = [edge.made - before[axis] for axis, edge in zip(axes, edges, strict=True)]
    if not any(made):
        return "none"
    spread = max(edge.last for edge in edges) - min(edge.last for edge in edges)
    if len(set(made)) > 1 or (trial.clocked and spread > _SPREAD_CYCLES):
        said = guard.state.summary() if guard.state else "no reply"
        guard.complain(
            f"axes {axes} did not start together: {made} edges, the last at "
            f"{[edge.last for edge in edges]}; {said}"
        )
        return "split"
    return "all"
