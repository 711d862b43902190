# SPDX-License-Identifier: MIT
"""A simulated homing, what it left behind, and its verdict: edges, captured edges, plant."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from math import ceil, sqrt
from pathlib import Path
from typing import NotRequired, TypedDict

from pixstep.board.errors import BoardError
from pixstep.board.state import TRIP_CLOSED, Trip
from pixstep.errors import AskedText, UserError
from pixstep.lazy import np
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import edge_tick, hz_text
from pixstep.moves.homing import Homed, HomingError, HomingLeg, LegData, legs_as_json
from pixstep.moves.legs import INVERTED, HomingPlan
from pixstep.simulation import verdict
from pixstep.simulation.job import Experiment
from pixstep.simulation.logs import AxisEdges

HYSTERESIS = 8  # steps, of a simulated home switch unless its knobs say otherwise
_NEAR = 2  # ticks: a leg's beginning as its first edge tells it, and roundings
IN_VAIN = ("home_not_found", "home_stuck")  # faults of a leg that was made to its end
_TICKS = 1 << 32  # the board's tick count wraps
# The capture register keeps the newest edge until its interrupt has read it: of a contact that
# bounces back within this time it may hold a later closing. Longest wait by `pixstep bench`.
CAPTURE_LATENCY_TICKS = 200


@dataclass(frozen=True)
class HomeJob(Experiment):
    """A homing and the world it happens in; `plant` are the simulator's knobs, "home=2000,..."."""

    plan: HomingPlan
    board: str
    pixel_hz: Fraction
    plant: str
    inverted: str = "none"
    filter_us: int | None = None
    home_is_limit: str = "none"
    seed: int = 1
    scale: units.Scale | None = None  # of the motor, if a machine file gives it

    @property
    def knobs(self) -> dict[str, str]:
        """The plant's knobs by name."""
        return dict(word.partition("=")[::2] for word in self.plant.split(","))

    def knob(self, name: str, default: int = 0) -> int:
        """Return a knob that is a whole number; raises UserError if it is none."""
        text = self.knobs.get(name, str(default))
        try:
            return int(text)
        except ValueError:
            raise UserError(AskedText(
                "{plant}: {text} is not a whole number", text=f"{name}={text!r}"
            )) from None  # fmt: skip

    @property
    def home_tripped_level(self) -> int:
        """The pin's level that the board takes for a closed home switch."""
        return INVERTED[self.inverted] & 1

    @property
    def closes_above(self) -> bool:
        """True if the board sees the home switch closed above its place, not below."""
        closed_level = int(self.knobs.get("active") == "high")
        return closed_level == self.home_tripped_level

    @property
    def closes_at(self) -> int | None:
        """The load's position at which the board sees the home switch close, if there is one."""
        if "home" not in self.knobs:
            return None
        return self.knob("home") - (0 if self.closes_above else self.knob("hyst", HYSTERESIS))

    @property
    def travel(self) -> tuple[int, ...]:
        """Where the limit switches trip, minus and plus; empty if there are none."""
        low, _, high = self.knobs.get("travel", "").partition("..")
        try:
            return (int(low), int(high)) if low and high else ()
        except ValueError:
            raise UserError(AskedText(
                "{plant}: travel={low}..{high}: two whole numbers", low=low, high=high
            )) from None  # fmt: skip

    def home_edges(self, path: Path) -> list[tuple[int, int]]:
        """Return (cycle, 1 tripped or 0) of the home switch's edges as the board takes them."""
        tripped_level = str(self.home_tripped_level)
        rows = (row.split(",") for row in path.read_text(encoding="ascii").split()[1:])
        wanted = ["0", str(self.plan.axis), "home"]
        return [
            (int(cycle), int(level == tripped_level))
            for cycle, *where, level in rows
            if where == wanted
        ]


@dataclass
class HomeRun:
    """What a simulated homing left behind; cycles are the simulator's."""

    job: HomeJob
    homed: Homed | None = None
    error: BoardError | None = None
    edges: AxisEdges = field(default_factory=AxisEdges)
    switch_edges: list[tuple[int, int]] = field(default_factory=list)  # (cycle, 1 closed)
    counted_steps: int = 0
    load_steps: int = 0

    @property
    def legs(self) -> tuple[HomingLeg, ...]:
        """The legs made, of a homing that failed too."""
        if self.homed:
            return self.homed.legs
        return self.error.legs if isinstance(self.error, HomingError) else ()


class LegSummary(LegData):
    """A leg and the verdict's figures of it."""

    pixel_counts: list[int]
    fastest_steps_s: float
    max_edge_error_ticks: float | None
    switch_edge_cycle: int | None


class HomeSummary(TypedDict):
    """All figures of a simulated homing: summary.json; some only if it found the switch."""

    verdict: str
    reasons: list[str]
    fault: str
    board: str
    axis: int
    direction: str
    decode: str
    pixel_hz: str
    haps: int
    haps_entry_steps_px: int
    haps_entry_steps_s: float
    fastest_steps_s: float
    plant: str
    captures: int
    capture_offset_ticks: int | None
    counted_steps: int
    load_at_rest_steps: int
    legs: list[LegSummary]
    found: bool
    edge: dict[str, int] | None
    position_steps: int | None
    beyond_edge_steps: NotRequired[int]
    switch_closes_at_steps: NotRequired[int | None]
    load_beyond_switch_steps: NotRequired[int | None]
    home_s: NotRequired[float]
    plots: NotRequired[list[str]]


def judge(run: HomeRun) -> HomeSummary:
    """Return the verdict: summary.json of a homing, its reasons empty if it passes."""
    job = run.job
    reasons = [str(run.error)] if run.error else []
    offset = _capture_offset(run, reasons)
    legs = [_judge_leg(run, leg, offset, reasons) for leg in run.legs]
    fastest = max((leg["fastest_steps_s"] for leg in legs), default=0.0)
    summary: HomeSummary = {
        "verdict": "fail", "reasons": reasons, "fault": getattr(run.error, "name", ""),
        "board": job.board, "axis": job.plan.axis, "direction": job.plan.towards,
        "decode": job.plan.decode, "pixel_hz": hz_text(job.pixel_hz).removesuffix("/1"),
        "haps": len(job.plan.ramp.counts), "haps_entry_steps_px": job.plan.top,
        "haps_entry_steps_s": float(job.plan.top * job.pixel_hz),
        "fastest_steps_s": round(fastest, 3), "plant": job.plant,
        "captures": sum(leg.trip is not None for leg in run.legs), "capture_offset_ticks": offset,
        "counted_steps": run.counted_steps, "load_at_rest_steps": run.load_steps, "legs": legs,
        "found": False, "edge": None, "position_steps": None,
    }  # fmt: skip
    if run.homed:
        _note_found(run, run.homed, summary)
    if not reasons:
        summary["verdict"] = "pass"
    return summary


def switch_edges(run: HomeRun, leg: HomingLeg, trip: Trip) -> list[int]:
    """Return the cycles of the edges that may have been captured, by the simulator's own log.

    The first edge of the home switch that ends the leg, and others that follow it so soon that the
    capture register may have been overwritten.
    """
    wanted = int(trip.code == TRIP_CLOSED)
    low, high = (when * run.job.tick_hz for when in (leg.began_s, leg.ended_s))
    fitting = [
        cycle for cycle, closed in run.switch_edges if low <= cycle <= high and closed == wanted
    ]
    return [cycle for cycle in fitting if cycle - fitting[0] <= CAPTURE_LATENCY_TICKS]


def _capture_offset(run: HomeRun, reasons: list[str]) -> int | None:
    """Return the simulator's edges less the captured ticks, the same for all: the timers' start."""
    offsets = [
        {(edge - leg.trip.ticks) % _TICKS for edge in switch_edges(run, leg, leg.trip)}
        for leg in run.legs
        if leg.trip
    ]
    if not offsets:
        return None
    common = set.intersection(*offsets)
    if len(common) == 1:
        return common.pop()
    apart = [sorted(found) for found in offsets]
    reasons.append(f"captured ticks and switch edges are not a constant apart: {apart}")
    return None


def _judge_leg(run: HomeRun, leg: HomingLeg, offset: int | None, reasons: list[str]) -> LegSummary:
    """Judge one leg: its steps, its speeds, its captured edge; return its plain data."""
    in_vain = getattr(run.error, "name", "") in IN_VAIN
    stopped = run.error is not None and leg is run.legs[-1] and not in_vain
    edges, job, edge = leg_edges(run.edges, leg, run.job.tick_hz), run.job, None
    counts, fastest, error_ticks, found = judge_leg(
        job.plan, leg, edges, job.period, tick_hz=job.tick_hz, stopped=stopped
    )
    if leg.trip and offset is None:
        found.append("captured an edge of the home switch that the simulator does not know")
    elif leg.trip and offset is not None:
        captured, caught = leg.trip.ticks + offset, switch_edges(run, leg, leg.trip)
        (edge,) = [edge for edge in caught if (edge - captured) % _TICKS == 0]
        # The steps made at or before the simulator's edge must be the captured position.
        made = leg.start_steps + int(edges.directions()[edges.rising <= edge].sum())
        if made != leg.trip.position_steps:
            found.append(f"captured at position {leg.trip.position_steps}, the edges say {made}")
    reasons += [f"{leg.name}: {text}" for text in found]
    (data,) = legs_as_json((leg,))
    return {
        **data,
        "pixel_counts": counts,
        "fastest_steps_s": fastest,
        "max_edge_error_ticks": error_ticks,
        "switch_edge_cycle": edge,
    }


def _note_found(run: HomeRun, homed: Homed, summary: HomeSummary) -> None:
    """Judge where homing ended; note what was found."""
    job, edge, reasons = run.job, homed.edge, summary["reasons"]
    if homed.position_steps:
        reasons.append(f"ends at position {homed.position_steps}, not 0")
    if run.counted_steps != edge.position_steps + homed.position_steps:
        reasons.append(
            f"{run.counted_steps} steps counted from reset, the switch's edge was at "
            f"{edge.position_steps}"
        )
    beyond = None
    if job.closes_at is not None:
        beyond = job.plan.direction * (run.load_steps - job.closes_at)
        most = ceil(job.knob("delay") * job.plan.slow * job.pixel_hz / job.tick_hz)
        # With play between motor and load the load need not follow the last move back.
        if not job.knob("play") and not 0 <= beyond <= most:
            reasons.append(
                f"the load rests {beyond} steps beyond the place where its switch closes, its "
                f"delay explains 0 to {most}"
            )
    summary["found"] = True
    summary["edge"] = asdict(edge)
    summary["position_steps"] = homed.position_steps
    summary["beyond_edge_steps"] = homed.zeroed_steps
    summary["switch_closes_at_steps"] = job.closes_at
    summary["load_beyond_switch_steps"] = beyond
    summary["home_s"] = round(run.legs[-1].ended_s - run.legs[0].began_s, 6)


def leg_edges(edges: AxisEdges, leg: HomingLeg, tick_hz: int) -> AxisEdges:
    """Return the edges made while a leg was; those of DIR from the beginning on."""
    low, high = (round(when * tick_hz) for when in (leg.began_s, leg.ended_s))
    steps = (edges.step_cycles > low) & (edges.step_cycles <= high)
    turns = edges.direction_cycles <= high
    return AxisEdges(
        edges.step_cycles[steps], edges.step_levels[steps], edges.direction_cycles[turns],
        edges.direction_levels[turns],
    )  # fmt: skip


def judge_leg(
    plan: HomingPlan,
    leg: HomingLeg,
    edges: AxisEdges,
    period: Fraction,
    *,
    tick_hz: int,
    stopped: bool,
) -> tuple[list[int], float, float | None, list[str]]:
    """Judge the edges of one leg; one that a fault has `stopped` ends at once, inside a pixel.

    Return the steps in each pixel, the fastest speed in steps/s, how far off the exact instants its
    edges are at most, in ticks (None where the speeds alone are wrong), and what is wrong.
    """
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
    fastest = 0.0  # by the pixels, or by the shortest interval if that is slower
    if len(rising) > 1:
        by_pixels = float(max(boundary_speeds(leg, counts)) * (tick_hz / period))
        fastest = min(float(tick_hz / np.diff(rising).min()), by_pixels)
    return counts, fastest, error_ticks, reasons


def pixel_counts(rising: np.ndarray, leg: HomingLeg, period: Fraction) -> list[int]:
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


def boundary_speeds(leg: HomingLeg, counts: list[int]) -> tuple[int, ...]:
    """Return the speeds that a leg has between its pixels, of a plain leg those of its pixels."""
    return Line(tuple(counts)).speeds if leg.decode == SMOOTH else (0, *counts, 0)


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
    return found + [
        f"the speed jumps from {before} to {after} steps/pixel"
        for before, after in pairwise((0, *counts[:-1]) if stopped else (0, *counts, 0))
        if not _within(entries, before, after)
    ]


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
    leg: HomingLeg, counts: list[int], edges: AxisEdges, period: Fraction, tick_hz: int
) -> tuple[float | None, list[str]]:
    """Require every edge within a tick of the exact instant of the pixels made; how far at most."""
    steps = sum(counts)
    if not steps:
        return None, []
    negative = leg.steps < 0
    signed = tuple(-count for count in counts) if negative and leg.decode == PLAIN else counts
    line = Line(tuple(signed), leg.decode, negative=negative, clocked=False)
    whole = edges.step_cycles <= edges.rising[steps - 1]
    made = replace(
        edges, step_cycles=edges.step_cycles[whole], step_levels=edges.step_levels[whole]
    )
    judged = verdict.judge_axis(line, period, made, tick_hz=tick_hz)
    return round(judged.max_edge_error_ticks, 6), judged.reasons
