# SPDX-License-Identifier: MIT
"""How the lines of a run kept to the true edges of the pixel clock, locked to them or not.

Of each pixel whose last step lies on its end that step is compared with the clock's true edge
there, and at every true edge within the line, also at those inside a pixel of several, the steps
made are compared with those due.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.lazy import np
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.simulation.job import LineExperiment, RunResult
from pixstep.simulation.logs import AxisEdges, ClockLog
from pixstep.simulation.pixel_clock import ClockFlaws, PixelGrid
from pixstep.simulation.summary import AxisClock, Clock, Summary

EDGE_TICKS = 2  # a locked line's pixel edges are so near to those of an even clock
POSITION_STEPS = 1
_JUDGED_JITTER = 100  # pixels, from which on their errors tell how much jitter is let through
# Ticks rms. A clock's true edge lies anywhere, it is captured at a whole tick, and the STEP edge
# lies on one: the square is twice that of 12**-0.5.
_ROUNDING = 6**-0.5
_SYNC_TEXTS = {"free": "free of the clock", "lock": "locked to the clock"}
_ON_EDGE = 1e-9  # pixels that floating point may lack


@dataclass(frozen=True)
class ClockKeeping:
    """How one axis kept to the clock: errors are those of the board, late ones positive.

    `pixels` are those whose last step lies on their end, `errors_ticks` of them; `free_ticks` are
    those that a line has which begins on the same edge and keeps to the board's own time then.
    `off_steps` are steps made and not due, at each true edge from line zero on; of a line that a
    fault cut off, at those before its last step.
    """

    axis: int
    pixels: np.ndarray
    errors_ticks: np.ndarray
    free_ticks: np.ndarray
    off_steps: np.ndarray
    period: float
    line_speed: int
    speed_hz: float
    first_edge: int
    lasts_ticks: np.ndarray = field(repr=False)

    @property
    def drift_ticks(self) -> float:
        """How much later the last pixel edge was than the first, beside the clock's."""
        return float(self.errors_ticks[-1] - self.errors_ticks[0])

    @property
    def drift_steps(self) -> float:
        """The same in steps, at the line's speed."""
        return self.drift_ticks / self.period * self.line_speed

    @property
    def on_edge(self) -> int:
        """Pixels that end within EDGE_TICKS of the clock's true edge."""
        return int(np.sum(np.abs(self.errors_ticks) <= EDGE_TICKS))

    @property
    def max_off_steps(self) -> int:
        """The largest difference of steps made from steps due at any of the clock's true edges."""
        return int(np.max(np.abs(self.off_steps), initial=0))

    @property
    def rms_ticks(self) -> float:
        """Root of the mean square of the errors."""
        return float(np.sqrt(np.mean(self.errors_ticks**2)))

    @property
    def ripple_ticks(self) -> float:
        """The largest change of length from a pixel to the next."""
        return float(np.max(np.abs(np.diff(self.lasts_ticks)), initial=0.0))

    def summary(self) -> AxisClock:
        """Return the plain data of summary.json."""
        worst = int(np.argmax(np.abs(self.errors_ticks)))
        ripple = self.ripple_ticks / self.period
        return {
            "pixels": len(self.pixels), "line_zero_edge": self.first_edge,
            "max_error_ticks": round(float(np.abs(self.errors_ticks[worst])), 3),
            "max_error_pixel": int(self.pixels[worst]), "rms_error_ticks": round(self.rms_ticks, 3),
            "drift_ticks": round(self.drift_ticks, 3) + 0.0,
            "drift_pixels": round(self.drift_ticks / self.period, 6) + 0.0,
            "drift_steps": round(self.drift_steps, 3) + 0.0,
            "max_position_error_steps": self.max_off_steps,
            "ripple_ticks": round(self.ripple_ticks, 3), "ripple_ppm": round(1e6 * ripple, 1),
            "ripple_steps_s": round(ripple * self.line_speed * self.speed_hz, 3),
        }  # fmt: skip


def keep(
    job: LineExperiment, axis: int, line: Line, edges: AxisEdges, grid: PixelGrid,
    clock: ClockLog, *, stopped_at: float = math.inf,
) -> ClockKeeping | None:  # fmt: skip
    """Return how an axis kept to the clock; None if its line or the clock has too few edges.

    No step was due from cycle `stopped_at` on.
    """
    rising, true = edges.rising, clock.true
    ends = [(pixel, done) for pixel, done in exact.edge_ends(line) if done <= len(rising)]
    if not ends or not len(true):
        return None
    # Line zero is found by a pixel that ends with a step: a locked line's pixels without a step
    # before it are as long as the clock's; all others are of the board's own time.
    place = ends[0][0] if job.locked else 0
    zero = int(np.argmin(np.abs(true - grid.at(np.array([float(place)]))[0]))) - place * job.divider
    ends = [(pixel, done) for pixel, done in ends if zero + pixel * job.divider < len(true)]
    if zero < 0 or not ends:
        return None
    pixels = np.array([pixel for pixel, _ in ends])
    made = rising[np.array([done for _, done in ends]) - 1]
    follows = np.flatnonzero(np.diff(pixels) == 1)
    due = true[zero : zero + line.pixels * job.divider + 1]
    return ClockKeeping(
        axis=axis, pixels=pixels,
        free_ticks=true[zero] + pixels * float(job.period) - true[zero + pixels * job.divider],
        errors_ticks=made - true[zero + pixels * job.divider],
        off_steps=_off_steps(job, line, edges, due[due < stopped_at]), period=float(job.period),
        line_speed=line.line_speed, speed_hz=float(job.line_hz), first_edge=zero,
        lasts_ticks=(made[follows + 1] - made[follows]).astype(float),
    )  # fmt: skip


def _off_steps(job: LineExperiment, line: Line, edges: AxisEdges, true: np.ndarray) -> np.ndarray:
    """Return the steps made minus those due at each of the clock's true edges."""
    when = np.arange(len(true)) / job.divider + _ON_EDGE
    due = np.concatenate([[0], np.cumsum(exact.directions(line))])
    made = np.concatenate([[0], np.cumsum(edges.directions())])
    units = exact.instants(line, Fraction(1))
    off: np.ndarray = (
        made[np.searchsorted(edges.rising, true, side="right")]
        - due[np.searchsorted(units, when, side="right")]
    )
    return off


def apart(job: LineExperiment, grids: Mapping[int, PixelGrid]) -> list[str]:
    """Return a reason if pixels of locked axes that end with a step do not end together."""
    ends: dict[int, dict[int, int]] = {}
    for axis, grid in grids.items():
        steps = exact.edge_ends(job.lines[axis]) if job.lines[axis].clocked else []
        pixels = [pixel for pixel, _ in steps if pixel <= grid.known_px]
        places = np.floor(grid.at(np.array(pixels, dtype=float)) + 0.5).astype(np.int64)
        for pixel, cycle in zip(pixels, places.tolist(), strict=True):
            ends.setdefault(pixel, {})[axis] = cycle
    wrong = [pixel for pixel, of in ends.items() if len(set(of.values())) > 1]
    if not wrong:
        return []
    return [
        f"{len(wrong)} pixels do not end together on all axes, first {wrong[0]}: cycles "
        f"{ends[wrong[0]]}"
    ]


def reasons(job: LineExperiment, kept: ClockKeeping) -> list[str]:
    """Return what a locked line did that the clock it had does not excuse."""
    flaws, found = job.flaws, []
    if not job.locked:
        return []
    if not flaws.even:
        # Of nothing but jitter it is known how much may be let through.
        jitter = flaws.jitter_us * job.tick_hz / 1e6
        alone = not (flaws.wander_ppm or flaws.step_ppm) and len(kept.pixels) >= _JUDGED_JITTER
        rms = kept.rms_ticks
        if not alone or rms <= math.hypot(jitter, _ROUNDING):
            return []
        return [f"pixel edges are {rms:.1f} ticks rms off, the jitter is {jitter:.1f} rms"]
    far = np.flatnonzero(np.abs(kept.errors_ticks) > EDGE_TICKS)
    if len(far):
        found.append(
            f"the last step of {len(far)} pixels is more than {EDGE_TICKS} ticks off the clock's "
            f"true edge, first pixel {kept.pixels[far[0]]} by {kept.errors_ticks[far[0]]:.1f}"
        )
    off = np.flatnonzero(np.abs(kept.off_steps) > POSITION_STEPS)
    if len(off):
        found.append(
            f"the position is more than {POSITION_STEPS} step off at {len(off)} of the clock's "
            f"edges, first edge {off[0]} of the line by {kept.off_steps[off[0]]}"
        )
    return found


def gate_reasons(job: LineExperiment, kept: ClockKeeping) -> list[str]:
    """Return a reason if a line on a gated clock did not begin on its edge of a burst."""
    if not (job.gate_edges and job.flaws.gate_edges):
        return []
    behind = kept.first_edge % job.flaws.gate_edges
    if behind == job.gate_edges:
        return []
    return [f"line zero is {behind} edges after the first edge of its burst, not {job.gate_edges}"]


def clock_summary(result: RunResult) -> Clock:
    """Return what the clock did, and what the board says of it."""
    job, clock = result.job, result.clock
    before, after = result.clock_armed, result.clock_seen
    told: Clock = {
        "sync": job.sync, "divider": job.divider, "flaws": job.flaws.as_json(),
        "true_edges": len(clock.true), "missing_edges": clock.missing, "false_edges": clock.false,
    }  # fmt: skip
    if "clock_missing" in after and before:
        told["board_missing"] = (after["clock_missing"] - before["clock_missing"]) % 0x10000
        told["board_glitches"] = (after["clock_glitches"] - before["clock_glitches"]) % 0x10000
    if "clock_period_ticks" in after:
        period = after["clock_period_ticks"] + after["clock_period_fraction"] / 0x10000
        told["board_period_ticks"] = round(period, 4)
        if period:
            told["board_offset_ppm"] = round(1e6 * (float(job.clock_period) / period - 1), 3)
        told["board_jitter_ticks"] = after["clock_jitter"] / 16
    return told


def even(summary: Summary) -> bool:
    """True if the clock of a run had its edges where an even frequency has them."""
    return ClockFlaws(**summary["clock"]["flaws"]).even


def parts(summary: Summary) -> list[str]:
    """Return what is special of the clock, and of what lines are to it."""
    found = []
    clock = summary["clock"]
    if clock["divider"] > 1:
        found.append(f"{clock['divider']} clock edges a pixel")
    if clock["sync"] in _SYNC_TEXTS:
        found.append(_SYNC_TEXTS[clock["sync"]])
    if summary["pixel_ppm"]:
        found.append(f"pixel clock {summary['pixel_ppm']:+g} ppm")
    return [*found, *ClockFlaws(**clock["flaws"]).texts()]


def texts(summary: Summary) -> list[str]:
    """Return how a run kept to its clock, a line each, for the page."""
    clock, tick_us = summary["clock"], 1e6 / summary["tick_hz"]
    kept = {row["axis"]: row.get("clock") for row in summary["axes"]}
    text = (
        f"clock: {_counted(clock['true_edges'], 'true edge')}, {clock['missing_edges']} missing, "
        f"{clock['false_edges']} false"
    )
    if "board_missing" in clock:
        text += (
            f"; the board counted {clock['board_missing']} missing and {clock['board_glitches']} "
            f"false from arming on"
        )
    if "board_offset_ppm" in clock:
        text += (
            f"\n  and measured {clock['board_offset_ppm']:+.1f} ppm, mean jitter "
            f"{clock['board_jitter_ticks'] * tick_us:.2f} us"
        )
    return [*(_kept_text(axis, of, tick_us) for axis, of in kept.items() if of), text]


def _kept_text(axis: int, kept: AxisClock, tick_us: float) -> str:
    """Return one line on an axis, or several: what is too much for one has a line of its own."""
    off = kept["max_position_error_steps"]
    position = "at every true edge of the clock exactly the steps made that were due by then"
    if off:
        position = (
            f"at the clock's true edges at most {_counted(off, 'step')} made too early or too late"
        )
    return (
        f"axis {axis}: {_counted(kept['pixels'], 'pixel edge')} at most "
        f"{kept['max_error_ticks']:.1f} ticks ({kept['max_error_ticks'] * tick_us:.3g} us) off the "
        f"clock's true ones (pixel {kept['max_error_pixel']}), rms {kept['rms_error_ticks']:.2f} "
        f"ticks ({kept['rms_error_ticks'] * tick_us:.3g} us)\n"
        f"  drift from the first to the last {round(kept['drift_ticks'], 1) + 0.0:.1f} ticks = "
        f"{kept['drift_pixels']:.4g} px = {round(kept['drift_steps'], 2) + 0.0:.2f} steps\n"
        f"  {position}\n"
        f"  ripple from pixel to pixel at most {kept['ripple_ticks']:.0f} ticks = "
        f"{kept['ripple_ppm']:.0f} ppm = {kept['ripple_steps_s']:.3g} steps/s"
    )


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
