# SPDX-License-Identifier: MIT
"""The even speeds of a smooth motor: its position in the middle of each pixel, on even steps.

The speed at an edge is the difference of the positions in the middles of the pixels beside the
edge, which is even where these positions are. So each middle is rounded to the nearest even step; r
is what the rounding adds, at most 1 either way.

    position at an edge       off by (r + r')/2         at most 1
    speed                     off by r' - r             at most 2
    acceleration              off by r - 2 r' + r''     at most 4

Two equal counts that are entered at another speed are an oscillation to the board. Where the
nearest steps make one, some middles near by are rounded to another even step: those with which
every limit is kept, the edges stay within 1 step, and the sum of r^2 is least. A middle at rest,
between others at rest, stays where it is, so that the distance is exact.
"""

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from pixstep.programs.blends import Floats

Steps = npt.NDArray[np.int64]
_SMALL_SWING = 2  # steps/px around a count that the board takes for a ripple
_SWING = 4  # middles that make an oscillation
_WIDER = 3  # more middles on either side of these that may be moved
_BESIDE = 3  # middles on either side of a moved one that its jerk is made of
_BEFORE = _BESIDE + 1  # settled middles that are kept
_LATER = _SWING + _WIDER + _BESIDE  # middles from the first of an oscillation on that are looked at
_ROUNDING = 1e-6  # steps: what numbers of limited length add


class EvenLimits(NamedTuple):
    """What a smooth motor may do, whole steps included: steps and pixels.

    `off` is how far it may be from the path.
    """

    acceleration: float
    speed: float = np.inf
    jerk: float = np.inf
    off: float = 1.0


class EvenSpeeds:
    """Makes the counts of a smooth motor, which begins at rest at 0, of its planned middles.

    Whatever the parts are in which these come, the counts are the same.
    """

    def __init__(self, limits: EvenLimits) -> None:
        self._limits = limits
        self._planned = np.zeros(_BEFORE)
        self._edges = np.zeros(_BEFORE)  # where the motor should be before each middle
        self._middles = np.zeros(_BEFORE)  # as they are rounded, known up to the last but one
        self._made = np.zeros(_BEFORE, dtype=np.int64)  # the first _BEFORE are settled
        self._unseen = 1  # where something may be wrong that is not looked at yet

    def counts(self, planned: Floats, edges: Floats) -> Steps:
        """Return counts of pixels, the newest pixels in a later call.

        `edges` are the places before the middles, where the motor should be. Count k reaches from
        the edge behind middle k to the next one; middle 0, which is 0, is not in the first part.
        """
        self._planned = np.concatenate([self._planned, planned])
        self._edges = np.concatenate([self._edges, edges])
        self._round()
        seen = max(len(self._made) - _LATER + 1, self._unseen)
        place = self._next_wrong(self._unseen)
        while place < seen:
            self._mend(place)
            place = self._next_wrong(place + 1)
        return self._settled(seen)

    def last_counts(self) -> Steps:
        """Return the counts that are left: the motor has come to rest."""
        left = len(self._planned) - _BEFORE
        still = np.repeat(self._planned[-1:], _LATER + _WIDER + 1)
        return self.counts(still, still)[:left]

    def _round(self) -> None:
        """Round the middles whose next edge is known to even steps.

        Middles are moved by as much as their means are off at the edges beside them, half each,
        but not beyond their neighbours; those at rest and beside a rest stay.
        """
        first = len(self._made)
        planned = self._planned[first - 1 :]
        cut = (planned[:-1] + planned[1:]) / 2 - self._edges[first:]
        moving = (planned[:-2] < planned[1:-1]) & (planned[1:-1] < planned[2:])
        middles = planned[1:-1] - np.where(moving, cut[:-1] + cut[1:], 0.0) / 2
        middles = np.clip(middles, planned[:-2], planned[2:])
        nearest = 2 * np.rint(middles / 2).astype(np.int64)
        self._middles = np.concatenate([self._middles, middles])
        self._made = np.maximum.accumulate(np.concatenate([self._made, nearest]))

    def _next_wrong(self, begin: int) -> int:
        """Return the first middle from here on with which something is wrong, else their number."""
        made, limits = self._made[begin:], self._limits
        speeds = np.diff(made)
        wrong = np.zeros(len(made), dtype=bool)
        wrong[:-3] |= oscillates(made) | (np.abs(np.diff(speeds, n=2)) > limits.jerk)
        wrong[:-2] |= np.abs(np.diff(speeds)) > limits.acceleration
        wrong[:-1] |= speeds > limits.speed
        edges = self._edges[begin + 1 : len(self._made)]
        wrong[:-1] |= np.abs((made[1:] + made[:-1]) / 2 - edges) > limits.off + _ROUNDING
        found = np.flatnonzero(wrong)
        return begin + int(found[0]) if len(found) else len(self._made)

    def _settled(self, seen: int) -> Steps:
        """Return the counts that nothing changes any more, and forget them."""
        end = max(seen - _WIDER, _BEFORE)
        counts = (self._made[_BEFORE:end] - self._made[_BEFORE - 2 : end - 2]) // 2
        gone = end - _BEFORE
        self._planned, self._edges = self._planned[gone:], self._edges[gone:]
        self._middles, self._made = self._middles[gone:], self._made[gone:]
        self._unseen = seen - gone
        return counts

    def _mend(self, place: int) -> None:
        """Move middles about an oscillation, as few as do."""
        best: tuple[tuple[float, ...], slice, Steps] | None = None
        for more in range(_WIDER + 1):
            begin = max(place - more, _BEFORE)
            moved = slice(begin, place + _SWING + more)
            cost, found = self._moved(moved, place)
            if best is None or cost < best[0]:
                best = (cost, moved, found)
            if not any(cost[:-1]):
                break
        if best is not None:
            self._made[best[1]] = best[2]

    def _moved(self, moved: slice, place: int) -> tuple[tuple[float, ...], Steps]:
        """Return the best even steps for some middles, and what is wrong with them.

        What oscillates behind `place` is mended in its turn.
        """
        seen = slice(moved.start - _BESIDE, moved.stop + _BESIDE)
        middles, made = self._middles[seen], self._made[seen]
        inner = slice(_BESIDE, -_BESIDE)
        planned = self._planned[seen]
        moving = planned[_BESIDE - 1 : -_BESIDE - 1] < planned[_BESIDE + 1 : 1 - _BESIDE]
        choice = _choices(moved.stop - moved.start)
        choice = choice[np.all((choice == 0) | moving, axis=1)]
        steps = np.tile(made, (len(choice), 1))
        steps[:, inner] += choice
        steps = steps[np.all(np.diff(steps) >= 0, axis=1)]
        wrong = self._wrong(steps, steps - middles, self._edges[seen], place + 1 - seen.start)
        best = np.lexsort(wrong[::-1])[0]
        return tuple(float(one[best]) for one in wrong), steps[best, inner]

    def _wrong(self, steps: Steps, off: Floats, edges: Floats, looked_at: int) -> list[Floats]:
        """Return what is wrong with each row of middles, the worst kind first."""
        limits = self._limits
        beyond = [
            np.maximum(np.abs(np.diff(steps, n=order)) - most, 0).sum(axis=1)
            for order, most in enumerate((limits.speed, limits.acceleration, limits.jerk), 1)
        ]
        away = np.abs((steps[:, 1:] + steps[:, :-1]) / 2 - edges[1:])
        far = np.maximum(away.max(axis=1) - limits.off - _ROUNDING, 0)
        return [
            oscillates(steps)[:, :looked_at].sum(axis=1).astype(np.float64), sum(beyond), far,
            np.sum(off**2, axis=1),
        ]  # fmt: skip


def oscillates(steps: Steps) -> npt.NDArray[np.bool_]:
    """Whether the board takes each four middles in a row for an oscillation."""
    speeds = np.diff(steps)
    first, second = speeds[..., :-2], speeds[..., 1:-1]
    swing, count = np.abs(first - second) // 2, (first + second) // 2
    wide = (swing > _SMALL_SWING) & (100 * swing > count)
    found: npt.NDArray[np.bool_] = wide & (first == speeds[..., 2:])
    return found


@cache
def _choices(count: int) -> Steps:
    """Return all ways in which middles may lie on the even step beside, a row each."""
    return np.array(list(product((-2, 0, 2), repeat=count)))
