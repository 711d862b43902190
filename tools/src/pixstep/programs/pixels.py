# SPDX-License-Identifier: MIT
"""From a plan in time to whole steps per pixel, as the board decodes them.

A plain motor rounds its position at every pixel edge: never more than half a step off, no drift,
and of two neighbouring counts the difference is at most 2 above A T^2.

A smooth motor's pixels have constant acceleration. If v is the mean speed over the pixel around an
edge, then v changes by at most A T^2 from edge to edge, and the trapezoids of v lie on the path
wherever that is straight. The board's speeds u are even: with E = made - planned position and
d = u - v the next u is the even number nearest to v - (E + d/2). What is rounded away, r, is at
most 1; E + d/2 = r one pixel later. So |E| <= 1, |d| <= 2, and the acceleration is off by
r - 2r' + r'', at most 4. At rest u is 0 and positions are even: a smooth line's total is the sum
of its speeds.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from pixstep.lines.runs import MAX_WORD
from pixstep.programs.blends import Floats
from pixstep.programs.motors import Setup
from pixstep.programs.timeline import Timeline

Counts = npt.NDArray[np.int64]
_SMALL_SWING = 2  # steps/px around a count that the board takes for a ripple


def edges(lines: Iterable[Timeline], setup: Setup) -> Iterator[Floats]:
    """Yield positions every half pixel from -1/2 on: a row each, until all motors rest.

    The motion begins at time 0, or half a pixel later with smooth motors, whose speed at the first
    edge is the mean around it.
    """
    half = setup.pixel_ms / 2
    smooth = any(motor.smooth for motor in setup.motors)
    delay = half if smooth else 0.0
    still = np.zeros((1, len(setup.motors)))
    yield np.repeat(still, 3 if smooth else 2, axis=0)
    given = 2 if smooth else 1  # index of the next sample after those, at given * half
    place = still
    for line in lines:
        last = int(np.floor((line.end + delay) / half + 1e-9))
        times = np.arange(given, last + 1, dtype=np.float64) * np.float64(half) - delay
        if len(times):
            yield line.places(times)
        given = max(given, last + 1)
        place = line.places(np.array([line.end]))
    pixels = (given + 2) // 2 + 1 if smooth else (given + 1) // 2
    yield np.repeat(np.round(place), 2 * pixels + 2 - given, axis=0)


class Rounding:
    """Makes counts of positions; keeps what it needs between two parts."""

    def __init__(self, setup: Setup) -> None:
        self.motors = setup.motors
        self._smooth = [motor.smooth for motor in setup.motors]
        self._before = np.zeros((0, len(setup.motors)))
        count = len(setup.motors)
        self._whole = np.zeros(count, dtype=np.int64)
        limits = [motor.max_acceleration * setup.pixel_ms**2 for motor in setup.motors]
        self._rows = [_Smooth(int(min(limit, MAX_WORD)) // 2 * 2) for limit in limits]

    def counts(self, samples: Iterable[Floats]) -> Iterator[Counts]:
        """Yield counts of whole pixels, a row each, of samples at half pixels from -1/2 on."""
        for part in samples:
            known = np.vstack([self._before, part])
            pixels = (len(known) - 3) // 2
            if pixels < 1:
                self._before = known
                continue
            yield self._made(known, pixels)
            self._before = known[2 * pixels :]

    def _made(self, known: Floats, pixels: int) -> Counts:
        """Return counts of pixels; row 0 is half a pixel before the first of them."""
        made = np.empty((pixels, len(self.motors)), dtype=np.int64)
        whole = _half_away(known[3 : 2 * pixels + 2 : 2])
        for index, smooth in enumerate(self._smooth):
            if smooth:
                middles = known[2 : 2 * pixels + 3 : 2, index]
                made[:, index] = self._rows[index].counts(np.abs(middles))
            else:
                made[:, index] = np.diff(whole[:, index], prepend=self._whole[index])
        self._whole = whole[-1]
        return made


def _half_away(values: Floats) -> Counts:
    """Return the nearest whole numbers, halves away from 0."""
    return (np.sign(values) * np.floor(np.abs(values) + 0.5)).astype(np.int64)


class _Changes(NamedTuple):
    """What surrounds a speed: the one before, the planned one, and what is wanted behind it.

    The next speed makes good by how much this one differs from the planned one.
    """

    before: int
    planned: float
    wanted_later: float

    def most(self, speed: int) -> float:
        """Return the larger change of speed, to this one and from it."""
        later = max(0, 2 * round((self.wanted_later - (speed - self.planned)) / 2))
        return max(abs(speed - self.before), abs(later - speed))


@dataclass
class _Smooth:
    """The speed of a smooth motor at the last edge, and what is left of its rounding."""

    limit: int  # of the change of speed in a pixel
    speed: int = 0  # u at the last edge
    earlier: int = 0  # u one edge before
    planned: float = 0.0  # v at the last edge
    error: float = 0.0  # made - planned position

    def counts(self, middles: Floats) -> list[int]:
        """Return the counts of pixels by positions: the middle of each, and of the next one."""
        speeds = np.diff(middles).tolist()
        made = []
        u, before, v, error = self.speed, self.earlier, self.planned, self.error
        for ahead, later in zip(speeds, [*speeds[1:], None], strict=True):
            # Here v and u are those of the edge where the pixel begins, `ahead` of where it ends.
            wanted = ahead - (error + (u - v) / 2)
            new = max(0, 2 * round(wanted / 2))
            if new == before != u and _swings(u, new):
                beyond = (2 * ahead - v if later is None else later) - error - (u - v) / 2
                new = _beside(new, wanted, _Changes(u, ahead, beyond).most, self.limit)
            error += (u + new) / 2 - (v + ahead) / 2
            made.append((u + new) // 2)
            before, u, v = u, new, ahead
        self.speed, self.earlier, self.planned, self.error = u, before, v, error
        return made


def _swings(speed: int, other: int) -> bool:
    """Whether two equal counts would be taken for an oscillation: one entered at other speed."""
    amplitude, count = abs(speed - other) // 2, (speed + other) // 2
    return amplitude > _SMALL_SWING and 100 * amplitude > count


def _beside(speed: int, wanted: float, most: Callable[[int], float], limit: int) -> int:
    """Return the even speed beside one that would swing: the nearer one to what is wanted.

    Where this and the next pixel would accelerate by more than the limit with it, the other one.
    """
    first, second = (2, -2) if wanted >= speed or speed == 0 else (-2, 2)
    other = speed + second
    if other < 0 or most(speed + first) <= max(limit, most(other)):
        return speed + first
    return other
