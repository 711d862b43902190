# SPDX-License-Identifier: MIT
"""Compare the edges of a run with the exact instants, and say pass or fail with reasons.

Line zero is the one constant removed from all edges. It is taken from the steps that fall exactly
on a pixel edge: the cycle z for which most of them are at z + floor(k*P), which no rounding inside
a pixel can move. It must then lie within CLOCK_TOLERANCE cycles of a pixel clock edge plus one
nominal pixel period.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction
from typing import cast

from pixstep.lazy import np
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.lines.units import edge_tick
from pixstep.simulation import pixel_clock
from pixstep.simulation.logs import AxisEdges
from pixstep.simulation.pixel_clock import PixelGrid
from pixstep.simulation.summary import Axis

CLOCK_TOLERANCE = 4  # cycles
_PERIODS_TO_ZERO = range(1, 65)  # of the clock, from its edge to line zero
_DIGITS = {
    "max_edge_error_ticks": 6, "rms_edge_error_us": 6, "rate_error_ppm": 3,
    "max_interval_error_ticks": 6,
}  # fmt: skip
NEAR_ONE = 1e-3  # ticks from the limit where floating point hands over to exact arithmetic
NO_PHASE = Fraction(0)
DIRECTION_SETUP_S = 20e-6  # the default setting


@dataclass
class AxisVerdict:
    """What one axis did. Errors in ticks are edge minus exact instant minus line zero."""

    axis: int
    board: int = 0
    steps: int = 0
    expected_steps: int = 0
    underruns: int = 0
    line_zero_cycle: int | None = None
    max_edge_error_ticks: float = 0.0
    rms_edge_error_us: float = 0.0
    rate_error_ppm: float = 0.0
    max_interval_error_ticks: float = 0.0
    last_steps_on_edge: int = 0
    last_steps_off_edge: int = 0
    reasons: list[str] = field(default_factory=list)
    errors_ticks: np.ndarray | None = field(default=None, repr=False)

    @property
    def passed(self) -> bool:
        """True if nothing was found."""
        return not self.reasons

    @property
    def verdict(self) -> str:
        """pass or fail."""
        return "pass" if self.passed else "fail"

    def summary(self) -> Axis:
        """Return the plain data of summary.json."""
        found = {name: getattr(self, name) for name in Axis.__annotations__ if hasattr(self, name)}
        for name, digits in _DIGITS.items():
            found[name] = round(found[name], digits) + 0.0
        return cast("Axis", found)


def find_zero(
    line: Line, period: Fraction, rising: np.ndarray, phase: Fraction = NO_PHASE
) -> int | None:
    """Return the line's zero in cycles, None if there is no step to tell it from."""
    votes = Counter(
        int(rising[done - 1]) - edge_tick(pixel, period, phase)
        for pixel, done in exact.edge_ends(line)
        if 0 < done <= len(rising)
    )
    return votes.most_common(1)[0][0] if votes else None


def judge_axis(
    line: Line, period: Fraction, edges: AxisEdges, axis: int = 0, *, tick_hz: int,
    stopped: bool = False, phase: Fraction = NO_PHASE,
) -> AxisVerdict:  # fmt: skip
    """Return the verdict on one axis' edges against the exact instants of its line.

    A second has `tick_hz` ticks. Of a line that a fault `stopped` the edges may end early; those
    made must be right. A line that a board chained to others begins a `phase` of a tick after the
    whole tick that counts as its zero.
    """
    verdict = AxisVerdict(axis, 0, len(edges.rising), line.total_steps)
    _judge_number(verdict, edges, stopped)
    rising = edges.rising
    count = min(len(rising), line.total_steps)
    if count == 0:
        return verdict
    ideal = exact.instants(line, period)[:count] + float(phase)
    zero = find_zero(line, period, rising, phase)
    if zero is None:  # stopped before the first step that falls on an edge
        middle = round(float(np.median(rising[:count] - ideal)))
        zero = min(
            (middle - 1, middle, middle + 1),
            key=lambda candidate: float(np.max(np.abs(rising[:count] - candidate - ideal))),
        )
    verdict.line_zero_cycle = zero
    errors = (rising[:count] - zero) - ideal
    _note_errors(verdict, errors, tick_hz)
    _judge_errors(verdict, line, period, rising[:count] - zero, errors, phase)
    _judge_rates(verdict, ideal, rising[:count], errors)
    _judge_edge_ends(verdict, line, period, rising, zero, phase)
    _judge_directions(verdict, line, edges, tick_hz)
    return verdict


def judge_locked_axis(
    line: Line, period: Fraction, edges: AxisEdges, axis: int = 0, *, tick_hz: int,
    rounded: bool = False,
) -> tuple[AxisVerdict, PixelGrid | None]:  # fmt: skip
    """Return the verdict on edges that follow the pixel clock, and the grid that they show.

    Errors are those against the board's own grid; `clock_judge` compares the grid with the clock.
    Edges of a board whose ticks are others than the cycles of the log are `rounded` to these.
    """
    verdict = AxisVerdict(axis, 0, len(edges.rising), line.total_steps)
    _judge_number(verdict, edges)
    rising = edges.rising[: line.total_steps]
    grid = pixel_clock.of_steps(line, period, rising)
    if grid is None:
        return verdict, None
    units = exact.instants(line, Fraction(1))[: len(rising)]
    verdict.line_zero_cycle = round(float(grid.at(np.array([0.0]))[0]))
    errors = rising - grid.at(units)
    _note_errors(verdict, errors, tick_hz)
    # Ends of pieces that run ahead of the pixels are no whole ticks: one more may be between.
    most = rounded + np.where(units > line.shifted_pixels, 1 + NEAR_ONE, 2 + NEAR_ONE)
    far = np.flatnonzero(np.abs(errors) > most)
    if len(far):
        verdict.reasons.append(
            f"{len(far)} edges are a tick or more off the board's own grid, first step "
            f"{far[0] + 1} by {errors[far[0]]:.3f} ticks"
        )
    _judge_rates(verdict, units * float(period), rising, rising - units * float(period))
    _judge_directions(verdict, line, edges, tick_hz)
    return verdict, grid


def _judge_number(verdict: AxisVerdict, edges: AxisEdges, stopped: bool = False) -> None:
    """Require strictly increasing edges of alternating level, and their number; less if stopped."""
    if np.any(np.diff(edges.step_cycles) <= 0):
        verdict.reasons.append("STEP edges are not in order")
    if np.any(np.diff(edges.step_levels) == 0):
        verdict.reasons.append("a STEP pulse is doubled or has no end")
    made, wanted = len(edges.rising), verdict.expected_steps
    if made > wanted or (made < wanted and not stopped):
        verdict.reasons.append(f"{made} steps instead of {wanted}")


def judge_clock(zero: int, period: Fraction, clock: np.ndarray) -> tuple[int | None, str]:
    """Return the clock edge that line zero follows by one period, and a reason if there is none.

    `period` is that of the clock. Line zero is planned from an edge, at the nominal period; where
    one is too soon for the board, it takes another one.
    """
    if not len(clock):
        return None, "the pixel clock has no edges"
    offs = (_off_edge(zero, period, clock, count) for count in _PERIODS_TO_ZERO)
    off, edge = min(offs, key=lambda found: abs(found[0]))
    if abs(off) > CLOCK_TOLERANCE:
        off, edge = _off_edge(zero, period, clock, 1)
        return edge, f"line zero is {off} cycles off one pixel period after a clock edge"
    return edge, ""


def _off_edge(zero: int, period: Fraction, clock: np.ndarray, count: int) -> tuple[int, int]:
    """Return how far line zero is off so many periods after a clock edge, and that edge."""
    due = zero - edge_tick(count, period)
    edge = int(clock[np.argmin(np.abs(clock - due))])
    return due - edge, edge


def zero_error(zero: int, period: Fraction, edge: int) -> int:
    """Return how much later line zero is than whole periods of the clock after its edge."""
    count = max(1, round((zero - edge) / period))
    return zero - edge_tick(count, period) - edge


def actual_positions(edges: AxisEdges, bounds: np.ndarray) -> np.ndarray:
    """Return the signed steps made at or before each of some cycles."""
    made = np.concatenate([[0], np.cumsum(edges.directions())])
    return made[np.searchsorted(edges.rising, bounds, side="right")]


def _note_errors(verdict: AxisVerdict, errors: np.ndarray, tick_hz: int) -> None:
    verdict.errors_ticks = errors
    verdict.max_edge_error_ticks = float(np.max(np.abs(errors)))
    verdict.rms_edge_error_us = float(np.sqrt(np.mean(errors**2))) / tick_hz * 1e6


def _judge_errors(
    verdict: AxisVerdict, line: Line, period: Fraction, ticks: np.ndarray, errors: np.ndarray,
    phase: Fraction,
) -> None:  # fmt: skip
    """Require every edge strictly within one tick of its exact instant.

    Where a chained line takes play up, its pieces run ahead on a grid that begins on a whole tick:
    one more may be between, as in a locked line.
    """
    ahead = sum(line.counts[: line.shifted_pixels]) + line.backlash if phase else 0
    doubtful = np.flatnonzero(np.abs(errors) > 1 - NEAR_ONE).tolist()
    doubtful = [step for step in doubtful if step >= ahead or abs(errors[step]) > 2 + NEAR_ONE]
    far = [step for step in doubtful if abs(errors[step]) > 1 + NEAR_ONE]
    close = sorted({*doubtful} - {*far})
    instants = exact.instants_of(line, period, close) if close else []
    far += [
        step
        for step, when in zip(close, instants, strict=True)
        if not when.later(phase).strictly_within_one(int(ticks[step]))
    ]
    if far:
        first = min(far)
        verdict.reasons.append(
            f"{len(far)} edges are a tick or more off, first step {first + 1} "
            f"by {errors[first]:.3f} ticks"
        )


def _judge_rates(
    verdict: AxisVerdict, ideal: np.ndarray, rising: np.ndarray, errors: np.ndarray
) -> None:
    """Measure the rate error (slope of edges over instants) and the interval error."""
    if len(ideal) < 2:
        return
    centred = ideal - ideal.mean()
    slope = float(np.dot(centred, errors - errors.mean()) / np.dot(centred, centred))
    verdict.rate_error_ppm = slope * 1e6
    intervals = np.diff(rising) - np.diff(ideal)
    verdict.max_interval_error_ticks = float(np.max(np.abs(intervals)))


def _judge_edge_ends(
    verdict: AxisVerdict, line: Line, period: Fraction, rising: np.ndarray, zero: int,
    phase: Fraction,
) -> None:  # fmt: skip
    """Require the last step of every pixel exactly on its end edge (floor(k*P))."""
    off = []
    for pixel, done in exact.edge_ends(line):
        if done > len(rising):
            break
        if int(rising[done - 1]) == zero + edge_tick(pixel, period, phase):
            verdict.last_steps_on_edge += 1
        else:
            off.append(pixel)
    verdict.last_steps_off_edge = len(off)
    if off:
        verdict.reasons.append(
            f"the last step of {len(off)} pixels is not on the pixel edge, first pixel {off[0]}"
        )


def _judge_directions(verdict: AxisVerdict, line: Line, edges: AxisEdges, tick_hz: int) -> None:
    """Require the direction of every step, and the driver's set-up and hold times around DIR."""
    made, wanted = edges.directions(), exact.directions(line)
    count = min(len(made), len(wanted))
    wrong = np.flatnonzero(made[:count] != wanted[:count])
    if len(wrong):
        verdict.reasons.append(f"{len(wrong)} steps in the wrong direction, first {wrong[0] + 1}")
    rising, setup_ticks = edges.rising, round(DIRECTION_SETUP_S * tick_hz)
    for cycle in edges.direction_cycles:
        index = int(np.searchsorted(rising, cycle))
        near = np.abs(rising[max(0, index - 1) : index + 1] - cycle)
        if np.any(near < setup_ticks):
            verdict.reasons.append(f"DIR changes at cycle {cycle}, too close to a step")
            return
