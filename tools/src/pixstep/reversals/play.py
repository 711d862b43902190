# SPDX-License-Identifier: MIT
"""The play model: where a plain line turns, and how the load follows the motor behind it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True)
class Stroke:
    """Pixels that move in one direction, the zero pixels before the motion included."""

    start: int  # 0-based
    end: int  # behind the last
    direction: int


def directions(counts: Sequence[int]) -> list[int]:
    """Return each pixel's direction: the sign of the next count that is not zero.

    So zero pixels between two motions belong to the one that follows: the play is taken up while
    the load rests. The zero pixels at the end keep the last direction; 0 if nothing moves.
    """
    last = next((count for count in reversed(counts) if count), 0)
    sign = (last > 0) - (last < 0)
    found = []
    for count in reversed(counts):
        sign = sign if count == 0 else (count > 0) - (count < 0)
        found.append(sign)
    return found[::-1]


def strokes(counts: Sequence[int]) -> list[Stroke]:
    """Return the strokes of a line; none if nothing moves."""
    signs = directions(counts)
    if not any(signs):
        return []
    starts = [0, *(i for i, (a, b) in enumerate(pairwise(signs), 1) if a != b)]
    return [Stroke(start, end, signs[start]) for start, end in pairwise([*starts, len(counts)])]


def load_positions(motor: Iterable[int], play: int, taken_up: int) -> list[int]:
    """Return the load's position at each of the motor's, both in steps from 0 at the start.

    `taken_up` is the direction (+1 or -1) in which the play is taken up at the start. The motor
    must not turn back between two of its positions (a plain pixel has one direction), so that
    looking at the pixel edges alone loses nothing.
    """
    low = 0 if taken_up > 0 else -play  # of load - motor; the play is above it
    load = 0
    positions = []
    for position in motor:
        load = min(max(load, position + low), position + low + play)
        positions.append(load)
    return positions
