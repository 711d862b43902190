# SPDX-License-Identifier: MIT
"""lookahead with `max_jerk`: the time law smoothed, so that accelerations change gradually.

Between two stops the programmed time u(t) becomes its mean over a window of W pixels. The path
stays, as only the time changes; on a straight line the acceleration a becomes the mean of a, which
changes by at most 2 a/W in a pixel. Where the path bends, or its blends have no flanks, the limits
are verified for every pixel, and the path is run slower around those that exceed one, until none
does. What that does not bring within the limits is stretched in time as a whole.

A short window leaves less acceleration, a long one delays more: the window with the least time of
several is taken. The plan is not the fastest one possible.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from pixstep.errors import RefusedError
from pixstep.programs import time_law
from pixstep.programs.blends import Floats, Intervals
from pixstep.programs.motors import Setup
from pixstep.programs.pixels import Counts, ProgramTrack, Rounding, Timeline, timelines
from pixstep.programs.time_law import LawBlock, MotorLimits, PacedPath

MOST_PIXELS = 50_000  # between two stops: they are held in memory
_MOST_PIECES = 500_000  # of a path
_LONGER = 4  # times MOST_PIXELS that a slowed section may take
_CELLS = 2  # of a pixel, with an acceleration of u each
_KEPT = 1 + 1e-6  # ratio to a limit that keeps it: what is left is rounding
_ROOM = 0.999  # of a limit that is aimed at, so that few rounds are needed
_LEAST, _MOST = 0.3, 0.97  # factors of w in a round
_ROUNDS = 60
_REST_PIXELS = 3  # of a dwell: then the jerk of one section has ended before the next one
_JERK_EDGES = 3  # edges before a pixel's end that its jerk depends on
_FLOORS = (1e3, 0.3, 0.05, 0.01)  # of the derivative of a length: a high one is u itself
_BISECTIONS = 45
_NOTHING = 1e-300  # instead of 0 below a fraction
_FINE = 8  # pieces of a window at least, so that a part of it can be slowed
_STRETCH = 1.02


def limits_jerk(setup: Setup) -> bool:
    """Whether any motor has a limit of the jerk."""
    return any(motor.max_jerk is not None for motor in setup.motors)


def smoothed(
    name: str, runs: Iterable[PacedPath], limits: MotorLimits, setup: Setup
) -> Iterator[Timeline]:
    """Yield runs in time so that every motor keeps its limit of the jerk, a section at a time.

    Sections begin on pixel edges: a dwell takes whole pixels, at least three. Raises RefusedError
    for a section that is too long.
    """
    pixel, now = setup.pixel_ms, 0.0
    for run in _sections(name, runs, pixel):
        if run.path.rest[0]:
            after = max(np.ceil(now / pixel - 1e-9) + _REST_PIXELS,
                        np.ceil((now + run.path.du[0]) / pixel - 1e-9))  # fmt: skip
            ms = after * pixel - now
            made = Timeline(
                run.path, np.array([now]), np.array([ms]), run.path.du / ms, np.zeros(1)
            )
        else:
            made = _Section(name, run, limits, setup).timeline()
            made = replace(made, start=made.start + now)
        now = made.end
        yield made


def _sections(name: str, runs: Iterable[PacedPath], pixel_ms: float) -> Iterator[PacedPath]:
    """Yield dwells, and all that lies between two of them in one piece."""
    waiting: list[PacedPath] = []
    pixels, pieces = 0.0, 0
    for run in runs:
        places = np.flatnonzero(run.path.rest)
        for part in np.split(np.arange(len(run.path)), np.unique([*places, *(places + 1)])):
            if not len(part):
                continue
            found = run.part(part)
            if found.path.rest[0]:
                if waiting:
                    yield PacedPath.joined(waiting)
                waiting, pixels, pieces = [], 0.0, 0
                yield found
                continue
            waiting.append(found)
            pixels += float(np.sum(found.ms[~found.path.straight])) / pixel_ms
            pieces += len(part)
            if pixels > MOST_PIXELS or pieces > _MOST_PIECES:
                raise _too_long(name)
    if waiting:
        yield PacedPath.joined(waiting)


def _too_long(name: str) -> RefusedError:
    return RefusedError(
        f"{name}: too long to keep a max_jerk: at most {MOST_PIXELS} pixels and {_MOST_PIECES} "
        f"pieces of path between two stops (a DWELL is a stop), or leave max_jerk out"
    )


class _Section:
    """What lies between two stops."""

    def __init__(self, name: str, run: PacedPath, limits: MotorLimits, setup: Setup) -> None:
        self.name, self.run, self.limits, self.setup = name, run, limits, setup
        self.pixel = setup.pixel_ms
        self.cell = self.pixel / _CELLS
        most = [np.inf if motor.max_jerk is None else motor.max_jerk for motor in setup.motors]
        self.jerk = np.array(most)  # steps/px3

    def timeline(self) -> Timeline:
        """Return the section in time, from 0 on."""
        plain = Timeline.joined(list(timelines([self.run], self.limits)))
        if plain.end > MOST_PIXELS * self.pixel:
            raise _too_long(self.name)
        if self._keeps(plain):
            return plain
        best: Timeline | None = None
        for floor in _FLOORS:
            last_best = 0
            for window in self._windows():
                before = best
                best = self._with_window(window, floor, best)
                if best is not before:
                    last_best = window
                elif window < last_best / 2:
                    break
        if best is None:
            raise RefusedError(
                f"{self.name}: no plan of {_LONGER * MOST_PIXELS} pixels between two stops keeps "
                f"max_jerk: raise it or leave it out"
            )
        return best

    def _windows(self) -> Iterator[int]:
        """Yield windows in cells, long ones first."""
        accelerations = self.limits.acceleration * self.pixel**2
        whole = min(float(np.max(2 * accelerations / self.jerk)), float(MOST_PIXELS)) * _CELLS
        window = max(int(np.ceil(whole)), 1)
        while window > 1:
            yield window
            window = int(window / 2**0.5)
        yield 1

    def _with_window(self, window: int, floor: float, best: Timeline | None) -> Timeline | None:
        """Return the section smoothed by a window of cells, or `best` if that takes less time."""
        most = best.end if best is not None else _LONGER * MOST_PIXELS * self.pixel
        pixels = window / _CELLS
        own = np.minimum(
            self.limits.acceleration, self.jerk * max(pixels, 1) / 2 / self.pixel**2
        ) * _ROOM  # fmt: skip
        path = self._fine(pixels)
        bounds = time_law.block(path, replace(self.limits, acceleration=own))
        length = PathLength.of(path, 1 / self.limits.acceleration, floor)
        cap = np.full(len(path), np.inf)
        line: Timeline | None = None
        for _ in range(_ROUNDS):
            run = _capped(path, bounds, cap)
            line, before = self._smooth(run, length, window, most)
            if line is None:
                return best
            slower = self._slower(line)
            if np.all(slower >= 1):
                break
            cap = np.minimum(cap, self._lowered(run, before, window, slower))
        return best if line is None else self._stretched(line, most) or best

    def _fine(self, pixels: float) -> Intervals:
        """Return the path in pieces that are short beside the window."""
        length = max(pixels / _FINE, 1) * self.pixel
        return self.run.path.divided(np.maximum(np.ceil(self.run.ms / length), 1).astype(np.int64))

    def _smooth(
        self, run: PacedPath, length: "PathLength", window: int, most: float
    ) -> tuple[Timeline | None, Timeline]:
        """Return the mean of a run over a window; None if it takes longer than it may."""
        (before,) = timelines([run], self.limits, programmed=True)
        cells = int(np.ceil(before.end / self.cell - 1e-9))
        if (cells + window) * self.cell >= most:
            return None, before
        knots = length.u
        times = np.arange(cells + 1) * self.cell
        index = np.clip(np.searchsorted(before.start, times, side="right") - 1, 0, None)
        t = np.minimum(times - before.start[index], before.ms[index])
        u = knots[index] + before.rate[index] * t + before.gain[index] * t**2 / 2
        u[-1] = knots[-1]
        way = length.at(np.clip(u, 0, knots[-1]))
        longer = np.concatenate([np.zeros(window), way, np.full(window, way[-1])])
        rate = (longer[window:] - longer[:-window]) / (window * self.cell)
        made = np.concatenate([[0.0], np.cumsum((rate[:-1] + rate[1:]) / 2 * self.cell)])
        rates = length.rates(made, rate, self.cell)
        if np.any(rates < 0):
            return None, before
        return _timed(run.path, knots, rates, self.cell / 2), before

    def _slower(self, line: Timeline) -> Floats:
        """Return by which factor w is to fall in each pixel; 1 where every limit is kept."""
        path, limits = line.path, self.limits
        cap = time_law.highest(path, limits)
        fastest = np.maximum(line.rate, line.rate + line.gain * line.ms) ** 2
        acceleration = np.maximum(*(np.abs(one) for one in line.accelerations()))
        most = time_law.accelerations(path, limits)
        ratio = np.maximum(fastest / cap, np.max(acceleration / most, axis=1))
        jerk = np.max(np.abs(jerks(line, self.setup)) / self.jerk, axis=1)
        slower = np.ones(max(len(jerk), int(line.end / self.pixel) + 1))
        over = np.flatnonzero(ratio > _KEPT)
        pixel = (line.start[over] / self.pixel).astype(np.int64)
        np.minimum.at(slower, pixel, _factor(ratio[over]))
        sharp = np.flatnonzero(jerk > _KEPT)
        slower[sharp] = np.minimum(slower[sharp], _factor(jerk[sharp] ** (2 / 3)))
        return slower

    def _keeps(self, line: Timeline) -> bool:
        """Whether every limit is kept, by the counts as well."""
        return bool(np.all(self._slower(line) >= 1)) and self._counts_keep(line)

    def _counts_keep(self, line: Timeline) -> bool:
        """Whether whole steps add no more to the jerk than is stated; plain ones never do."""
        motors = self.setup.motors
        if not any(motor.smooth and motor.max_jerk is not None for motor in motors):
            return True
        counts = np.vstack(list(Rounding(self.setup).counts(_track(line, self.setup))))
        return all(
            counted_jerk(counts[:, index]) <= motor.max_jerk + motor.jerk_rounding
            for index, motor in enumerate(motors)
            if motor.smooth and motor.max_jerk is not None
        )

    def _lowered(self, run: PacedPath, before: Timeline, window: int, slower: Floats) -> Floats:
        """Return new caps: w as it is, lower in all that the window of a pixel has seen."""
        first = (before.start / self.pixel).astype(np.int64)
        reach = window // _CELLS + _JERK_EDGES + 2
        last = ((before.start + before.ms) / self.pixel).astype(np.int64) + reach
        padded = np.append(slower, 1.0)
        bounds = np.stack([first, last], axis=1).ravel()
        bounds = np.minimum(bounds, len(padded) - 1)
        factor = np.minimum.reduceat(padded, bounds)[::2]
        now = np.maximum(run.begin, run.end) * factor
        return np.where(factor < 1, now, np.inf)

    def _stretched(self, line: Timeline, most: float) -> Timeline | None:
        """Return a timeline that keeps every limit: slower as a whole if it does not do so yet.

        None if it would take longer than it may.
        """
        while line.end < most:
            if self._keeps(line):
                return line
            line = replace(
                line, start=line.start * _STRETCH, ms=line.ms * _STRETCH,
                rate=line.rate / _STRETCH, gain=line.gain / _STRETCH**2,
            )  # fmt: skip
        return None


def _capped(path: Intervals, bounds: LawBlock, cap: Floats) -> PacedPath:
    """Run a whole section as fast as its bounds and caps of w allow."""
    block = replace(
        bounds, cap=np.minimum(bounds.cap, cap), end_cap=np.minimum(bounds.end_cap, cap)
    )
    block.backward(np.inf)
    begin, end, _ = time_law.run_forward([block], np.inf, np.inf)
    return PacedPath(path, begin, end)


@dataclass(frozen=True)
class PathLength:
    """A length along the path as a function of the programmed time u: cubic between knots.

    Its derivative is the speed of the motors together, and at least a floor, so that it grows
    where all of them turn round as well. On a straight line with an acceleration from rest the mean
    of u over time would not be the mean of the speed; the mean of the length is.
    """

    u: Floats
    way: Floats
    slope: Floats

    @classmethod
    def of(cls, path: Intervals, weight: Floats, floor: float) -> "PathLength":
        """Return the length with a floor, a share of the highest derivative."""
        du = path.du
        half = (du / 2)[:, None]
        middle = path.speed + half * (path.bend + half * path.twist / 2)
        three = [
            np.linalg.norm(one * weight, axis=1) for one in (path.speed, middle, path.end_speed)
        ]
        least = floor * max(float(np.max(one)) for one in three)
        first, between, last = (np.hypot(one, least) for one in three)
        way = np.concatenate([[0.0], np.cumsum(du * (first + 4 * between + last) / 6)])
        u = np.concatenate([[0.0], np.cumsum(du)])
        return cls(u, way, np.append(first, last[-1:]))

    def at(self, u: Floats) -> Floats:
        """Return the length at some u."""
        index = np.clip(np.searchsorted(self.u, u, side="right") - 1, 0, len(self.u) - 2)
        return self._cubic(index, (u - self.u[index]) / (self.u[index + 1] - self.u[index]))[0]

    def _cubic(self, index: np.ndarray, x: Floats) -> tuple[Floats, Floats]:
        """Return the length and its derivative by x, the share of an interval."""
        du = self.u[index + 1] - self.u[index]
        first, last = self.slope[index] * du, self.slope[index + 1] * du
        way = self.way[index + 1] - self.way[index]
        square, cube = 3 * way - 2 * first - last, first + last - 2 * way
        return (
            self.way[index] + x * (first + x * (square + x * cube)),
            first + x * (2 * square + 3 * x * cube),
        )

    def rates(self, way: Floats, rate: Floats, cell: float) -> Floats:
        """Return du/dt at the ends and in the middle of cells; way and its rate are at the ends."""
        index = np.clip(np.searchsorted(self.way, way, side="right") - 1, 0, len(self.way) - 2)
        low, high = np.zeros(len(way)), np.ones(len(way))
        for _ in range(_BISECTIONS):
            x = (low + high) / 2
            over = self._cubic(index, x)[0] > way
            low, high = np.where(over, low, x), np.where(over, x, high)
        x = (low + high) / 2
        du = self.u[index + 1] - self.u[index]
        u = self.u[index] + x * du
        u[0], u[-1] = 0.0, self.u[-1]
        ends = rate * du / np.maximum(self._cubic(index, x)[1], _NOTHING)
        middles = 2 * np.diff(u) / cell - (ends[:-1] + ends[1:]) / 2
        found = np.empty(2 * len(ends) - 1)
        found[::2], found[1::2] = ends, middles
        return found


def jerks(line: Timeline, setup: Setup) -> Floats:
    """Return the jerk of each motor in steps/px3: the third difference of positions at its edges.

    Those of a smooth motor, and of plain ones beside it, are those of the middles of pixels: the
    speeds are means around edges.
    """
    samples = np.vstack(list(_track(line, setup).samples()))
    places = samples[0::2] if setup.smooth else samples[1::2]
    still = np.zeros((_JERK_EDGES, places.shape[1]))
    return np.diff(np.vstack([still, places, np.repeat(places[-1:], 3, axis=0)]), n=3, axis=0)


def _track(line: Timeline, setup: Setup) -> ProgramTrack:
    """Return where the motors are in a section, as if it began at 0 and at time 0."""
    path = replace(line.path, place=line.path.place - line.path.place[0])
    return ProgramTrack([replace(line, path=path, start=line.start - line.start[0])], setup)


def counted_jerk(counts: Counts) -> int:
    """Return the highest jerk of the counts of a smooth motor as the board decodes them."""
    signs = np.where(np.arange(len(counts)) % 2, -1, 1)
    speeds = 2 * np.cumsum(np.abs(counts) * signs) * signs
    changes = np.diff(np.concatenate([[0], speeds]), prepend=0)
    return int(np.abs(np.diff(changes)).max(initial=0))


def _factor(ratio: Floats) -> Floats:
    """Return by which factor w falls in a round for a ratio to a limit that grows with w."""
    return np.clip(_ROOM / ratio, _LEAST, _MOST)


def _timed(path: Intervals, knots: Floats, rate: Floats, cell: float) -> Timeline:
    """Return a path in time by the rate of u at the ends of cells, in between linear.

    Pieces end where a cell or an interval of the path does.
    """
    gain = np.diff(rate) / cell
    u = np.concatenate([[0.0], np.cumsum((rate[:-1] + rate[1:]) / 2 * cell)])
    inner = knots[1:-1]
    index = np.clip(np.searchsorted(u, inner, side="right") - 1, 0, len(gain) - 1)
    over = np.maximum(inner - u[index], 0)
    root = np.sqrt(np.maximum(rate[index] ** 2 + 2 * gain[index] * over, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        since = np.where(over > 0, 2 * over / (rate[index] + root), 0.0)
    reached = index * cell + np.clip(since, 0, cell)
    edge = np.arange(len(gain)) * cell
    times = np.concatenate([edge, reached])
    interval = np.concatenate(
        [np.clip(np.searchsorted(knots, u[:-1], side="right") - 1, 0, len(path) - 1),
         np.arange(1, len(path))]
    )  # fmt: skip
    own = np.concatenate([np.arange(len(gain)), index])
    order = np.lexsort((interval, times))
    times, interval, own = times[order], np.maximum.accumulate(interval[order]), own[order]
    ms = np.diff(np.append(times, len(gain) * cell))
    chosen = ms > 1e-9 * cell
    times, interval, own, ms = times[chosen], interval[chosen], own[chosen], ms[chosen]
    t = times - own * cell
    first = rate[own] + gain[own] * t
    s = u[own] + rate[own] * t + gain[own] * t**2 / 2 - knots[interval]
    s = np.clip(s, 0, path.du[interval])
    last = first + gain[own] * ms
    part = path.part(interval).within(s, (first + last) / 2 * ms)
    return Timeline(part, times, ms, first, gain[own])
