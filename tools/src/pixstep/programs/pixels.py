# SPDX-License-Identifier: MIT
"""From w to time, and from a plan in time to whole steps per pixel, as the board decodes them.

A plain motor rounds its position at every pixel edge: never more than half a step off, no drift,
and of two neighbouring counts the difference is at most 2 above A T^2.

A smooth motor's pixels have constant acceleration. If v is the mean speed over the pixel around an
edge, then v changes by at most A T^2 from edge to edge, and the trapezoids of v lie on the path
wherever that is straight. The board's speeds are even (even_speeds.py); at rest they are 0 and
positions are even.

Where a smooth motor is among them a plain one takes the mean of the middles beside an edge, too:
all then lie at the same place along the path.
"""

import math
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pixstep.lines.runs import MAX_WORD
from pixstep.programs.blends import ArrayRows, Floats, Intervals
from pixstep.programs.even_speeds import EvenLimits, EvenSpeeds
from pixstep.programs.motors import PlanMotor, Setup
from pixstep.programs.time_law import MotorLimits, PacedPath, speed_cap

_NO_SPEED = 1e-200  # instead of 0 below a fraction


@dataclass(frozen=True)
class Timeline(ArrayRows):
    """Intervals in real time: each begins at `start` ms and lasts `ms`.

    Inside, u grows by rate t + gain t^2 / 2.
    """

    path: Intervals
    start: Floats
    ms: Floats
    rate: Floats
    gain: Floats

    @property
    def end(self) -> float:
        """When the last one ends."""
        return float(self.start[-1] + self.ms[-1])

    def places(self, times: Floats) -> Floats:
        """Return the positions at some times within, one row each."""
        index = np.clip(np.searchsorted(self.start, times, side="right") - 1, 0, None)
        t = times - self.start[index]
        u = np.clip(self.rate[index] * t + self.gain[index] * t**2 / 2, 0, self.path.du[index])
        s = u[:, None]
        path = self.path
        cubic = path.bend[index] / 2 + path.twist[index] * s / 6
        return path.place[index] + s * (path.speed[index] + s * cubic)

    def speeds(self) -> tuple[Floats, Floats]:
        """Return every motor's speed at the beginning and at the end of the intervals."""
        last = self.rate + self.gain * self.ms
        return self.path.speed * self.rate[:, None], self.path.end_speed * last[:, None]

    def accelerations(self) -> tuple[Floats, Floats]:
        """Return every motor's acceleration at the beginning and at the end of the intervals."""
        path, gain = self.path, self.gain[:, None]
        last = self.rate + self.gain * self.ms
        return (
            path.speed * gain + path.bend * self.rate[:, None] ** 2,
            path.end_speed * gain + path.end_bend * last[:, None] ** 2,
        )


@dataclass(frozen=True)
class _Piece(Timeline):
    """A timeline up to a time: what its samples are does not depend on where pieces end."""

    until: float

    @property
    def end(self) -> float:
        return self.until


def in_pieces(lines: Iterable[Timeline], most_ms: float) -> Iterator[Timeline]:
    """Yield the same in pieces that end `most_ms` after each other, however long a move is."""
    for line in lines:
        begin = float(line.start[0])
        count = math.ceil((line.end - begin) / most_ms)
        for number in range(1, count):
            until = begin + number * most_ms
            yield _Piece(line.path, line.start, line.ms, line.rate, line.gain, until)
        yield line


def as_programmed(path: Iterable[Intervals]) -> Iterator[PacedPath]:
    """Yield intervals that are run in the programmed time."""
    for part in path:
        yield PacedPath(part, np.ones(len(part)), np.ones(len(part)))


def timelines(
    runs: Iterable[PacedPath], limits: MotorLimits, *, programmed: bool = False
) -> Iterator[Timeline]:
    """Yield the runs in time; a straight interval gets its ramps, unless all is `programmed`."""
    now = 0.0
    for run in runs:
        if not len(run.path):
            continue
        paced = run if programmed else _with_ramps(run, limits)
        ms = paced.ms
        start = now + np.concatenate([[0.0], np.cumsum(ms)[:-1]])
        gain = (paced.end - paced.begin) / (2 * paced.path.du)
        made = Timeline(paced.path, start, ms, np.sqrt(paced.begin), gain)
        now = made.end
        yield made


def _with_ramps(run: PacedPath, limits: MotorLimits) -> PacedPath:
    """Divide straight intervals: as fast as the motors can up, at the highest speed, and down."""
    path, begin, end = run.path, run.begin, run.end
    speed = np.abs(path.speed)
    gain = np.min(limits.acceleration / np.maximum(speed, _NO_SPEED), axis=1)
    cap = speed_cap(path, limits)
    slope = np.where(path.straight & ~path.rest, 2 * gain, 0.0)
    top = np.minimum(np.maximum(cap, np.maximum(begin, end)), (begin + end + slope * path.du) / 2)
    top = np.where(slope > 0, np.maximum(top, np.maximum(begin, end)), begin)
    with np.errstate(invalid="ignore"):
        up = np.where(slope > 0, (top - begin) / np.maximum(slope, _NO_SPEED), 0.0)
        down = np.where(slope > 0, (top - end) / np.maximum(slope, _NO_SPEED), 0.0)
    over = np.maximum(up + down, _NO_SPEED)
    shrink = np.minimum(1.0, path.du / over)
    up, down = up * shrink, down * shrink
    level = np.where(slope > 0, np.maximum(path.du - up - down, 0.0), path.du)
    lengths = np.stack([up, level, down], axis=1)
    firsts = np.stack([begin, np.where(slope > 0, top, begin), top], axis=1)
    lasts = np.stack([top, np.where(slope > 0, top, end), end], axis=1)
    offsets = np.stack([np.zeros_like(up), up, path.du - down], axis=1).ravel()
    chosen = lengths.ravel() > 1e-9 * np.repeat(path.du, 3)
    spread = path.part(np.repeat(np.arange(len(path)), 3)[chosen])
    divided = spread.within(offsets[chosen], lengths.ravel()[chosen])
    return PacedPath(divided, firsts.ravel()[chosen], lasts.ravel()[chosen])


_NEWTON = 4  # rounds that find the nearest place
_REACH = 4  # half pixels on either side in which the path is looked for
_THIRDS = 30  # of a quarter of a pixel, of a third of it ...
_NOTHING = 1e-300  # instead of 0 below a fraction

Counts = npt.NDArray[np.int64]


class ProgramTrack:
    """Where the motors are to be: every half pixel from -1/2 on, and at any time of these.

    The motion begins at time 0, or half a pixel later with smooth motors, whose speed at the first
    edge is the mean around it.
    """

    def __init__(self, lines: Iterable[Timeline], setup: Setup) -> None:
        self.half = setup.pixel_ms / 2
        self.motors = len(setup.motors)
        self._lines, self._smooth = lines, setup.smooth
        self._delay = self.half if setup.smooth else 0.0
        self._kept: deque[Timeline] = deque()

    def samples(self) -> Iterator[Floats]:
        """Yield positions every half pixel, a row each, until all motors rest."""
        still = np.zeros((1, self.motors))
        yield np.repeat(still, 3 if self._smooth else 2, axis=0)
        given = 2 if self._smooth else 1  # index of the next sample after those
        place = still
        for line in self._lines:
            self._kept.append(line)
            last = int(np.floor((line.end + self._delay) / self.half + 1e-9))
            times = self.time(np.arange(given, last + 1))
            if len(times):
                yield line.places(times)
            given = max(given, last + 1)
            place = line.places(np.array([line.end]))
        pixels = (given + 2) // 2 + 1 if self._smooth else (given + 1) // 2
        yield np.repeat(np.round(place), 2 * pixels + 2 - given, axis=0)

    def time(self, index: npt.NDArray[np.int64]) -> Floats:
        """Return the time of samples in ms, 1 being half a pixel behind the first edge."""
        times: Floats = index.astype(np.float64) * self.half - self._delay
        return times

    def at(self, times: Floats) -> Floats:
        """Return positions at times that are not forgotten, one row each."""
        found = np.zeros((len(times), self.motors))
        starts = [float(line.start[0]) for line in self._kept]
        index = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
        for number in np.unique(index).tolist() if starts else ():
            here = index == number
            found[here] = self._kept[number].places(times[here])
        return found

    def forget(self, time: float) -> None:
        """Let go what ends before a time."""
        while len(self._kept) > 1 and self._kept[0].end < time:
            self._kept.popleft()


class Rounding:
    """Makes counts of positions; keeps what it needs between two parts.

    `off` is how far the positions at pixel edges have been from the path, the motor that is worst:
    from the place where this one is nearest, within two pixels.
    """

    def __init__(self, setup: Setup) -> None:
        self.off = 0.0
        self._place = np.zeros(len(setup.motors))  # of the counts that are made
        self._motors = [_motor(motor, setup) for motor in setup.motors]
        self._mean = setup.smooth
        self._waiting: list[Counts] = [np.zeros(0, dtype=np.int64) for _ in setup.motors]
        self._near = _Near(
            np.zeros(0), np.zeros((0, len(setup.motors)))
        )  # edges whose counts are not made yet

    def counts(self, track: ProgramTrack) -> Iterator[Counts]:
        """Yield counts of whole pixels, a row each.

        A smooth motor's pixels are made some pixels later than others, and wait for the motion's
        end, which the samples reach.
        """
        kept, first = np.zeros((0, track.motors)), -1  # samples, and the index of the first one
        for part in track.samples():
            known = np.vstack([kept, part])
            pixels = (len(known) - 3) // 2
            if pixels < 1:
                kept = known
                continue
            kept = known[2 * pixels :]
            edges = known[3 : 2 * pixels + 2 : 2]
            near = _Near(track.time(first + 3 + 2 * np.arange(pixels)), edges)
            first += 2 * pixels
            yield from self._made(track, known, near)
        yield from self._ready(track, [motor.last_counts() for motor in self._motors])

    def _made(self, track: ProgramTrack, known: Floats, near: "_Near") -> Iterator[Counts]:
        """Yield what can be made of more samples, which have these edges."""
        pixels = len(near.time)
        before, middles = known[2 : 2 * pixels + 1 : 2], known[4 : 2 * pixels + 3 : 2]
        edges = near.place
        if self._mean:
            near = near.beside(before, middles, track)
            edges = (before + middles) / 2
        self._near = _Near.joined([self._near, near])
        made = [
            motor.counts(middles[:, index], near.place[:, index])
            if isinstance(motor, _Even)
            else motor.counts(edges[:, index])
            for index, motor in enumerate(self._motors)
        ]
        yield from self._ready(track, made)

    def _ready(self, track: ProgramTrack, made: list[Counts]) -> Iterator[Counts]:
        waiting = [
            np.concatenate([before, new]) for before, new in zip(self._waiting, made, strict=True)
        ]
        ready = min(map(len, waiting))
        self._waiting = [one[ready:] for one in waiting]
        if ready:
            counts = np.stack([one[:ready] for one in waiting], axis=1)
            places = self._place + np.cumsum(counts, axis=0)
            self._place = places[-1]
            near = self._near.part(slice(ready))
            self.off = near.off(places, self.off, track)
            self._near = self._near.part(slice(ready, None))
            track.forget(float(near.time[-1]) - _REACH * track.half)
            yield counts


@dataclass(frozen=True)
class _Near(ArrayRows):
    """Pixel edges: when they are, and the place of the path beside which the motors are to be."""

    time: Floats
    place: Floats

    def beside(self, before: Floats, behind: Floats, track: ProgramTrack) -> "_Near":
        """Return the places that are nearest to the means of the middles beside edges.

        They are found on the parabola edge + t speed + t^2 bend through the edge and the middles,
        where the mean is edge + bend, then once more from the path at that time.
        """
        speed, bend = (behind - before) / 2, (before + behind) / 2 - self.place
        t = np.zeros(len(self.time))
        for _ in range(_NEWTON):
            away = bend - t[:, None] * (speed + t[:, None] * bend)
            slope = speed + 2 * t[:, None] * bend
            t = t + np.sum(away * slope, axis=1) / np.maximum(np.sum(slope**2, axis=1), _NOTHING)
            t = np.clip(t, -1, 1)
        place = track.at(self.time + t * track.half)
        slope = speed + 2 * t[:, None] * bend
        away = self.place + bend - place
        t = t + np.sum(away * slope, axis=1) / np.maximum(np.sum(slope**2, axis=1), _NOTHING)
        return _Near(self.time, track.at(self.time + np.clip(t, -1, 1) * track.half))

    def off(self, positions: Floats, known: float, track: ProgramTrack) -> float:
        """Return how far positions are from the path, if that is more than `known`."""
        far = np.flatnonzero(np.abs(positions - self.place).max(axis=1) > known)
        if not len(far):
            return known
        time = self.time[far]

        def away(times: Floats) -> Floats:
            found: Floats = np.abs(positions[far] - track.at(times)).max(axis=1)
            return found

        coarse = track.half * np.linspace(-_REACH, _REACH, 8 * _REACH + 1)
        time = time + coarse[np.argmin([away(time + more) for more in coarse], axis=0)]
        low, high = time - track.half / 4, time + track.half / 4
        for _ in range(_THIRDS):
            third = (high - low) / 3
            later = away(low + third) > away(high - third)
            low, high = np.where(later, low + third, low), np.where(later, high, high - third)
        return max(known, float(away((low + high) / 2).max()))


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


class _Even:
    """Makes the counts of a smooth motor: below 0 if it moves that way, as its line cannot say."""

    def __init__(self, limits: EvenLimits) -> None:
        self._speeds = EvenSpeeds(limits)
        self._way = 0  # unknown until it moves

    def counts(self, middles: Floats, edges: Floats) -> Counts:
        """Return counts of pixels by planned middles and the places of the path before these."""
        self._way = self._way or int(np.sign(np.sum(middles)))
        return self._way * self._speeds.counts(self._way * middles, self._way * edges)

    def last_counts(self) -> Counts:
        """Return the counts that are left: the motor has come to rest."""
        return self._way * self._speeds.last_counts()


def _motor(motor: PlanMotor, setup: Setup) -> _Even | _Nearest:
    pixel_ms = setup.pixel_ms
    if not motor.smooth:
        return _Nearest()
    jerk = np.inf if motor.max_jerk is None else motor.max_jerk + motor.jerk_rounding
    most = min(motor.max_acceleration * pixel_ms**2, MAX_WORD) // 2 * 2
    far = max(setup.path_tolerance, 1.0)
    return _Even(EvenLimits(most, motor.max_speed * pixel_ms, jerk, far))


def _half_away(values: Floats) -> Counts:
    """Return the nearest whole numbers, halves away from 0."""
    return (np.sign(values) * np.floor(np.abs(values) + 0.5)).astype(np.int64)
