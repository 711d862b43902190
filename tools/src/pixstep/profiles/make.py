# SPDX-License-Identifier: MIT
"""The shortest acceleration profile within limits of acceleration and jerk.

Everything is counted in units of two steps, because every boundary speed of a smooth line is even.
With accelerations a_1..a_m, a_0 = a_(m+1) = 0 and |a_k - a_(k-1)| <= J, no profile can have
a_k > min(J k, J (m + 1 - k), A): the sum of these is the highest speed that m pixels reach, so the
smallest m whose sum is at least the top speed is the shortest there is. The surplus is then taken
from the largest accelerations, one unit at a time: lowering a largest one brings it nearer to its
neighbours or at most one unit below an equal one, so both limits stay kept.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate

from pixstep.errors import UserError
from pixstep.lines.units import (
    ACCELERATION,
    SPEED,
    Quantity,
    TooLittleError,
    both_text,
    number_text,
    unit,
)
from pixstep.profiles.generator import MAX_SPEED


@dataclass(frozen=True)
class ProfileLimits:
    """Even whole numbers: steps/pixel, steps/pixel2, steps/pixel3 (change from pixel to pixel)."""

    top_speed: int
    max_acceleration: int
    max_jerk: int


def legal_speed(value: Fraction, hz: Fraction | None = None) -> int:
    """Return a top speed as an even whole number of steps/pixel.

    Raises UserError naming the nearest legal ones, per second too if `hz` is given, for a speed
    that is odd, not whole, below 2 or above MAX_SPEED.
    """
    if value > MAX_SPEED:
        raise UserError(
            f"top speed {number_text(value)} steps/px is above the largest, nearest legal "
            f"{both_text(MAX_SPEED, SPEED, hz)}"
        )
    if value.denominator == 1 and value >= 2 and value % 2 == 0:
        return int(value)
    below = int(value // 2) * 2
    legal = [speed for speed in (below, below + 2) if 2 <= speed <= MAX_SPEED]
    raise UserError(
        f"top speed {number_text(value)} steps/px is not an even whole number: every boundary "
        f"speed of a smooth line is even, nearest legal "
        f"{' and '.join(both_text(speed, SPEED, hz) for speed in legal)}"
    )


def legal_limit(
    value: Fraction, order: int, hz: Fraction | None = None, given: Quantity | None = None
) -> int:
    """Return the largest even whole number not above a limit: accelerations change by even ones.

    `given` is the limit as it was written. Raises TooLittleError naming the nearest legal one for a
    limit below 2.
    """
    if value < 2:
        raise TooLittleError(
            f"{'acceleration' if order == ACCELERATION else 'jerk'} limit {number_text(value)} "
            f"{unit(order)} is below 2: boundary speeds are even, nearest legal "
            f"{both_text(2, order, hz)}",
            2,
            given,
        )
    return int(value // 2) * 2


def shortest_pixels(limits: ProfileLimits) -> int:
    """Return the number of pixels of the shortest profile."""
    target = limits.top_speed // 2
    low, high = 0, target  # every pixel gains at least one unit
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if sum(_envelope(middle, limits)) >= target else (middle, high)
    return high


def shortest_profile(limits: ProfileLimits) -> list[int]:
    """Return the speeds at the ends of the pixels: even, rising from pixel to pixel.

    The last one is the top speed; after it the speed is held, and that last change of the
    acceleration keeps the jerk limit too.
    """
    accelerations = _envelope(shortest_pixels(limits), limits)
    _lower(accelerations, sum(accelerations) - limits.top_speed // 2)
    return [2 * speed for speed in accumulate(accelerations)]


def _envelope(pixels: int, limits: ProfileLimits) -> list[int]:
    """Return the largest acceleration that each of `pixels` pixels can have, in units of two.

    None is above the top speed, which it would exceed in one pixel.
    """
    jerk, top = limits.max_jerk // 2, min(limits.max_acceleration, limits.top_speed) // 2
    return [min(jerk * (k + 1), jerk * (pixels - k), top) for k in range(pixels)]


def _lower(accelerations: list[int], surplus: int) -> None:
    """Take `surplus` units from the largest accelerations, a layer of the plateau at a time."""
    while surplus:
        largest = max(accelerations)
        plateau = [k for k, value in enumerate(accelerations) if value == largest]
        taken = min(surplus, len(plateau))
        for k in plateau[len(plateau) - taken :]:
            accelerations[k] -= 1
        surplus -= taken
