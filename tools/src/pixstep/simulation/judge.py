# SPDX-License-Identifier: MIT
"""From what a run left behind to its verdict: summary.json, the rows of pixels.csv, the loads."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pixstep.lazy import np
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.lines.units import edge_tick, hz_text
from pixstep.reversals.compensate import strokes
from pixstep.simulation import clock_judge, pixel_clock, verdict
from pixstep.simulation.job import FREE, START, RunResult
from pixstep.simulation.logs import AxisPlant
from pixstep.simulation.pixel_clock import PixelGrid
from pixstep.simulation.report import PixelRow
from pixstep.simulation.summary import Load, Shares, Summary
from pixstep.simulation.verdict import AxisVerdict

_WORK = (1, 2, 3)  # the main loop's decoding and following; the rest of it looks for work


@dataclass
class Judgement:
    """The verdict of a run."""

    summary: Summary
    pixels: list[PixelRow]
    axes: list[AxisVerdict]
    grids: dict[int, PixelGrid] = field(default_factory=dict)  # of the axes that made a step
    kept: dict[int, clock_judge.ClockKeeping] = field(default_factory=dict)  # of those on the clock

    @property
    def passed(self) -> bool:
        """True only for a run without any finding."""
        return self.summary["verdict"] == "pass"


def judge(result: RunResult) -> Judgement:
    """Compare a run with the reference in every respect that can fail."""
    job, reasons = result.job, list(result.trouble)
    grids: dict[int, PixelGrid] = {}
    axes = [_judge_axis(result, axis, grids) for axis in sorted(job.lines)]
    zero = _common_zero(result, axes, grids, reasons)
    clock_edge = None
    if zero is not None and job.sync == START and any(line.clocked for line in job.lines.values()):
        clock_edge, reason = verdict.judge_clock(zero, job.clock_period, result.clock.seen)
        reasons += [reason] if reason else []
    rows: list[PixelRow] = []
    equal = {}
    for found in axes:
        mine = _pixel_rows(result, found.axis, grids.get(found.axis))
        equal[found.axis] = _judge_pixels(result, found, mine)
        rows += mine
    kept = _judge_clock(result, axes, grids)
    for (board, axis), edges in result.edges.axes.items():
        if (board or axis not in job.lines) and len(edges.rising):
            reasons.append(
                f"board {board} axis {axis} made {len(edges.rising)} steps, it has no line"
            )
    if result.refused:
        reasons.insert(0, str(result.refused))
        reasons.append(f"{sum(found.steps for found in axes)} STEP edges after the refusal")
    reasons += [f"axis {found.axis}: {text}" for found in axes for text in found.reasons]
    summary = _summary(result, axes, reasons)
    for row in summary["axes"]:
        axis = row["axis"]
        row["pixels"], row["pixels_equal"] = job.lines[axis].pixels, equal[axis]
        row["clock"] = kept[axis].summary() if axis in kept else None
    summary["line_zero_cycle"], summary["clock_edge_cycle"] = zero, clock_edge
    if zero is not None and clock_edge is not None:
        summary["line_zero_periods"] = max(1, round((zero - clock_edge) / job.clock_period))
        summary["line_zero_error_cycles"] = verdict.zero_error(zero, job.clock_period, clock_edge)
    return Judgement(summary, rows, axes, grids, kept)


def _judge_axis(result: RunResult, axis: int, grids: dict[int, PixelGrid]) -> AxisVerdict:
    """Return the verdict on an axis' edges; note the grid of its pixels if it made any step."""
    job, edges = result.job, result.edges.axis(0, axis)
    line, grid = job.lines[axis], None
    if job.locked and line.clocked:
        found, grid = verdict.judge_locked_axis(line, job.period, edges, axis, tick_hz=job.tick_hz)
    else:
        found = verdict.judge_axis(line, job.period, edges, axis, tick_hz=job.tick_hz)
        if found.line_zero_cycle is not None:
            grid = pixel_clock.nominal(line, job.period, found.line_zero_cycle)
    if grid is not None:
        grids[axis] = grid
    found.underruns = result.axis_states.get(axis, {}).get("underruns", 0)
    if found.underruns:
        found.reasons.append(f"{found.underruns} underruns")
    return found


def _stopped_at(result: RunResult, found: AxisVerdict) -> float:
    """Return the cycle of the last step of a line that a fault cut off: behind it none was due."""
    rising = result.edges.axis(0, found.axis).rising
    if not result.trouble or len(rising) >= found.expected_steps:
        return math.inf
    return float(rising[-1]) if len(rising) else -math.inf


def _judge_clock(
    result: RunResult, axes: list[AxisVerdict], grids: dict[int, PixelGrid]
) -> dict[int, clock_judge.ClockKeeping]:
    """Return how each axis kept to the clock, unless lines ignore it; note what is wrong."""
    job, found = result.job, {}
    for of in axes:
        line = job.lines[of.axis]
        if job.sync == FREE or not line.clocked or of.axis not in grids:
            continue
        kept = clock_judge.keep(
            job, of.axis, line, result.edges.axis(0, of.axis), grids[of.axis], result.clock,
            stopped_at=_stopped_at(result, of),
        )  # fmt: skip
        if kept is None:
            continue
        found[of.axis] = kept
        of.reasons += clock_judge.reasons(job, kept) + clock_judge.gate_reasons(job, kept)
        if job.locked:
            of.last_steps_on_edge = int(kept.on_edge)
            of.last_steps_off_edge = len(kept.pixels) - of.last_steps_on_edge
    return found


def _common_zero(
    result: RunResult, axes: list[AxisVerdict], grids: dict[int, PixelGrid], reasons: list[str]
) -> int | None:
    """Return the line zero of the axes, the first of several, noting if they differ and must not.

    That of a locked line is known by its steps, to a few ticks; but their pixels end together.
    Lines that wait for no edge of the clock begin one after the other.
    """
    job = result.job
    known = [(of.axis, of.line_zero_cycle) for of in axes if of.line_zero_cycle is not None]
    waited = sorted({zero for axis, zero in known if job.lines[axis].clocked})
    if job.locked:
        reasons += clock_judge.apart(job, grids)
    elif job.sync != FREE and len(waited) > 1:
        reasons.append(f"the axes do not share one line zero: cycles {waited}")
    return min((zero for _, zero in known), default=None)


def _pixel_rows(result: RunResult, axis: int, grid: PixelGrid | None) -> list[PixelRow]:
    """Return one row a pixel: expected from the board's records, actual from the edges."""
    job, line = result.job, result.job.lines[axis]
    if result.refused:
        return []
    cycles: list[int | None] = [None] * line.pixels
    actual = [0] * line.pixels
    if grid is not None:
        if job.locked and line.clocked:
            bounds = grid.edges(line.pixels)
        else:  # on the board's own time they are exact
            zero = round(float(grid.knots_cycle[0]))
            pixels = range(1, line.pixels + 1)
            bounds = np.array([zero + edge_tick(pixel, job.period) for pixel in pixels])
        cycles, actual = bounds.tolist(), _positions(result, axis, bounds)
    records = result.records.get(axis, {})
    return [
        PixelRow(0, axis, pixel, cycle, record.expected_steps if record else None, steps)
        for pixel, (cycle, steps) in enumerate(zip(cycles, actual, strict=True), 1)
        for record in (records.get(pixel),)
    ]


def _positions(result: RunResult, axis: int, bounds: np.ndarray) -> list[int]:
    """Return the steps made by the end of each pixel, from the edges.

    Where a pixel of a locked line ends inside a piece its end is known to a tick or two only: of
    the steps made by then the board's own figure counts if it is among those possible.
    """
    edges, near = result.edges.axis(0, axis), clock_judge.EDGE_TICKS
    made: list[int] = verdict.actual_positions(edges, bounds).tolist()
    if not result.job.locked:
        return made
    before, after = (verdict.actual_positions(edges, bounds + off) for off in (-near, near))
    for pixel, record in result.records.get(axis, {}).items():
        if 1 <= pixel <= len(made):
            ends = int(before[pixel - 1]), int(after[pixel - 1])
            if min(ends) <= record.actual_steps <= max(ends):
                made[pixel - 1] = record.actual_steps
    return made


def _judge_pixels(result: RunResult, found: AxisVerdict, rows: list[PixelRow]) -> int:
    """Require board's expected = reference = counted at every edge; return how many agree.

    Of a pixel that the board was not to keep a record of, a deviation of the board's own count has
    one all the same, unless a fault had stopped the line before.
    """
    if result.refused:
        return 0
    every = result.record_every
    made = _made_pixels(rows, _stopped_at(result, found))
    missing = [row.pixel for row in rows if row.expected_steps is None and row.pixel % every == 0]
    if missing:
        why = ": those of the clock's deviations overwrote them" if result.job.strays_px else ""
        if missing[0] > made:
            why = ": the line was stopped before their end"
        found.reasons.append(f"no record of {len(missing)} pixels, first {missing[0]}{why}")
    equal, wrong = 0, []
    records = result.records.get(found.axis, {})
    table = exact.expected_positions(result.job.lines[found.axis])
    for row, value in zip(rows, table, strict=True):
        record = records.get(row.pixel)
        thinned = record is None and row.pixel % every != 0 and row.pixel <= made
        reported = record.actual_steps if record else value if thinned else None
        expected = value if thinned else row.expected_steps
        if value == expected == row.actual_steps == reported:
            equal += 1
        elif record or thinned:
            wrong.append((row, value, reported))
    if wrong:
        row, value, reported = wrong[0]
        found.reasons.append(
            f"{len(wrong)} pixels differ, first {row.pixel}: reference {value}, board expects "
            f"{row.expected_steps} and counts {reported}, edges counted {row.actual_steps}"
        )
    return equal


def _made_pixels(rows: list[PixelRow], stopped_at: float) -> int:
    """Return how many pixels of a line ended before it was stopped."""
    if math.isinf(stopped_at):
        return len(rows) if stopped_at > 0 else 0
    return sum(row.edge_cycle is not None and row.edge_cycle < stopped_at for row in rows)


def _summary(result: RunResult, axes: list[AxisVerdict], reasons: list[str]) -> Summary:
    """Return summary.json without the line zero, and what is told of its axes' pixels."""
    job, refused = result.job, result.refused
    board = result.stats["boards"][0]
    decodes = {line.decode for line in job.lines.values()}
    shares = _shares(result)
    return {
        "verdict": "refused" if refused else "fail" if reasons else "pass",
        "reasons": reasons,
        "refusal": {
            "axis": refused.axis,
            "name": refused.name,
            "pixel": refused.pixel,
            "step_edges": sum(len(edges.rising) for edges in result.edges.axes.values()),
        }
        if refused
        else None,
        "board": job.board,
        "decode": decodes.pop() if len(decodes) == 1 else "mixed",
        "pixel_hz": hz_text(job.pixel_hz).removesuffix("/1"),
        "pixel_ppm": job.pixel_ppm,
        "clock": clock_judge.clock_summary(result),
        "tick_hz": job.tick_hz,
        "seed": job.seed,
        "record_every": result.record_every,
        "serial_load": job.serial_load,
        "requests": result.requests,
        "axes": [found.summary() for found in axes],
        "handlers": board["handlers"],
        "cpu_share": shares["cpu_share"],
        "interrupt_share": shares["interrupt_share"],
        "section_cycles": shares["section_cycles"],
        "stack_free_bytes": board["stack_free_bytes"],
        "stack_used_bytes": board.get("stack_used_bytes"),
        "interrupts_off_max_cycles": board.get("interrupts_off_max_cycles"),
        "realtime_factor": result.stats["realtime_factor"],
        "simulated_s": result.stats["cycle"] / job.tick_hz,
        "wall_s": result.stats["wall_s"],
    }


def _shares(result: RunResult) -> Shares:
    """Return the shares of cycles from arming to the end.

    `cpu_share` is interrupts, decoding and following: what grows with the steps. The remaining
    sections of the main loop look for work without end, so their cycles say nothing about load.
    """
    before, after = result.stats_armed, result.stats
    if not before:
        return {"cpu_share": None, "interrupt_share": None, "section_cycles": None}
    old, new = before["boards"][0], after["boards"][0]
    cycles = after["cycle"] - before["cycle"]
    interrupts = new["interrupt_cycles"] - old["interrupt_cycles"]
    sections = [b - a for a, b in zip(old["sections"], new["sections"], strict=True)]
    work = interrupts + sum(sections[name] for name in _WORK)
    return {
        "cpu_share": round(work / cycles, 6),
        "interrupt_share": round(interrupts / cycles, 6),
        "section_cycles": sections,
    }


@dataclass(frozen=True)
class AxisLoad:
    """The load of one axis at the pixel edges 1..N, in steps from its start.

    `spans` are the transitions of a compensated line, as (first, last) 1-based pixels.
    """

    axis: int
    ideal_steps: np.ndarray
    load_steps: np.ndarray
    spans: tuple[tuple[int, int], ...]

    @property
    def errors(self) -> np.ndarray:
        """Load minus ideal at each pixel edge."""
        errors: np.ndarray = self.load_steps - self.ideal_steps
        return errors

    @property
    def outside(self) -> np.ndarray:
        """True for each pixel edge that lies in no transition."""
        away = np.ones(len(self.load_steps), dtype=bool)
        for first, last in self.spans:
            away[first - 1 : last] = False
        return away

    def summary(self) -> Load:
        """Return the largest errors and where they are, as plain data of summary.json."""
        worst, pixel = _worst(self.errors)
        outside, outside_pixel = _worst(np.where(self.outside, self.errors, 0))
        return {
            "max_load_error_steps": worst, "max_load_error_pixel": pixel,
            "max_load_error_outside_steps": outside, "max_load_error_outside_pixel": outside_pixel,
            "transitions": [list(span) for span in self.spans],
        }  # fmt: skip


def axis_load(
    axis: int, line: Line, ideal: tuple[int, ...] | None, plant: AxisPlant, edge_cycles: list[int]
) -> AxisLoad:
    """Return an axis' load at the cycles of its pixel edges.

    `ideal` are the counts that the load should follow, one a pixel; None: those of the line.
    """
    wanted = [line.direction * count for count in line.counts] if ideal is None else list(ideal)
    spans = []  # a transition ends with the last pixel whose count is not the ideal one
    for stroke in strokes(wanted) if ideal is not None else ():
        changed = [k for k in range(stroke.start, stroke.end) if wanted[k] != line.counts[k]]
        if changed:
            spans.append((stroke.start + 1, changed[-1] + 1))
    steps = plant.load_at(np.array(edge_cycles, dtype=np.int64))
    return AxisLoad(axis, np.cumsum(wanted), steps, tuple(spans))


def _worst(errors: np.ndarray) -> tuple[int, int | None]:
    """Return the error of the largest magnitude and its 1-based pixel; (0, None) if all are 0."""
    if not np.any(errors):
        return 0, None
    index = int(np.argmax(np.abs(errors)))
    return int(errors[index]), index + 1
