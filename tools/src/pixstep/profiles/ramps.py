# SPDX-License-Identifier: MIT
"""Boundary speeds of a ramp of given length that change given counts as little as possible."""

from __future__ import annotations

from dataclasses import dataclass

from pixstep.lazy import np
from pixstep.profiles.generator import MAX_SPEED

_NUDGES = (-2, 0, 2)
_SMOOTHER = 1e-13  # weight of the squared accelerations: decides between equally small changes


@dataclass(frozen=True)
class Ramp:
    """From boundary speed `begin` over `counts` to `end` (None: any); all speeds even, >= 0.

    `max_acceleration` is even, None for no limit. The pixels must be enough for it.
    """

    counts: tuple[int, ...]
    begin: int
    end: int | None
    max_acceleration: int | None = None


def decoded(begin: int, counts: tuple[int, ...]) -> list[int]:
    """Return the speeds at the ends of the pixels by the decode rule v' = 2n - v."""
    speeds = [begin]
    for count in counts:
        speeds.append(2 * count - speeds[-1])
    return speeds[1:]


def follows(ramp: Ramp) -> bool:
    """True if the counts as they are lead to the end speed within the limit, never reversing."""
    speeds = [ramp.begin, *decoded(ramp.begin, ramp.counts)]
    if ramp.end is not None and speeds[-1] != ramp.end:
        return False
    if not all(0 <= speed <= MAX_SPEED for speed in speeds):
        return False
    limit = ramp.max_acceleration
    return limit is None or bool(np.all(np.abs(np.diff(speeds)) <= limit))


def pixels_needed(begin: int, end: int, max_acceleration: int | None) -> int:
    """Return the least number of pixels from one speed to another."""
    if max_acceleration is None:
        return int(begin != end)
    return -(-abs(end - begin) // max_acceleration)


def spread(begin: int, end: int, pixels: int) -> list[int]:
    """Return the ends of `pixels` pixels with the speed spread evenly over them, all even."""
    gap = end - begin
    return [begin + 2 * (gap * k // (2 * pixels)) for k in range(1, pixels)] + [end] * (pixels > 0)


def plan(ramp: Ramp) -> list[int]:
    """Return the speeds at the ends of the ramp's pixels: the fewest steps changed.

    The speeds tried at each boundary are those that the counts give from the left and from the
    right, the mean of the neighbouring counts, the even spread, and their even neighbours; a
    shortest path through them is found pixel by pixel.
    """
    choices = [np.array([ramp.begin]), *_choices(ramp)]
    cost = np.zeros(1)
    origins = []
    for count, before, after in zip(ramp.counts, choices, choices[1:], strict=False):
        change = after[None, :] - before[:, None]
        changed = np.abs((after[None, :] + before[:, None]) // 2 - count)
        total = cost[:, None] + changed + _SMOOTHER * change.astype(float) ** 2
        if ramp.max_acceleration is not None:
            total[np.abs(change) > ramp.max_acceleration] = np.inf
        origins.append(np.argmin(total, axis=0))
        cost = np.min(total, axis=0)
    index = int(np.argmin(cost))
    speeds = []
    for values, origin in zip(reversed(choices), reversed(origins), strict=False):
        speeds.append(int(values[index]))
        index = int(origin[index])
    return speeds[::-1]


def _choices(ramp: Ramp) -> list[np.ndarray]:
    """Return the even speeds to try at the end of every pixel, all within reach."""
    pixels = len(ramp.counts)
    counts = np.array(ramp.counts, dtype=np.int64)
    means = (counts + np.append(counts[1:], counts[-1:])) // 4 * 2
    rows = [means, np.array(decoded(ramp.begin, ramp.counts))]
    if ramp.end is None:
        rows.append(np.full(pixels, ramp.begin))
    else:
        backward = [ramp.end, *decoded(ramp.end, ramp.counts[::-1])][pixels - 1 :: -1]
        rows += [np.array(backward), np.array(spread(ramp.begin, ramp.end, pixels))]
    low, high = _reach(ramp)
    table = np.array([row + nudge for row in rows for nudge in _NUDGES])
    return [np.unique(column) for column in np.clip(table, low, high).T]


def _reach(ramp: Ramp) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest speed that each boundary can have."""
    pixels = len(ramp.counts)
    done = np.arange(1, pixels + 1)
    low, high = np.zeros(pixels, dtype=np.int64), np.full(pixels, MAX_SPEED, dtype=np.int64)
    limit = MAX_SPEED if ramp.max_acceleration is None else ramp.max_acceleration
    ends = [(ramp.begin, done)]
    if ramp.end is not None:
        ends.append((ramp.end, pixels - done))
    for speed, distance in ends:
        low = np.maximum(low, speed - limit * distance)
        high = np.minimum(high, speed + limit * distance)
    return low, high
