# SPDX-License-Identifier: MIT
"""From limits to an acceleration profile (speeds at pixel ends), from a profile to a line.

The shortest profile is counted in units of two steps, because every boundary speed of a smooth line
is even. With accelerations a_1..a_m, a_0 = a_(m+1) = 0 and |a_k - a_(k-1)| <= J, no profile can
have a_k > min(J k, J (m + 1 - k), A): the sum of these is the highest speed that m pixels reach, so
the smallest m whose sum is at least the top speed is the shortest there is. The surplus is then
taken from the largest accelerations, one unit at a time: lowering a largest one brings it nearer to
its neighbours or at most one unit below an equal one, so both limits stay kept.

Plain lines that turn: a way out, a rest, and the way back.
"""

import itertools
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise

from pixstep.errors import RefusedError, UserError
from pixstep.lines.units import (
    ACCELERATION,
    SPEED,
    Quantity,
    TooLittleError,
    both_text,
    number_text,
    unit,
)


def forth_and_back(way: Sequence[int], rest_px: int) -> tuple[int, ...]:
    """Return the counts of a way, of a rest, and of the way back."""
    back = (-count for count in reversed(way))
    return (*way, *(0,) * rest_px, *back)


def way_of(pixels: int) -> tuple[int, int]:
    """Return the pixels of each way of a line that turns, and of the rest between, 1 or 2."""
    way = (pixels - 1) // 2
    return way, pixels - 2 * way


def slow_first_pixels(who: str, way: Sequence[int]) -> str:
    """Return the advice for what turns and accelerates in its first pixel as hard as in any other.

    It is "" for a way whose first pixel is slower.
    """
    speeds = [abs(count) for count in way]
    rising = speeds[: speeds.index(max(speeds, default=0)) + 1] if speeds else []
    gains = [after - before for before, after in pairwise([0, *rising])]
    if len(gains) < 2 or gains[0] < max(gains):
        return ""
    return (
        f"{who} turns inside a line, and its first pixel accelerates by {gains[0]} steps/px2, as "
        f"hard as any other: a motor that turns runs better by a profile whose first pixel or two "
        f"are slower"
    )


MOST_PIXELS = 2_000_000  # of a line: what a file can hold
MAX_SPEED = 16_382  # steps/pixel: the largest even speed that the board takes as a count


@dataclass(frozen=True)
class LineRequest:
    """What a line shall be: speeds in steps/pixel, lengths in pixels, backlash in steps."""

    speed: int
    pixels: int
    backlash: int = 0
    lead_in: int = 0
    plain: bool = False


@dataclass(frozen=True)
class GeneratedLine:
    """The counts of a line and where its parts are."""

    counts: list[int]
    accelerating_pixels: int
    image_pixel: int  # 1-based file pixel where the image starts, after the lead-in


def acceleration_counts(speeds: list[int], speed: int, source: str = "profile") -> list[int]:
    """Return the counts of the accelerating pixels of a smooth motor from rest to `speed`.

    `speeds` are even, above 0 and non-decreasing speeds at the ends of successive pixels. The
    last pixel is partial: it ends exactly at `speed`. Raises UserError naming the entry for an
    odd, zero or falling speed, an odd `speed` (with the nearest legal ones) and a profile that
    tops out below it.
    """
    for number, problem in speed_problems(speeds):
        raise RefusedError(f"{source}:{number}: {problem}")
    if speed % 2:
        raise UserError(
            f"speed {speed} is odd: every boundary speed of a smooth line is even, "
            f"nearest legal {_even_neighbours(speed)}"
        )
    ends = [*_slower(speeds, speed, source), speed]
    return [(start + end) // 2 for start, end in itertools.pairwise([0, *ends])]


def plain_counts(speeds: list[int], speed: int, source: str = "profile") -> list[int]:
    """Return the accelerating counts of a plain motor: each entry is a speed and a count."""
    if any(later < earlier for earlier, later in itertools.pairwise(speeds)):
        raise RefusedError(f"{source}: the speeds must not fall")
    return _slower(speeds, speed, source)


def _slower(speeds: list[int], speed: int, source: str) -> list[int]:
    """Return the entries below a speed that the profile reaches."""
    if not speeds or speeds[-1] < speed:
        last = speeds[-1] if speeds else 0
        raise UserError(f"{source}: profile tops out at {last} below {speed}")
    return [value for value in speeds if value < speed]


def generate(speeds: list[int], request: LineRequest, source: str = "profile") -> GeneratedLine:
    """Return the line of `request.pixels` pixels: accelerate, hold the speed, the same reversed.

    With backlash the line starts and ends with a zero pixel. Raises UserError for a request out
    of range or too short, then naming the minimum length.
    """
    _check_request(request)
    make = plain_counts if request.plain else acceleration_counts
    ramp = make(speeds, request.speed, source)
    zero = [0] if request.backlash else []
    minimum = 2 * len(ramp) + request.lead_in + 1 + 2 * len(zero)
    if request.pixels < minimum:
        raise UserError(
            f"{request.pixels} pixels are too few: acceleration, lead-in {request.lead_in}, one "
            f"image pixel and deceleration need at least {minimum}"
        )
    constant = request.pixels - 2 * len(ramp) - 2 * len(zero)
    counts = [*zero, *ramp, *([request.speed] * constant), *reversed(ramp), *zero]
    image = len(zero) + len(ramp) + request.lead_in + 1
    return GeneratedLine(counts, len(ramp), image)


def constant(request: LineRequest) -> GeneratedLine:
    """Return the plain line of `request.pixels` pixels that has the speed from end to end."""
    _check_request(request)
    if request.pixels < request.lead_in + 1:
        raise UserError(
            f"{request.pixels} pixels are too few: lead-in {request.lead_in} and one image pixel "
            f"need at least {request.lead_in + 1}"
        )
    return GeneratedLine([request.speed] * request.pixels, 0, request.lead_in + 1)


def speed_problems(speeds: Sequence[int]) -> Iterator[tuple[int, str]]:
    """Yield (record, problem) for every odd, zero or falling speed of a smooth profile."""
    previous = 0
    for number, value in enumerate(speeds, 1):
        if value <= 0:
            yield number, f"speed {value} must be above 0"
        elif value % 2:
            yield number, f"speed {value} is odd, nearest legal {_even_neighbours(value)}"
        elif value < previous:
            yield number, f"speed falls from {previous} to {value}"
        previous = value


def _even_neighbours(value: int) -> str:
    """Return the even speeds above 0 beside an odd one, as text."""
    return " and ".join(str(even) for even in (value - 1, value + 1) if 0 < even <= MAX_SPEED)


def _check_request(request: LineRequest) -> None:
    if not 1 <= request.speed <= MAX_SPEED + 1:
        raise UserError(f"speed {request.speed} is outside 1..{MAX_SPEED} steps/pixel")
    if request.pixels > MOST_PIXELS:
        raise UserError(f"{request.pixels} pixels are too many: a line has {MOST_PIXELS} at most")
    if request.lead_in < 0:
        raise UserError(f"lead-in {request.lead_in} must not be negative")
    if request.backlash < 0:
        raise UserError(f"backlash {request.backlash}: a positive figure only")
    if request.backlash and request.plain:
        raise UserError(f"backlash {request.backlash}: only a smooth line takes up backlash")
    if request.backlash > request.speed:
        raise UserError(
            f"backlash {request.backlash} does not fit one pixel at speed {request.speed}"
        )


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
    target = limits.top_speed // 2  # every pixel gains at least one unit
    return bisect_left(
        range(target), target, lo=1, key=lambda pixels: sum(_envelope(pixels, limits))
    )


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
