# SPDX-License-Identifier: MIT
"""Random valid lines for the property tests and campaigns, reproducible from a seed."""

import itertools
import random
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import check, refused
from pixstep.lines.units import period_ticks

# Frequencies whose period is whole, a short fraction and a long one.
PIXEL_HZ = (
    Fraction(30),
    Fraction(25),
    Fraction(2997, 100),
    Fraction(30000, 1001),
    Fraction(100),
    Fraction(997, 10),
)


@dataclass(frozen=True)
class LineCase:
    """A line, the exact pixel frequency to run it at, and the timer ticks a second."""

    line: Line
    pixel_hz: Fraction
    tick_hz: int

    @property
    def period(self) -> Fraction:
        """Pixel period in timer ticks."""
        return period_ticks(self.pixel_hz, self.tick_hz)


@dataclass(frozen=True)
class Bounds:
    """What the random lines may need: the shortest interval in ticks, lengths in pixels."""

    min_interval_ticks: int = 533  # 30 kHz, the rate of the worked example
    min_pixels: int = 6
    max_pixels: int = 24
    reversal_ticks: int = 6300  # plain lines reverse only between steps at least this far apart
    tick_hz: int = field(default_factory=lambda: boards.load(boards.DEFAULT).tick_hz)


def max_speed(period: Fraction, bounds: Bounds) -> int:
    """Return the highest even speed in steps/pixel whose interval the bounds allow."""
    return min(int(period / bounds.min_interval_ticks), 16_382) // 2 * 2


def smooth_case(
    rng: random.Random, bounds: Bounds | None = None, pixel_hz: Fraction | None = None
) -> LineCase:
    """Return a valid smooth line: even boundary speeds walking from 0 to 0, some with backlash.

    Without `pixel_hz` its frequency is random too, as that of a plain one.
    """
    bounds = bounds or Bounds()
    while True:
        hz = pixel_hz or rng.choice(PIXEL_HZ)
        line = _smooth_line(rng, max_speed(period_ticks(hz, bounds.tick_hz), bounds), bounds)
        if not refused(check(line)):
            return LineCase(line, hz, bounds.tick_hz)


def plain_case(
    rng: random.Random, bounds: Bounds | None = None, pixel_hz: Fraction | None = None
) -> LineCase:
    """Return a valid plain line: signed counts, zeros and reversals included."""
    bounds = bounds or Bounds()
    hz = pixel_hz or rng.choice(PIXEL_HZ)
    period = period_ticks(hz, bounds.tick_hz)
    top = max_speed(period, bounds)
    slow = max(1, min(top, int(period / bounds.reversal_ticks)))
    sign = 1
    counts: list[int] = []
    for _ in range(rng.randint(bounds.min_pixels, bounds.max_pixels)):
        count = rng.choice((0, 1, 2, 3, rng.randint(1, top), rng.randint(1, top), top))
        if rng.random() < 0.25:  # reverse through slow pixels or a rest
            sign = -sign
            if counts and abs(counts[-1]) > slow:
                counts.append(0)
            count = rng.choice((0, rng.randint(1, slow)))
        counts.extend([sign * count] * rng.choice((1, 1, 1, 2, 5)))
    return LineCase(Line(tuple(counts), PLAIN, name="random plain"), hz, bounds.tick_hz)


def case(
    rng: random.Random,
    decode: str,
    bounds: Bounds | None = None,
    pixel_hz: Fraction | None = None,
) -> LineCase:
    """Return a random case of the given decode rule."""
    make = smooth_case if decode == SMOOTH else plain_case
    return make(rng, bounds, pixel_hz)


def rate_case(
    steps_per_second: int, steps: int, pixel_hz: Fraction = Fraction(50), *, tick_hz: int
) -> LineCase:
    """Return a plain line of constant rate; the rate must be a whole number of steps a pixel."""
    count = Fraction(steps_per_second) / pixel_hz
    if count.denominator != 1:
        raise ValueError(f"{steps_per_second} steps/s is not whole at {pixel_hz} Hz")
    pixels = -(-steps // count.numerator)
    return LineCase(
        Line((count.numerator,) * pixels, PLAIN, name="constant rate"), pixel_hz, tick_hz
    )


def _smooth_line(rng: random.Random, top: int, bounds: Bounds) -> Line:
    """Return a smooth line that is valid but for an unlucky pair of equal counts."""
    speeds = _walk(rng, top, rng.randint(bounds.min_pixels, bounds.max_pixels))
    counts = [(low + high) // 2 for low, high in itertools.pairwise(speeds)]
    peak = max(speeds)
    backlash = rng.choice((0, 0, 1, max(1, peak // 4), max(1, peak - 1), peak))
    zero = [0] if backlash or rng.random() < 0.1 else []
    return Line(
        tuple(zero + counts + zero),
        SMOOTH,
        backlash,
        negative=rng.random() < 0.2,
        name="random smooth",
    )


def _walk(rng: random.Random, top: int, pixels: int) -> list[int]:
    """Return even speeds from 0 to 0; a speed may hold, rest at 0 between moves, or jump."""
    speeds = [0]
    reach = rng.choice((top, top, max(2, top // 4 * 2), max(2, top // 20 * 2), 16))
    for _ in range(pixels - 1):
        move = rng.random()
        if move < 0.25:
            speeds.append(speeds[-1])
        elif move < 0.75:
            stride = rng.choice((8, 40, max(2, reach // 3)))
            speeds.append(min(max(0, speeds[-1] + rng.randint(-stride, 2 * stride)), reach))
        else:
            speeds.append(rng.randint(0, reach))
        speeds[-1] = speeds[-1] // 2 * 2
    return [*speeds, 0]
