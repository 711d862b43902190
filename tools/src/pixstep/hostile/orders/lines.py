# SPDX-License-Identifier: MIT
"""Random lines of a wanted speed, from one step a second to the fastest that a board can make."""

import random
from dataclasses import dataclass

from pixstep.hostile.orders.actions import Entries
from pixstep.lines.rational import TIMER_HZ
from pixstep.lines.runs import MARK_END, MARK_NEGATIVE, MARK_SMOOTH, MARK_START, MARK_WAIT_FOR_EDGE

FASTEST = 60_000  # steps/s
_SHORTEST_TICKS = {"uno": 80, "mega": 300}  # every axis of the board at once
_SMOOTH_TICKS = {"uno": 300, "mega": 1600}
_REVERSAL_TICKS = 5000  # above what any board needs to turn round
# Of lines that wait for no clock; above it four axes may ask for more than the Mega can decode.
PIXEL_HZ = {"uno": (1, 3, 10, 30, 100, 300), "mega": (1, 3, 10, 30, 100)}
CLOCK_HZ = {"uno": (30, 100, 300), "mega": (30, 100)}  # that a board keeps up with
_LASTS_S = 2
_SPARSE = 6  # pairs of a single step and a rest


@dataclass(frozen=True)
class Speed:
    """Steps per second of a line and the pixel frequency that it is made for."""

    steps_s: float
    pixel_hz: int

    @property
    def count(self) -> int:
        """Steps of a pixel, 0 if one takes more than a pixel."""
        return int(self.steps_s / self.pixel_hz)


def speed(rng: random.Random, board: str, hz: int, *, smooth: bool) -> Speed:
    """Return a speed from 1 step/s up, evenly spread over its logarithm."""
    shortest = (_SMOOTH_TICKS if smooth else _SHORTEST_TICKS)[board]
    most = min(FASTEST, TIMER_HZ / shortest)
    return Speed(most ** rng.random(), hz)


def entries(rng: random.Random, chosen: Speed, *, smooth: bool, clocked: bool) -> Entries:
    """Return the queue entries of a line."""
    mark = MARK_START | (MARK_WAIT_FOR_EDGE if clocked else 0)
    if smooth and chosen.count >= 4:
        mark |= MARK_SMOOTH | (MARK_NEGATIVE if rng.random() < 0.5 else 0)
        runs = _smooth_runs(rng, chosen)
    else:
        runs = _plain_runs(rng, chosen)
    return ((mark, 0), (0, 0), *runs, (MARK_END, 0))


def _pixels(rng: random.Random, chosen: Speed) -> int:
    """Most lines outlast a trial, some are over soon."""
    return rng.randint(1, 3) if rng.random() < 0.2 else _LASTS_S * chosen.pixel_hz + 1


def _smooth_runs(rng: random.Random, chosen: Speed) -> list[tuple[int, int]]:
    quarter = chosen.count // 4
    rise = [(quarter, 1), (3 * quarter, 1)]
    return [*rise, (4 * quarter, _pixels(rng, chosen)), *reversed(rise)]


def _plain_runs(rng: random.Random, chosen: Speed) -> list[tuple[int, int]]:
    sign = rng.choice((-1, 1))
    lead = [(0, rng.randint(1, 3))] if rng.random() < 0.1 else []
    if chosen.count == 0:
        rest = max(1, int(chosen.pixel_hz / chosen.steps_s) - 1)
        return [*lead, *[(sign, 1), (0, rest)] * _SPARSE, (sign, 1)]
    count = sign * chosen.count
    turns = chosen.count * _REVERSAL_TICKS * chosen.pixel_hz < TIMER_HZ and rng.random() < 0.3
    if turns:
        return [*lead, *[(count, 1), (-count, 1)] * _SPARSE]
    return [*lead, (count, _pixels(rng, chosen))]
