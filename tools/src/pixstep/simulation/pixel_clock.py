# SPDX-License-Identifier: MIT
"""How a simulated pixel clock strays, and when a line on it had its pixel edges.

A line that keeps to the board's own time has its pixel edges at whole multiples of the nominal
period. A line that is locked to the pixel clock has them where the board predicted the clock's
edges: nothing tells but its steps, of which the last one of a pixel lies on the pixel's end. Where
backlash is taken up the pieces of a line run ahead of its pixels; each piece ends with a step too.

    pieces    |----|------|--------|---------|      0, 1, 4, 5 steps
    steps          .      .  .  .  .  . . . .|      the last of a piece: a knot of the grid
    knots          f      k        k         k      f: found from the steps behind it
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from itertools import pairwise
from typing import cast

from pixstep.lazy import np
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.simulation.summary import Flaws

MOST_PPM = 100_000
MOST_JITTER_US = 10_000
MOST_REST_MS = 3_600_000
_ROUNDING = 1e-6  # cycles that floating point may lack


@dataclass(frozen=True)
class ClockFlaws:
    """What is wrong with a clock; none by default.

    `jitter_us` is the standard deviation of each edge's own displacement. The frequency swings by
    `wander_ppm` to either side, once in 1,000 edges, and from edge `step_edge` on, counted from 0,
    it is `step_ppm` higher. One edge of `drop` is missing, and one edge of `double` is followed by
    a false one; 0 is none. A gate lets `gate_edges` edges pass and rests for `gate_rest_ms` besides
    the period, again and again; 0 edges are no gate.
    """

    jitter_us: float = 0.0
    wander_ppm: float = 0.0
    step_ppm: float = 0.0
    step_edge: int = 0
    drop: int = 0
    double: int = 0
    gate_edges: int = 0
    gate_rest_ms: float = 0.0

    @property
    def even(self) -> bool:
        """True if all edges but false ones are where an even clock with such rests has them."""
        return not (self.jitter_us or self.wander_ppm or self.step_ppm)

    def arguments(self) -> list[str]:
        """Return the runner's options."""
        options = {
            "--pixel-jitter-rms-ns": self.jitter_us and str(round(1000 * self.jitter_us)),
            "--pixel-wander-ppm": self.wander_ppm and repr(self.wander_ppm),
            "--pixel-step": self.step_ppm and f"{self.step_ppm!r}@{self.step_edge}",
            "--pixel-drop": self.drop and str(self.drop),
            "--pixel-double": self.double and str(self.double),
            "--pixel-gate": self.gate_edges and f"{self.gate_edges},{self.gate_rest_ms!r}",
        }
        return [word for option, value in options.items() if value for word in (option, str(value))]

    def texts(self) -> list[str]:
        """Return each flaw in words."""
        texts = (
            self.jitter_us and f"jitter {self.jitter_us:g} us rms",
            self.wander_ppm and f"wander {self.wander_ppm:g} ppm",
            self.step_ppm and f"{self.step_ppm:+g} ppm from edge {self.step_edge} on",
            self.drop and f"1 edge of {self.drop} missing",
            self.double and f"1 edge of {self.double} doubled",
            self.gate_edges
            and f"gate of {self.gate_edges} edges, rests of {self.gate_rest_ms:g} ms",
        )
        return [text for text in texts if isinstance(text, str)]

    def as_json(self) -> Flaws:
        """Return plain data."""
        return cast("Flaws", asdict(self))


@dataclass(frozen=True)
class PixelGrid:
    """Cycles over pixels from line zero: straight between knots, and nominal beyond them.

    Up to `known_px` they are known; behind it lies what a line that was stopped never made.
    """

    period: float
    knots_px: np.ndarray
    knots_cycle: np.ndarray
    known_px: float = math.inf

    def at(self, pixels: np.ndarray) -> np.ndarray:
        """Return the cycles of places in the line."""
        return self._map(pixels, self.knots_px, self.knots_cycle, self.period)

    def pixels_at(self, cycles: np.ndarray) -> np.ndarray:
        """Return the places in the line of cycles."""
        return self._map(cycles, self.knots_cycle, self.knots_px, 1 / self.period)

    def edges(self, pixels: int) -> np.ndarray:
        """Return the cycle of each of the first so many pixels' ends."""
        whole = np.floor(self.at(np.arange(1, pixels + 1)) + _ROUNDING)
        return whole.astype(np.int64)

    @staticmethod
    def _map(
        values: np.ndarray, knots: np.ndarray, results: np.ndarray, slope: float
    ) -> np.ndarray:
        values = np.asarray(values, dtype=float)
        below, above = np.minimum(values - knots[0], 0), np.maximum(values - knots[-1], 0)
        mapped: np.ndarray = np.interp(values, knots, results) + slope * (below + above)
        return mapped


def nominal(line: Line, period: Fraction, zero: float) -> PixelGrid:
    """Return the grid of a line on the board's own time, which began in cycle `zero`."""
    ends = np.array([0.0, float(line.pixels)])
    return PixelGrid(float(period), ends, zero + ends * float(period))


def of_steps(line: Line, period: Fraction, rising: np.ndarray) -> PixelGrid | None:
    """Return the grid that the steps of a line show; None if no piece was made to its end."""
    pieces = exact.PieceTable.of(line)
    begin_px, steps, done_by = pieces.begin, pieces.steps, np.cumsum(pieces.steps)
    end_px = np.append(begin_px[1:], float(line.pixels))
    units = exact.instants(line, Fraction(1))
    whole = np.flatnonzero((steps > 0) & (done_by <= len(rising)))
    if not len(whole):
        return None
    knots: dict[float, float] = {}
    begins, ends = begin_px[whole], end_px[whole]
    made = rising[done_by[whole] - 1].astype(float)
    gaps = [0, *(1 + np.flatnonzero(begins[1:] != ends[:-1])).tolist(), len(whole)]
    for place, following in pairwise(gaps):  # whole pieces without a gap between
        begin, end = float(begins[place]), float(ends[place])
        last = int(done_by[whole[place]]) - 1
        first = last + 1 - int(steps[whole[place]])
        parts = (units[first:last] - begin) / (end - begin)
        knots[begin] = _begin(parts, rising[first : last + 1], (end - begin) * float(period))
        together = slice(place, following)
        knots.update(zip(ends[together].tolist(), made[together].tolist(), strict=True))
    known = max(knots)
    done = int(done_by[whole[-1]])
    if done < len(rising):
        index = int(np.searchsorted(done_by, done, side="right"))
        begin, end = float(begin_px[index]), float(end_px[index])
        parts = (units[done : len(rising)] - begin) / (end - begin)
        knots |= _cut_off(knots.get(begin), parts, rising[done:], begin, end)
    return PixelGrid(float(period), np.array([*knots]), np.array([*knots.values()]), known)


def _cut_off(
    start: float | None, parts: np.ndarray, made: np.ndarray, begin: float, end: float
) -> dict[float, float]:
    """Return the places of begin and end of a piece that was cut off behind these of its steps.

    The least squares of the steps tell, from the begin on if that is known. One step alone tells
    nothing of both.
    """
    if start is not None:
        length = float(np.sum(parts * (made - start)) / np.sum(parts * parts))
        return {end: start + length}
    if len(parts) < 2:
        return {}
    length, start = (float(value) for value in np.polyfit(parts, made, 1))
    return {begin: start, end: start + length}


def _begin(parts: np.ndarray, made: np.ndarray, ticks: float) -> float:
    """Return where a piece began whose steps lie at these parts of it, its last one at the end.

    The least squares of the steps tell, as far as they leave every step within a tick, since the
    end may lie up to a tick behind its step. A single step tells nothing, so that the nominal
    length does.
    """
    last = float(made[-1])
    left = 1 - parts
    if not len(parts):
        return last - ticks
    off = made[:-1] - parts * last
    likely = float(np.sum(left * off) / np.sum(left * left))
    earliest, latest = float(np.max((off - 1) / left)), float(np.min((off + 1) / left))
    return min(max(likely, earliest), latest) if earliest <= latest else likely
