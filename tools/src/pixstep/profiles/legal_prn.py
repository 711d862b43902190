# SPDX-License-Identifier: MIT
"""The legal PRN profile nearest to given speeds: even, above 0, never falling."""

import heapq

from pixstep.profiles.generator import MAX_SPEED
from pixstep.profiles.repair import Change, Repair


def repair_speeds(speeds: tuple[int, ...]) -> Repair:
    """Return the legal profile with the least sum of changes, and the changes, one a record.

    Of equally near ones the lowest is taken.
    """
    nearest = _nearest(speeds)
    changes = []
    highest = 0
    for record, (old, new) in enumerate(zip(speeds, nearest, strict=True), 1):
        if old != new:
            changes.append(Change(record, (old,), (new,), _reason(old, highest)))
        highest = max(highest, old)
    return Repair(nearest, tuple(changes))


def _nearest(speeds: tuple[int, ...]) -> tuple[int, ...]:
    """Least-change non-decreasing even sequence, in units of two.

    The cost of record i as a function of its value is convex with corners at the even neighbours
    of the speed. The heap holds the corners left of the minimum of the cost so far, where a lower
    value may be kept for a later record at no cost: its top is the lowest best value.
    """
    corners: list[int] = []  # negated: heapq keeps the smallest on top
    best = []
    for speed in speeds:
        heapq.heappush(corners, -(speed // 2))
        heapq.heappush(corners, -((speed + 1) // 2))
        heapq.heappop(corners)
        best.append(-corners[0])
    for k in range(len(best) - 2, -1, -1):
        best[k] = min(best[k], best[k + 1])
    return tuple(min(max(2 * value, 2), MAX_SPEED) for value in best)


def _reason(speed: int, highest: int) -> str:
    """Say what is wrong with a record, or that another one's neighbourhood moves it."""
    if speed == 0:
        return "a speed must be above 0"
    if speed > MAX_SPEED:
        return f"above {MAX_SPEED}, the largest speed that a board takes"
    if speed < highest:
        return f"falls below {highest}"
    return "odd: every boundary speed is even" if speed % 2 else "a later record falls below it"
