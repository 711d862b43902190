# SPDX-License-Identifier: MIT
"""Which lines were printed, by the edges on the pins alone.

The scanning motor rests for a pixel at both ends of a line, so its edges fall into bursts. Where
the stepping motor is during a burst says which line it belongs to.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from pixstep.simulation.logs import AxisEdges, read_edges
from pixstep_dev.jobs.press import PITCH, PIXEL_HZ, PLACES, Press

_TICK_HZ = 16_000_000
_GAP = 0.9 * _TICK_HZ / float(PIXEL_HZ)


@dataclass(frozen=True)
class Burst:
    """Steps of the scanning motor without a rest of a pixel: how many, at which line's place."""

    edges: int
    line: float


@dataclass(frozen=True)
class Passes:
    """What was printed: full passes by line, all edges of the scanning motor.

    `ends` are where the motors end, `made` how many steps they have made.
    """

    full: Counter[int]
    edges: int
    ends: dict[str, int]
    made: dict[str, int]


def of(press: Press, start_steps: int = 0) -> Passes:
    """Read the edges of a run; `start_steps` is where the stepping motor begins line 1."""
    log = read_edges(press.edges)
    scan, step = (log.axis(*PLACES[name]) for name in ("M39", "M41"))
    bursts = _bursts(scan, step, start_steps)
    full = Counter(
        int(one.line) for one in bursts
        if one.line == int(one.line) and 1 <= one.line <= press.job.lines
        and one.edges == press.steps(int(one.line))
    )  # fmt: skip
    ends = {name: int(log.axis(*place).directions().sum()) for name, place in PLACES.items()}
    made = {name: len(log.axis(*place).rising) for name, place in PLACES.items()}
    return Passes(full, sum(one.edges for one in bursts), ends, made)


def _bursts(scan: AxisEdges, step: AxisEdges, start_steps: int) -> list[Burst]:
    cycles = scan.rising
    if not len(cycles):
        return []
    breaks = np.flatnonzero(np.diff(cycles) > _GAP) + 1
    places = np.cumsum(step.directions())
    found = []
    for part in np.split(cycles, breaks):
        before = int(np.searchsorted(step.rising, part[len(part) // 2]))
        at = int(places[before - 1]) if before else 0
        found.append(Burst(len(part), (at - start_steps) / PITCH + 1))
    return found
