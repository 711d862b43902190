# SPDX-License-Identifier: MIT
"""The verdict on one leg of a homing, from its STEP edges alone: speeds and exact instants."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import ceil, sqrt
from typing import TYPE_CHECKING

from pixstep.lazy import lazy
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import edge_tick
from pixstep.moves.homing import Leg
from pixstep.moves.legs import HomingPlan
from pixstep.simulation import verdict
from pixstep.simulation.edges import AxisEdges

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

_NEAR = 2  # ticks: a leg's beginning as its first edge tells it, and roundings


@dataclass(frozen=True)
class JudgedLeg:
    """What the edges of a leg say: steps in each pixel, steps/s, ticks off the exact instants."""

    counts: list[int]
    fastest_steps_s: float
    max_edge_error_ticks: float | None  # None where the speeds alone are wrong
    reasons: list[str]


def leg_edges(edges: AxisEdges, leg: Leg, tick_hz: int) -> AxisEdges:
    """Return the edges made while a leg was; those of DIR from the beginning on."""
    low, high = (round(when * tick_hz) for when in (leg.began_s, leg.ended_s))
    steps = (edges.step_cycles > low) & (edges.step_cycles <= high)
    turns = edges.direction_cycles <= high
    return AxisEdges(
        edges.step_cycles[steps],
        edges.step_levels[steps],
        edges.direction_cycles[turns],
        edges.direction_levels[turns],
    )


def judge_leg(
    plan: HomingPlan,
    leg: Leg,
    edges: AxisEdges,
    period: Fraction,
    *,
    tick_hz: int,
    stopped: bool,
) -> JudgedLeg:
    """Judge the edges of one leg; one that a fault has `stopped` ends at once, inside a pixel."""
    rising, signs = edges.rising, edges.directions()
    counts = pixel_counts(rising, leg, period)
    reasons = []
    if int(signs.sum()) != leg.steps:
        reasons.append(f"{int(signs.sum())} STEP edges, the board says {leg.steps}")
    if len(np.unique(signs)) > 1:
        reasons.append("steps in both directions")
    found = _smooth_findings if leg.decode == SMOOTH else _plain_findings
    reasons += found(plan, counts, stopped=stopped)
    error_ticks = None
    if not reasons:
        error_ticks, reasons = _exact_findings(
            leg, counts[: len(counts) - stopped], edges, period, tick_hz
        )
    fastest = _fastest(rising, boundary_speeds(leg, counts), period, tick_hz)
    return JudgedLeg(counts, fastest, error_ticks, reasons)


def pixel_counts(rising: np.ndarray, leg: Leg, period: Fraction) -> list[int]:
    """Return the steps in each pixel, told from where the first edge is in the planned first pixel.

    Of n steps it comes after 1/n of a plain pixel, 1/sqrt(n) of a smooth one that starts from rest.
    """
    if not len(rising):
        return []
    first = leg.first_steps_px
    share = 1 / sqrt(first) if leg.decode == SMOOTH else Fraction(1, first)
    begin = int(rising[0]) - ceil(period * share)
    pixels = -(-(int(rising[-1]) - begin - _NEAR) // period)
    bounds = [begin + edge_tick(pixel, period) + _NEAR for pixel in range(max(1, pixels) + 1)]
    return [int(count) for count in np.diff(np.searchsorted(rising, bounds, side="right"))]


def boundary_speeds(leg: Leg, counts: list[int]) -> tuple[int, ...]:
    """Return the speeds that a leg has between its pixels, of a plain leg those of its pixels."""
    return Line(tuple(counts)).speeds if leg.decode == SMOOTH else (0, *counts, 0)


def _fastest(rising: np.ndarray, speeds: tuple[int, ...], period: Fraction, tick_hz: int) -> float:
    """Return the fastest speed, steps/s: by the pixels, or by the shortest interval if slower."""
    if len(rising) < 2:
        return 0.0
    return min(float(tick_hz / np.diff(rising).min()), float(max(speeds) * (tick_hz / period)))


def _within(entries: tuple[int, ...], before: int, after: int) -> bool:
    """True if a change of speed lies within one of the profile's own."""
    low, high = sorted((before, after))
    return low == high or any(a <= low and high <= b for a, b in pairwise(entries))


def _plain_findings(plan: HomingPlan, counts: list[int], *, stopped: bool) -> list[str]:
    """Require no pixel faster than the last entry and no jump larger than the profile's own.

    Where a fault has `stopped` the leg that one is no jump.
    """
    entries = (0, *plan.ramp.counts)
    found = []
    if counts and max(counts) > entries[-1]:
        found.append(f"{max(counts)} steps in a pixel, HAPs allow {entries[-1]}")
    for before, after in pairwise((0, *counts[:-1]) if stopped else (0, *counts, 0)):
        if not _within(entries, before, after):
            found.append(f"the speed jumps from {before} to {after} steps/pixel")
    return found


def _smooth_findings(plan: HomingPlan, counts: list[int], *, stopped: bool) -> list[str]:
    """Require boundary speeds up to the last entry's, no pixel accelerating more than the profile.

    Of a leg that was not `stopped` the way down is the way up mirrored. All speeds behind a wrong
    pixel are wrong too, so only the first finding is told.
    """
    entries = (0, *plan.ramp.speeds(SMOOTH))
    speeds = Line(tuple(counts[: len(counts) - stopped])).speeds
    for pixel, (before, after) in enumerate(pairwise(speeds), 1):
        if after > entries[-1]:
            return [f"{after} steps/pixel after pixel {pixel}, HAPs allow {entries[-1]}"]
        if not _within(entries, before, after):
            return [f"the speed changes from {before} to {after} steps/pixel in pixel {pixel}"]
    if not stopped and speeds[-1]:
        return [f"ends at {speeds[-1]} steps/pixel, not at rest"]
    if not stopped and speeds != speeds[::-1]:
        return ["the way down is not the way up mirrored"]
    return []


def _exact_findings(
    leg: Leg, counts: list[int], edges: AxisEdges, period: Fraction, tick_hz: int
) -> tuple[float | None, list[str]]:
    """Require every edge within a tick of the exact instant of the pixels made; how far at most."""
    steps = sum(counts)
    if not steps:
        return None, []
    negative = leg.steps < 0
    signed = tuple(-count for count in counts) if negative and leg.decode == PLAIN else counts
    line = Line(tuple(signed), leg.decode, negative=negative, clocked=False)
    whole = edges.step_cycles <= edges.rising[steps - 1]
    made = AxisEdges(
        edges.step_cycles[whole],
        edges.step_levels[whole],
        edges.direction_cycles,
        edges.direction_levels,
    )
    judged = verdict.judge_axis(line, period, made, tick_hz=tick_hz)
    return round(judged.max_edge_error_ticks, 6), judged.reasons
