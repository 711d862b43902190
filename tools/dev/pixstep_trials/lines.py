# SPDX-License-Identifier: MIT
"""The lines that are measured: one rate, a ramp, a ramp and then something at its peak."""

from fractions import Fraction
from itertools import pairwise

from pixstep.lines.line import PLAIN, SMOOTH, Line

RAMP_STEPS_PER_S2 = 100_000  # the acceleration of all ramps
RESOLUTION_STEPS_PER_S = 500  # of a rate that is searched for
WOBBLE = 50  # a line at its peak changes speed by one part in so many, each pixel


def grid(hz: Fraction) -> int:
    """Return the largest even count of steps a pixel that is at most the resolution of a rate."""
    return max(2, int(RESOLUTION_STEPS_PER_S / hz) // 2 * 2)


def count_at(rate: int, hz: Fraction) -> int:
    """Return the even count of steps a pixel at or below a rate in steps/s."""
    return int(rate / hz) // 2 * 2


def pixels_in(seconds: float, hz: Fraction) -> int:
    """Return the whole pixels that last at least so long."""
    return max(1, -int(-seconds * hz // 1))


def constant(count: int, pixels: int) -> Line:
    """Return a plain line of one rate from its first step to its last."""
    return Line((count,) * pixels, PLAIN, name="constant rate")


def smooth(speeds: list[int]) -> Line:
    """Return the smooth line with these even boundary speeds in steps/pixel."""
    return Line(tuple((a + b) // 2 for a, b in pairwise(speeds)), SMOOTH, name="smooth")


def ramp(count: int, hz: Fraction, steps_per_s2: int = RAMP_STEPS_PER_S2) -> list[int]:
    """Return the even boundary speeds from 0 up to `count`, as near the acceleration as they go."""
    gain = Fraction(steps_per_s2) / (hz * hz)  # steps/pixel2
    speeds = [0]
    while speeds[-1] < count:
        speeds.append(min(count, max(speeds[-1] + 2, 2 * round(len(speeds) * gain / 2))))
    return speeds


def wobble(low: int, high: int, pixels: int) -> list[int]:
    """Return boundary speeds from `low` to `high` between which every pixel accelerates or brakes.

    They go low, middle, high and again, so that no pixel takes the easier path of constant speed
    and no two neighbouring counts are equal.
    """
    middle = (low + high) // 4 * 2
    return [(low, middle, high)[k % 3] for k in range(max(1, pixels // 3) * 3)]


def at_peak(count: int, hz: Fraction, seconds: float, *, steady: bool = False) -> Line:
    """Return a smooth line: ramp up, `seconds` near `count` steps/pixel, ramp down.

    `steady` keeps the peak's speed; else every pixel there accelerates or brakes. One pixel at the
    peak's speed on either side keeps equal counts apart, which would be an oscillation.
    """
    up = ramp(count, hz)
    pixels = pixels_in(seconds, hz)
    low = max(0, count - 4 * max(1, count // (2 * WOBBLE)))
    peak = [count] * pixels if steady else wobble(low, count, pixels)
    return smooth([*up, count, *peak, *reversed(up)])


def triangles(count: int, hz: Fraction, seconds: float) -> Line:
    """Return a smooth line that ramps up to `count` and down to rest, over and over.

    A pixel at the top and one at rest keep equal counts apart, which would be an oscillation.
    """
    up = ramp(count, hz)
    one = [*up, *reversed(up)]
    return smooth(one * max(1, pixels_in(seconds, hz) // len(one)))
