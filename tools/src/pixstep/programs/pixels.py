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

import numpy as np
import numpy.typing as npt

from pixstep.lines.runs import MAX_WORD
from pixstep.programs.blends import Floats
from pixstep.programs.evenspeeds import EvenLimits, EvenSpeeds
from pixstep.programs.motors import PlanMotor, Setup
from pixstep.programs.timeline import Timeline

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
    """Makes counts of positions; keeps what it needs between two parts."""

    def __init__(self, setup: Setup) -> None:
        self._before = np.zeros((0, len(setup.motors)))
        self._motors = [_motor(motor, setup.pixel_ms) for motor in setup.motors]
        self._mean = setup.smooth
        self._waiting: list[Counts] = [np.zeros(0, dtype=np.int64) for _ in setup.motors]

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
            if self._mean:
                edges = (known[2 : 2 * pixels + 1 : 2] + middles) / 2
            yield from self._ready(
                motor.counts(
                    np.abs(middles[:, index]) if isinstance(motor, EvenSpeeds) else edges[:, index]
                )
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
            yield np.stack([one[:ready] for one in waiting], axis=1)


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


def _motor(motor: PlanMotor, pixel_ms: float) -> EvenSpeeds | _Nearest:
    """Return what makes a motor's counts."""
    if not motor.smooth:
        return _Nearest()
    jerk = np.inf if motor.max_jerk is None else motor.max_jerk + motor.jerk_rounding
    most = min(motor.max_acceleration * pixel_ms**2, MAX_WORD) // 2 * 2
    return EvenSpeeds(EvenLimits(most, motor.max_speed * pixel_ms, jerk))


def _half_away(values: Floats) -> Counts:
    """Return the nearest whole numbers, halves away from 0."""
    return (np.sign(values) * np.floor(np.abs(values) + 0.5)).astype(np.int64)
