# SPDX-License-Identifier: MIT
"""From w to time: when the path is where, and what every motor does there."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from pixstep.programs.blends import Floats, Intervals
from pixstep.programs.timelaw import Limits, Run

_NOTHING = 1e-200  # instead of 0 below a fraction


@dataclass(frozen=True)
class Timeline:
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


def as_programmed(path: Iterable[Intervals]) -> Iterator[Run]:
    """Yield intervals that are run in the programmed time."""
    for part in path:
        yield Run(part, np.ones(len(part)), np.ones(len(part)))


def timelines(
    runs: Iterable[Run], limits: Limits, *, programmed: bool = False
) -> Iterator[Timeline]:
    """Yield the runs in time; a straight interval gets its ramps, unless all is `programmed`."""
    now = 0.0
    for run in runs:
        if not len(run.path):
            continue
        whole = (run.path, run.begin, run.end)
        path, begin, end = whole if programmed else _with_ramps(run, limits)
        ms = 2 * path.du / (np.sqrt(begin) + np.sqrt(end))
        start = now + np.concatenate([[0.0], np.cumsum(ms)[:-1]])
        made = Timeline(path, start, ms, np.sqrt(begin), (end - begin) / (2 * path.du))
        now = made.end
        yield made


def _with_ramps(run: Run, limits: Limits) -> tuple[Intervals, Floats, Floats]:
    """Divide straight intervals: as fast as the motors can up, at the highest speed, and down."""
    path, begin, end = run.path, run.begin, run.end
    speed = np.abs(path.speed)
    with np.errstate(divide="ignore"):
        gain = np.min(limits.acceleration / np.maximum(speed, _NOTHING), axis=1)
        cap = np.minimum(1.0, np.min((limits.speed / speed) ** 2, axis=1))
    slope = np.where(path.straight & ~path.rest, 2 * gain, 0.0)
    top = np.minimum(np.maximum(cap, np.maximum(begin, end)), (begin + end + slope * path.du) / 2)
    top = np.where(slope > 0, np.maximum(top, np.maximum(begin, end)), begin)
    with np.errstate(invalid="ignore"):
        up = np.where(slope > 0, (top - begin) / np.maximum(slope, _NOTHING), 0.0)
        down = np.where(slope > 0, (top - end) / np.maximum(slope, _NOTHING), 0.0)
    over = np.maximum(up + down, _NOTHING)
    shrink = np.minimum(1.0, path.du / over)
    up, down = up * shrink, down * shrink
    level = np.where(slope > 0, np.maximum(path.du - up - down, 0.0), path.du)
    lengths = np.stack([up, level, down], axis=1)
    firsts = np.stack([begin, np.where(slope > 0, top, begin), top], axis=1)
    lasts = np.stack([top, np.where(slope > 0, top, end), end], axis=1)
    offsets = np.stack([np.zeros_like(up), up, path.du - down], axis=1).ravel()
    chosen = lengths.ravel() > 1e-9 * np.repeat(path.du, 3)
    spread = path.part(np.repeat(np.arange(len(path)), 3)[chosen])
    offset = offsets[chosen][:, None]
    divided = Intervals(
        lengths.ravel()[chosen],
        spread.place + offset * spread.speed * spread.straight[:, None],
        spread.speed, spread.bend, spread.twist, spread.move, spread.rest,
    )  # fmt: skip
    return divided, firsts.ravel()[chosen], lasts.ravel()[chosen]
