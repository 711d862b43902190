# SPDX-License-Identifier: MIT
"""A raster from the places that a scan specification visits, one after the other.

A job's lines run at constant speed: so the places of a line must be evenly apart, lines equally
long and evenly apart, and either all in one direction or one forth, one back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby

from pixstep.errors import RefusedError

Point = tuple[Fraction, Fraction]
_DIGITS = 9  # of a coordinate that count
_NEAR = Fraction(1, 10_000)  # of a pixel


@dataclass(frozen=True)
class Raster:
    """A raster of two axes: which one scans (0 or 1), lengths in the unit of the places.

    `first` is the place of the first pixel's middle, of the axis that scans and of the other one;
    `pixel` and `pitch` have the sign of the first line and of the way from line to line.
    """

    fast: int
    lines: int
    pixels: int
    first: Point
    pixel: Fraction
    pitch: Fraction
    alternate: bool


def exact(value: float) -> Fraction:
    """Return a coordinate as the decimal number that was meant."""
    return Fraction(str(round(float(value), _DIGITS)))


def raster(points: Sequence[Point], where: str) -> Raster:
    """Return the raster of some places. Raises RefusedError naming the first that is not in one."""
    if len(points) < 2:
        raise RefusedError(f"{where}: {len(points)} places: a line has two pixels at least")
    first, second = points[0], points[1]
    moving = [axis for axis in (0, 1) if first[axis] != second[axis]]
    if len(moving) != 1:
        raise RefusedError(f"{where}: place 2: one axis scans and the other one stands in a line")
    (fast,) = moving
    slow = 1 - fast
    rows = [[*row] for _, row in groupby(points, key=lambda point: point[slow])]
    signs = _signs(rows, fast, where)
    pixel = _apart([point[fast] for point in rows[0]])
    pitch = _apart([row[0][slow] for row in rows])
    made = Raster(
        fast, len(rows), len(rows[0]), (first[fast], first[slow]), pixel, pitch,
        alternate=len(signs) > 1 and signs[1] < 0,
    )  # fmt: skip
    _compare(points, made, where)
    return made


def _signs(rows: Sequence[Sequence[Point]], fast: int, where: str) -> list[int]:
    """Return of each line whether it runs as the first one (1) or against it (-1)."""
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise RefusedError(
                f"{where}: line {number} has {len(row)} pixels, line 1 has {len(rows[0])}: all "
                f"lines of a job are equally long"
            )
    ways = [row[1][fast] - row[0][fast] for row in rows]
    return [1 if way * ways[0] > 0 else -1 for way in ways]


def _compare(points: Sequence[Point], made: Raster, where: str) -> None:
    """Refuse the first place that is not where the raster has it."""
    for index, (point, right) in enumerate(zip(points, _places(made), strict=True)):
        off = max(abs(found - wanted) for found, wanted in zip(point, right, strict=True))
        if off > _NEAR * abs(made.pixel):
            line, pixel = divmod(index, made.pixels)
            told, expected = (
                ", ".join(f"{float(value):g}" for value in place) for place in (point, right)
            )
            raise RefusedError(
                f"{where}: line {line + 1}, pixel {pixel + 1} at {told}: {expected} expected: "
                f"lines and pixels of a job are evenly apart"
            )


def _apart(places: Sequence[Fraction]) -> Fraction:
    """Return how far places are apart on average, 0 of one alone."""
    return (places[-1] - places[0]) / (len(places) - 1) if len(places) > 1 else Fraction(0)


def _places(made: Raster) -> list[Point]:
    found: list[Point] = []
    for line in range(made.lines):
        back = made.alternate and line % 2 == 1
        order = range(made.pixels - 1, -1, -1) if back else range(made.pixels)
        for pixel in order:
            pair = (made.first[0] + pixel * made.pixel, made.first[1] + line * made.pitch)
            found.append(pair if made.fast == 0 else (pair[1], pair[0]))
    return found
