# SPDX-License-Identifier: MIT
"""The nearest line of a smooth motor to a motion that is none.

The speeds of a smooth line at the pixel edges are even and each count is the mean of two of them.
Counts of measured or rounded positions seldom are: an odd step is never forgotten, the speed swings
around it to the end. So the speeds are chosen anew. First those are found, of any value, whose
means go along the positions without such a swing. Then of all even speeds close to them, on a line
close to the positions, the best are taken, by the squares of its distances: a shortest way through
(place, speeds) from pixel to pixel. A line that a smooth motor can make stays as it is.

Where no such line is close, as where the motion does not begin at rest, each speed is chosen for
itself, half of the distance that is missing so far made up for in the next one.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from pixstep.lazy import np

if TYPE_CHECKING:
    import numpy.typing as npt

    Places = npt.NDArray[np.float64]
    Speeds = npt.NDArray[np.int64]

_SWING = 1e-3  # weight of the squares of changes of acceleration, so that no swing stays
_STRAY = 0.02  # weight of the squares of distances of speeds, beside those of places
_WIDTHS = (
    (3, 2),
    (5, 4),
    (24, 5),
)  # steps from the positions and even speeds from the best, on each side
_WHOLE = 1e-6  # steps by which a whole number of steps may be off
_RIPPLE = 2  # steps/px around a count that the board takes for a ripple
_FAR = float("inf")


class _Way(NamedTuple):
    """How the best ways come to an edge from the one before."""

    speeds: Speeds  # to choose from at the edge before
    shift: Speeds  # by how much the place goes on more than the motion, from each speed to each
    choice: npt.NDArray[np.int8]  # the speed one edge earlier: by offset, speed before, speed here


def fit(positions: Sequence[Fraction]) -> list[int]:
    """Return counts of a smooth line that goes along positions at the pixel edges, rising from 0.

    It begins and ends at rest; its steps may differ from those asked for by a few.
    """
    places = np.array([float(place) for place in positions])
    speeds = _speeds(places)
    as_it_is = _as_it_is(places, speeds)
    if as_it_is is not None:
        return _counts(as_it_is)
    for widths in _WIDTHS:
        found = _even(places, speeds, *widths)
        if found is not None:
            return _counts(found)
    return _counts(_one_by_one(positions))


def largest_error(counts: Sequence[int], positions: Sequence[Fraction]) -> tuple[Fraction, int]:
    """Return how far a line is from positions, the first 0, at the worst pixel edge, and which."""
    place, worst, at = 0, Fraction(0), 0
    for pixel, (count, wanted) in enumerate(zip(counts, positions[1:], strict=True), 1):
        place += count
        error = abs(wanted - place)
        if error > worst:
            worst, at = error, pixel
    return worst, at


def _counts(speeds: Sequence[int]) -> list[int]:
    return [(before + after) // 2 for before, after in pairwise(speeds)]


def _speeds(places: Places) -> list[float]:
    """Return speeds at the edges, 0 at both ends, whose means are those of the motion.

    v[k-1]/4 + v[k]/2 + v[k+1]/4 is the mean speed around edge k; least squares with a little weight
    on v[k-1] - 2 v[k] + v[k+1], by the normal equations, which have five diagonals.
    """
    wanted = (places[2:] - places[:-2]) / 2
    inner = len(wanted)
    if not inner:
        return [0.0] * len(places)
    padded = np.concatenate([[0.0], wanted, [0.0]])
    right = padded[:-2] / 4 + padded[1:-1] / 2 + padded[2:] / 4
    middle = np.full(inner, 3 / 8 + 6 * _SWING)
    middle[[0, -1]] -= 1 / 16 + _SWING if inner > 1 else 0
    if inner == 1:
        middle[0] = 1 / 4 + 4 * _SWING
    beside, behind = 1 / 4 - 4 * _SWING, 1 / 16 + _SWING
    return [0.0, *_five_diagonals(middle.tolist(), beside, behind, right.tolist()), 0.0]


def _five_diagonals(
    middle: list[float], beside: float, behind: float, right: list[float]
) -> list[float]:
    """Solve symmetric equations of five diagonals, two of which are constant."""
    count = len(middle)
    first, second, pivots = [0.0] * count, [0.0] * count, [0.0] * count
    found = list(right)
    for k in range(count):
        if k >= 2:
            second[k] = behind / pivots[k - 2]
        if k >= 1:
            rest = beside - (second[k] * pivots[k - 2] * first[k - 1] if k >= 2 else 0.0)
            first[k] = rest / pivots[k - 1]
        pivots[k] = middle[k]
        if k >= 1:
            pivots[k] -= first[k] ** 2 * pivots[k - 1]
            found[k] -= first[k] * found[k - 1]
        if k >= 2:
            pivots[k] -= second[k] ** 2 * pivots[k - 2]
            found[k] -= second[k] * found[k - 2]
    for k in reversed(range(count)):
        found[k] /= pivots[k]
        if k + 1 < count:
            found[k] -= first[k + 1] * found[k + 1]
        if k + 2 < count:
            found[k] -= second[k + 2] * found[k + 2]
    return found


def _as_it_is(places: Places, best: Sequence[float]) -> list[int] | None:
    """Return the speeds of a line that the motor can make as it is; None of any other.

    One that swings around the best speeds more than these themselves change is no such line: it is
    a motion that was rounded, whose rounding swings.
    """
    whole = np.rint(places)
    if np.abs(places - whole).max() > _WHOLE:
        return None
    speeds = [0]
    for count in np.diff(whole).astype(np.int64).tolist():
        speeds.append(2 * count - speeds[-1])
    found = np.array(speeds)
    swing = np.sqrt(np.mean((found - best) ** 2))
    change = np.sqrt(np.mean(np.diff(best, 2) ** 2)) if len(best) > 2 else 0.0
    if found.min() < 0 or found[-1] or swing > change / 2 + 1:
        return None
    threes = np.array([found[:-2], found[1:-1], found[2:]])[:, :, None].swapaxes(0, 1)
    return None if any(_swings(*three).any() for three in threes) else speeds


def _even(places: Places, speeds: Sequence[float], steps: int, sides: int) -> list[int] | None:
    """Return the best even speeds near to some, on a line near to places; None if there is none.

    `cost` is that of the best way to each offset of the place (of 2 steps + 1), each speed at the
    edge before (of 2 sides + 1) and each at this edge.
    """
    around = 2 * np.arange(-sides, sides + 1)
    offsets = np.arange(-steps, steps + 1)
    whole = np.rint(places).astype(np.int64)
    before = now = np.zeros(1, dtype=np.int64)
    cost = np.where(offsets == 0, 0.0, _FAR)[:, None, None]
    ways: list[_Way] = []
    for k in range(1, len(places)):
        last = k == len(places) - 1
        then = np.zeros(1, np.int64) if last else 2 * round(speeds[k] / 2) + around
        counts = (now[:, None] + then) // 2
        shift = counts - (whole[k] - whole[k - 1])  # by how much more than the motion it goes on
        index = offsets[:, None, None] + steps - shift
        inside = (index >= 0) & (index < len(offsets))
        index = np.where(inside, index, 0)
        come = cost.transpose(0, 2, 1)[index, np.arange(len(now))[:, None]]
        come = np.where(inside[..., None] & ~_swings(before, now, then), come, _FAR)
        choice = come.argmin(axis=3)
        best = np.take_along_axis(come, choice[..., None], axis=3)[..., 0]
        off = whole[k] + offsets - places[k]
        cost = best + (off**2)[:, None, None] + _STRAY * (then - speeds[k]) ** 2
        cost[:, :, then < 0] = _FAR
        ways.append(_Way(now, shift, choice.astype(np.int8)))
        before, now = now, then
    return _way_back(cost[:, :, 0], steps, ways) if np.isfinite(cost).any() else None


def _swings(before: Speeds, now: Speeds, then: Speeds) -> npt.NDArray[np.bool_]:
    """Return which of three speeds, by now, then and before, are an oscillation to the board.

    That is two equal counts which are entered at a speed other than their own.
    """
    off = np.abs(before[None, :] - now[:, None]) // 2
    counts = np.abs(before[None, :] + now[:, None]) // 2
    large = (off > _RIPPLE) & (100 * off > counts)
    found: npt.NDArray[np.bool_] = (then[None, :, None] == before) & large[:, None, :]
    return found


def _way_back(cost: npt.NDArray[np.float64], steps: int, ways: Sequence[_Way]) -> list[int]:
    """Return the speeds on the best way, from its end, at which the motor is at rest."""
    offset, came = (int(one) for one in np.unravel_index(cost.argmin(), cost.shape))
    at, speeds = 0, [0]
    for way in reversed(ways):
        speeds.append(int(way.speeds[came]))
        earlier = int(way.choice[offset, came, at])
        offset -= int(way.shift[came, at])
        at, came = came, earlier
    return speeds[::-1]


def _one_by_one(positions: Sequence[Fraction]) -> list[int]:
    """Return even speeds, each near to that of the motion at its edge."""
    speeds, place = [0], Fraction(0)
    for k in range(1, len(positions) - 1):
        missing = positions[k - 1] - place
        wanted = (positions[k + 1] - positions[k - 1]) / 2 + missing / 2
        speeds.append(max(0, 2 * round(wanted / 2)))
        place += Fraction(speeds[-2] + speeds[-1], 2)
    speeds.append(0)
    return speeds
