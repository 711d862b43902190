# SPDX-License-Identifier: MIT
"""Plain lines that turn: a way out, a rest, and the way back."""

from collections.abc import Sequence
from itertools import pairwise


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
