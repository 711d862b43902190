# SPDX-License-Identifier: MIT
"""The verdict on a simulated homing: from its STEP edges, its captured edges, its plant."""

from dataclasses import asdict
from math import ceil
from typing import NotRequired, TypedDict

from pixstep.board.state import TRIP_CLOSED, Trip
from pixstep.lines.units import hz_text
from pixstep.moves.homesim import HomeRun
from pixstep.moves.homing import Homed, Leg, LegData, legs_as_json
from pixstep.moves.legjudge import judge_leg, leg_edges

IN_VAIN = ("home_not_found", "home_stuck")  # faults of a leg that was made to its end
_TICKS = 1 << 32  # the board's tick count wraps
# The capture register keeps the newest edge until its interrupt has read it: of a contact that
# bounces back within this time it may hold a later closing. Longest wait by `pixstep bench`.
CAPTURE_LATENCY_TICKS = 200


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
        "verdict": "fail",
        "reasons": reasons,
        "fault": getattr(run.error, "name", ""),
        "board": job.board,
        "axis": job.plan.axis,
        "direction": job.plan.towards,
        "decode": job.plan.decode,
        "pixel_hz": hz_text(job.pixel_hz).removesuffix("/1"),
        "haps": len(job.plan.ramp.counts),
        "haps_entry_steps_px": job.plan.top,
        "haps_entry_steps_s": float(job.plan.top * job.pixel_hz),
        "fastest_steps_s": round(fastest, 3),
        "plant": job.plant,
        "captures": sum(leg.trip is not None for leg in run.legs),
        "capture_offset_ticks": offset,
        "counted_steps": run.counted_steps,
        "load_at_rest_steps": run.load_steps,
        "legs": legs,
        "found": False,
        "edge": None,
        "position_steps": None,
    }
    if run.homed:
        _note_found(run, run.homed, summary)
    if not reasons:
        summary["verdict"] = "pass"
    return summary


def switch_edges(run: HomeRun, leg: Leg, trip: Trip) -> list[int]:
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
        {(edge - trip.ticks) % _TICKS for edge in switch_edges(run, leg, trip)}
        for leg, trip in ((leg, leg.trip) for leg in run.legs)
        if trip
    ]
    if not offsets:
        return None
    common = set.intersection(*offsets)
    if len(common) == 1:
        return common.pop()
    apart = [sorted(found) for found in offsets]
    reasons.append(f"captured ticks and switch edges are not a constant apart: {apart}")
    return None


def _judge_leg(run: HomeRun, leg: Leg, offset: int | None, reasons: list[str]) -> LegSummary:
    """Judge one leg: its steps, its speeds, its captured edge; return its plain data."""
    in_vain = getattr(run.error, "name", "") in IN_VAIN
    stopped = run.error is not None and leg is run.legs[-1] and not in_vain
    edges = leg_edges(run.edges, leg, run.job.tick_hz)
    judged = judge_leg(
        run.job.plan, leg, edges, run.job.period, tick_hz=run.job.tick_hz, stopped=stopped
    )
    found = list(judged.reasons)
    edge = _captured_edge(run, leg, offset)
    if leg.trip:
        found += _position_findings(run, leg, leg.trip, edge)
    reasons += [f"{leg.name}: {text}" for text in found]
    (data,) = legs_as_json((leg,))
    return {
        **data,
        "pixel_counts": judged.counts,
        "fastest_steps_s": judged.fastest_steps_s,
        "max_edge_error_ticks": judged.max_edge_error_ticks,
        "switch_edge_cycle": edge,
    }


def _captured_edge(run: HomeRun, leg: Leg, offset: int | None) -> int | None:
    """Return the cycle of the switch's edge that was captured; None if there was none."""
    if not leg.trip or offset is None:
        return None
    captured = leg.trip.ticks + offset
    edges = switch_edges(run, leg, leg.trip)
    (edge,) = [edge for edge in edges if (edge - captured) % _TICKS == 0]
    return edge


def _position_findings(run: HomeRun, leg: Leg, trip: Trip, edge: int | None) -> list[str]:
    """Require the captured position to be the steps made at or before the simulator's edge."""
    if edge is None:
        return ["captured an edge of the home switch that the simulator does not know"]
    edges = leg_edges(run.edges, leg, run.job.tick_hz)
    made = leg.start_steps + int(edges.directions()[edges.rising <= edge].sum())
    if made == trip.position_steps:
        return []
    return [f"captured at position {trip.position_steps}, the edges say {made}"]


def _note_found(run: HomeRun, homed: Homed, summary: HomeSummary) -> None:
    """Judge where homing ended; note what was found."""
    edge, reasons = homed.edge, summary["reasons"]
    if homed.position_steps:
        reasons.append(f"ends at position {homed.position_steps}, not 0")
    if run.counted_steps != edge.position_steps + homed.position_steps:
        reasons.append(
            f"{run.counted_steps} steps counted from reset, the switch's edge was at "
            f"{edge.position_steps}"
        )
    summary["found"] = True
    summary["edge"] = asdict(edge)
    summary["position_steps"] = homed.position_steps
    summary["beyond_edge_steps"] = homed.zeroed_steps
    summary["switch_closes_at_steps"] = run.job.closes_at
    summary["load_beyond_switch_steps"] = _load_beyond(run, reasons)
    summary["home_s"] = round(run.legs[-1].ended_s - run.legs[0].began_s, 6)


def _load_beyond(run: HomeRun, reasons: list[str]) -> int | None:
    """Require the load at rest where its switch closes, but for the switch's delay; how far off.

    With play between motor and load the load need not follow the last move back.
    """
    job = run.job
    if job.closes_at is None:
        return None
    beyond = job.plan.direction * (run.load_steps - job.closes_at)
    most = ceil(job.knob("delay") * job.plan.slow * job.pixel_hz / job.tick_hz)
    if not job.knob("play") and not 0 <= beyond <= most:
        reasons.append(
            f"the load rests {beyond} steps beyond the place where its switch closes, its delay "
            f"explains 0 to {most}"
        )
    return beyond
