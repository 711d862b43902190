# SPDX-License-Identifier: MIT
"""From a plan in time to whole steps per pixel, as the board decodes them.

A plain motor rounds its position at every pixel edge: never more than half a step off, no drift,
and of two neighbouring counts the difference is at most 2 above A T^2.

A smooth motor's pixels have constant acceleration. If v is the mean speed over the pixel around an
edge, then v changes by at most A T^2 from edge to edge, and the trapezoids of v lie on the path
wherever that is straight. The board's speeds are even (evenspeeds.py); at rest they are 0 and
positions are even.

Where a smooth motor is among them a plain one takes the mean of the middles beside an edge, too:
all then lie at the same place along the path.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from pixstep.lines.runs import MAX_WORD
from pixstep.programs.blends import Floats
from pixstep.programs.evenspeeds import EvenLimits, EvenSpeeds
from pixstep.programs.motors import PlanMotor, Setup
from pixstep.programs.timeline import Timeline

_NEWTON = 4  # rounds that find the nearest place
_PARABOLA = 0.05  # steps that the path may differ from a parabola in a pixel
_THIRDS = 30  # of half a pixel, of a third of it ...
_NOTHING = 1e-300  # instead of 0 below a fraction

Counts = npt.NDArray[np.int64]


def edges(lines: Iterable[Timeline], setup: Setup) -> Iterator[Floats]:
    """Yield positions every half pixel from -1/2 on: a row each, until all motors rest.

    The motion begins at time 0, or half a pixel later with smooth motors, whose speed at the first
    edge is the mean around it.
    """
    half = setup.pixel_ms / 2
    smooth = setup.smooth
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
    """Makes counts of positions; keeps what it needs between two parts.

    `off` is how far the positions at pixel edges have been from the path, the motor that is worst:
    from the place where this one is nearest.
    """

    def __init__(self, setup: Setup) -> None:
        self.off = 0.0
        self._before = np.zeros((0, len(setup.motors)))
        self._place = np.zeros(len(setup.motors))  # of the counts that are made
        self._motors = [_motor(motor, setup) for motor in setup.motors]
        self._mean = setup.smooth
        self._waiting: list[Counts] = [np.zeros(0, dtype=np.int64) for _ in setup.motors]
        self._paths: list[_Near] = []  # beside the edges whose counts are not made yet

    def counts(self, samples: Iterable[Floats]) -> Iterator[Counts]:
        """Yield counts of whole pixels, a row each, of samples at half pixels from -1/2 on.

        A smooth motor's pixels are made some pixels later than others, and wait for the motion's
        end, which the samples reach.
        """
        for part in samples:
            known = np.vstack([self._before, part])
            pixels = (len(known) - 3) // 2
            if pixels < 1:
                self._before = known
                continue
            self._before = known[2 * pixels :]
            middles = known[4 : 2 * pixels + 3 : 2]
            edges = known[3 : 2 * pixels + 2 : 2]
            path = _Near.exact(edges)
            if self._mean:
                before = known[2 : 2 * pixels + 1 : 2]
                path, edges = _Near.beside(before, edges, middles), (before + middles) / 2
            self._paths.append(path)
            beside = path.places()
            yield from self._ready(
                motor.counts(np.abs(middles[:, index]), np.abs(beside[:, index]))
                if isinstance(motor, EvenSpeeds)
                else motor.counts(edges[:, index])
                for index, motor in enumerate(self._motors)
            )
        yield from self._ready(motor.last_counts() for motor in self._motors)

    def _ready(self, made: Iterable[Counts]) -> Iterator[Counts]:
        """Yield the pixels that are made of all motors."""
        waiting = [
            np.concatenate([before, new]) for before, new in zip(self._waiting, made, strict=True)
        ]
        ready = min(map(len, waiting))
        self._waiting = [one[ready:] for one in waiting]
        if ready:
            counts = np.stack([one[:ready] for one in waiting], axis=1)
            self._measure(counts)
            yield counts

    def _measure(self, counts: Counts) -> None:
        """Note how far the positions behind some pixels are from the path."""
        places = self._place + np.cumsum(counts, axis=0)
        self._place = places[-1]
        path = _Near.joined(self._paths)
        self._paths = [path.part(slice(len(counts), None))]
        self.off = max(self.off, path.part(slice(len(counts))).off(places, self.off))


@dataclass(frozen=True)
class _Near:
    """The path near pixel edges: edge + t speed + t^2 bend, t from -1 to 1; a row for each edge."""

    edge: Floats
    speed: Floats
    bend: Floats
    t: Floats  # where it is nearest to the mean of the middles beside

    @classmethod
    def exact(cls, edges: Floats) -> "_Near":
        """Return what knows the path at the edges alone."""
        still = np.zeros_like(edges)
        return cls(edges, still, still, np.zeros(len(edges)))

    @classmethod
    def beside(cls, before: Floats, edges: Floats, behind: Floats) -> "_Near":
        """Return the parabolas through edges and the middles beside them."""
        middles = cls(edges, (behind - before) / 2, (before + behind) / 2 - edges,
                      np.zeros(len(edges)))  # fmt: skip
        return middles._nearest()

    @staticmethod
    def joined(parts: list["_Near"]) -> "_Near":
        """Return parts in a row."""
        return _Near(
            *(np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(_Near))
        )

    def part(self, choice: slice | npt.NDArray[np.bool_]) -> "_Near":
        """Return some of the edges."""
        return _Near(*(getattr(self, one.name)[choice] for one in fields(_Near)))

    def places(self) -> Floats:
        """Return the nearest places of the path."""
        return self._at(self.t)

    def off(self, positions: Floats, known: float) -> float:
        """Return how far positions at the edges are from the path, if that is more than `known`."""
        far = np.abs(positions - self.places()).max(axis=1) > known
        if not np.any(far):
            return known
        path, positions = self.part(far), positions[far]
        low, high = -np.ones(len(positions)), np.ones(len(positions))
        for _ in range(_THIRDS):
            third = (high - low) / 3
            left, right = path._away(positions, low + third), path._away(positions, high - third)
            low, high = (
                np.where(left > right, low + third, low),
                np.where(left > right, high, high - third),
            )
        return float(path._away(positions, (low + high) / 2).max())

    def _at(self, t: Floats) -> Floats:
        return self.edge + t[:, None] * (self.speed + t[:, None] * self.bend)

    def _away(self, positions: Floats, t: Floats) -> Floats:
        away: Floats = np.abs(positions - self._at(t)).max(axis=1)
        return away

    def _nearest(self) -> "_Near":
        """Return it with the places that are nearest to the means, which are at edge + bend."""
        speed, bend = self.speed, self.bend
        t = self.t
        for _ in range(_NEWTON):
            away = bend - t[:, None] * (speed + t[:, None] * bend)
            slope = speed + 2 * t[:, None] * bend
            t = t + np.sum(away * slope, axis=1) / np.maximum(np.sum(slope**2, axis=1), _NOTHING)
            t = np.clip(t, -1, 1)
        return replace(self, t=t)


class _Nearest:
    """Makes the counts of a plain motor of its positions at edges, the first one behind a pixel."""

    def __init__(self) -> None:
        self._whole = np.int64(0)

    def counts(self, places: Floats) -> Counts:
        """Return the counts of the pixels before these positions."""
        whole = _half_away(places)
        made = np.diff(whole, prepend=self._whole)
        self._whole = whole[-1]
        return made

    def last_counts(self) -> Counts:
        """Return the counts that are left: none."""
        return np.zeros(0, dtype=np.int64)


def _motor(motor: PlanMotor, setup: Setup) -> EvenSpeeds | _Nearest:
    """Return what makes a motor's counts."""
    pixel_ms = setup.pixel_ms
    if not motor.smooth:
        return _Nearest()
    jerk = np.inf if motor.max_jerk is None else motor.max_jerk + motor.jerk_rounding
    most = min(motor.max_acceleration * pixel_ms**2, MAX_WORD) // 2 * 2
    far = max(setup.path_tolerance, 1.0) - _PARABOLA
    return EvenSpeeds(EvenLimits(most, motor.max_speed * pixel_ms, jerk, far))


def _half_away(values: Floats) -> Counts:
    """Return the nearest whole numbers, halves away from 0."""
    return (np.sign(values) * np.floor(np.abs(values) + 0.5)).astype(np.int64)
