# SPDX-License-Identifier: MIT
"""mode1: moves stretched in time by a window of two, as they come; the path is the nominal one.

Each new move is timed as if it were the last one, so that it can always stop. Only the two newest
moves can still be changed.

A corner keeps its shape: where it needs more time, both moves and the blend between them take so
many times as long. Moves that take different times pass their corner as the slower one does, and
the faster one changes its speed on its straight part. On a straight line, from rest and to rest no
blend leaves the path, so there TA alone may grow.

What two moves cannot do so exceeds a limit. With the last move assumed the time law (time_law.py)
then runs the path slower; without it the limit stays exceeded, which is said. Without it the end of
a program shows when only two moves can be changed: if their stop exceeds a limit they are timed so
that the highest acceleration of all blends from the committed move to rest is least, found on a
grid of their times.

A move that mode1 can still stretch, and the arithmetic of its times and limits.

A move of nominal time TM that takes k TM runs its straight part at 1/k of its nominal speed. Its
blends and changes of speed take up parts of its way, together at most all of it.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from pixstep.programs.blends import CornerRamp, Floats, Timed, nominal
from pixstep.programs.motors import Setup
from pixstep.programs.moves import Dwell, ProgramMove
from pixstep.programs.plan_data import ExceededLimit

Speeds = tuple[float, ...]  # counts/ms
SAME = 1e-9
_LEAST_WAY = 1e-3  # part of the way in which a speed may change
_BENT = 1e-9  # part of a speed that turns aside: less is what rounding makes of a straight line


@dataclass(frozen=True)
class OpenMove:
    """A move in the window: `move` is the nominal one, `limits` are the accelerations.

    The blend before it lasts `ta`. Where that is a corner it is passed `entry` times as slowly as
    nominal, and the corner behind the move `exit` times; None is no corner, where the move has its
    own speed. `hurry` is how many times a limit its changes of speed on the straight may take.
    """

    move: Timed
    distance: tuple[float, ...]
    limits: tuple[float, ...]
    tm: float
    ta: float
    why: str = ""
    entry: float | None = None
    exit: float | None = None
    hurry: float = 1.0

    @property
    def k(self) -> float:
        """How many times its nominal time it takes."""
        return self.tm / self.move.tm

    @property
    def speed(self) -> Speeds:
        """The speed of its straight part."""
        return tuple([length / self.tm for length in self.distance])

    @property
    def nominal_speed(self) -> Speeds:
        """The speed of the nominal move."""
        return tuple([length / self.move.tm for length in self.distance])

    @property
    def flank(self) -> float:
        """TS as a part of TA."""
        return self.move.ts / self.move.ta

    @property
    def stop_flank(self) -> float:
        """TS of the stop behind it as a part of its TA."""
        return self.move.stop_ts / self.move.stop_ta

    @property
    def used(self) -> float:
        """The part of its way that its blend and its changes of speed take."""
        if self.entry is None:
            return self.ta / (2 * self.tm) + self._change_part(self.exit)
        blend = self.move.ta / (2 * self.move.tm)
        return blend + self._change_part(self.entry) + self._change_part(self.exit)

    @property
    def room(self) -> float:
        """The longest TA of a blend behind it on the straight line."""
        return 2 * self.tm * (1 - self.used)

    def _change_part(self, corner: float | None) -> float:
        """Return the part of the way on which it gets its own speed from a corner's, or back."""
        if corner is None:
            return 0.0
        return self._change_ms() * abs(self.k**-2 - corner**-2) / (2 * self.move.tm)

    def _change_ms(self) -> float:
        """Return how long its nominal speed takes from rest on the straight."""
        still = tuple([0.0] * len(self.distance))
        return least_ta(still, self.nominal_speed, self.limits, self.flank) / self.hurry

    def slowed(self, tm: float, why: str) -> "OpenMove":
        """Return it with so much time; itself if it has that already."""
        return replace(self, tm=tm, why=why) if tm > self.tm else self

    def loose(self, behind: float) -> "OpenMove":
        """Return it as what always fits the nominal blends, limits of acceleration or not.

        `behind` is the part of the way that the corner behind takes; it is passed at the move's own
        speed. The change from the corner before is as quick as it must be; where no way is left for
        it the move goes on as the corner is passed.
        """
        if self.entry is None:
            return replace(self, ta=min(self.ta, 2 * self.tm * (1 - behind)), exit=None)
        change = self._change_part(self.entry)
        left = 1 - behind - self.move.ta / (2 * self.move.tm)
        if change <= left:
            return replace(self, exit=None)
        if left > _LEAST_WAY:
            return replace(self, exit=None, hurry=self.hurry * change / left)
        return replace(self, tm=self.entry * self.move.tm, exit=None)

    def timed(self, stretched: str, stop_ta: float = 0.0) -> Timed:
        """Return the move for the path; `stop_ta` of the last one.

        `stretched` says why its blend lasts longer than programmed, if it does.
        """
        longer = max(self.ta, stop_ta) > self.move.asked_ta + SAME
        return self.move._replace(
            tm=self.tm, ta=self.ta, ts=self.flank * self.ta, stop_ta=stop_ta,
            stop_ts=self.stop_flank * stop_ta, why=self.why or (stretched if longer else ""),
            entry=self._ramp(self.entry), exit=self._ramp(self.exit),
        )  # fmt: skip

    def _ramp(self, corner: float | None) -> CornerRamp:
        if corner is None:
            return CornerRamp()
        return CornerRamp(self.k / corner, self._change_ms() * abs(1 / self.k - 1 / corner))


def is_corner(before: tuple[float, ...], after: tuple[float, ...]) -> bool:
    """Whether the way turns aside or back between two distances."""
    length = math.hypot(*before)
    along = sum(a * b for a, b in zip(before, after, strict=True))
    square = sum(b * b for b in after)
    if not length or not square:
        return False
    aside = [a - b * along / square for a, b in zip(before, after, strict=True)]
    return along < 0 or math.hypot(*aside) > _BENT * length


def corner_slowness(before: OpenMove, after: OpenMove) -> float:
    """Return how many times as slowly as nominal the corner between two moves must be passed."""
    least = least_ta(before.nominal_speed, after.nominal_speed, after.limits, after.flank)
    return max(1.0, math.sqrt(least / after.move.ta))


def least_ta(before: Speeds, after: Speeds, limits: tuple[float, ...], flank: float) -> float:
    """Return the shortest TA that keeps every acceleration; its peak is dV/(TA - TS)."""
    return max(
        [
            abs(new - old) / (limit * (1 - flank))
            for old, new, limit in zip(before, after, limits, strict=True)
        ]
    )


def least_time(tm: float, before: float, length: float, limit: float) -> float:
    """Return the least time from `tm` on with |before - length/time| <= limit * time."""
    if length < 0 or (length == 0 and before < 0):
        before, length = -before, -length
    # Not too fast: limit t^2 + before t - length >= 0, which holds from its upper root on.
    tm = max(tm, (math.sqrt(before**2 + 4 * limit * length) - before) / (2 * limit))
    # Not too slow: limit t^2 - before t + length >= 0, which fails between its roots.
    under = before**2 - 4 * limit * length
    if before > 0 and under > 0:
        root = math.sqrt(under)
        low, high = (before - root) / (2 * limit), (before + root) / (2 * limit)
        if low * (1 + SAME) < tm < high:
            return high
    return tm


_TIMES = 1.01 ** np.arange(500)  # times of a move that are tried, up to 140 of its own
_LEAST_BLEND = 1e-3  # of a move's time


def reshaped(before: OpenMove | None, window: list[OpenMove]) -> list[OpenMove]:
    """Return the one or two moves of the window with times that stop best."""
    *first, last = window
    if first and last.entry is not None:
        return _around_corner(first[0], last)
    return _in_line(before, first[0] if first else None, last)


def _in_line(before: OpenMove | None, first: OpenMove | None, last: OpenMove) -> list[OpenMove]:
    """Return moves on a straight line: TA of each blend is what its change of speed needs."""
    moves = [one for one in (first, last) if one is not None]
    free = moves[0].entry is None
    grids = [_TIMES * one.tm if one is last or free else np.array([one.tm]) for one in moves]
    times = np.meshgrid(*grids, indexing="ij")
    zero = np.zeros(len(last.limits))
    speeds: list[Floats] = [np.array(before.speed) if before else zero]
    speeds += [np.array(one.distance) / tm[..., None] for one, tm in zip(moves, times, strict=True)]
    flanks = [*(one.flank for one in moves), last.stop_flank]
    changes = [
        np.max(np.abs(b - a) / np.array(last.limits), axis=-1) / (1 - flank)
        for a, b, flank in zip(speeds, [*speeds[1:], zero], flanks, strict=True)
    ]
    if not free:  # its corner is as it is
        changes[0] = np.zeros(1)
    ratio = changes[0] / (before.room if before else np.inf)
    for index, (one, tm) in enumerate(zip(moves, times, strict=True)):
        used = 0.0 if one.entry is None else one.used
        together = (changes[index] + changes[index + 1]) / (2 * (1 - used))
        ratio = np.maximum(
            ratio, np.maximum(together, np.maximum(*changes[index : index + 2])) / tm
        )
    slower = np.sum(times, axis=0)
    best = np.unravel_index(np.lexsort((slower.ravel(), ratio.ravel()))[0], ratio.shape)
    worst = max(float(ratio[best]), 1.0)
    found = []
    for index, (one, tm) in enumerate(zip(moves, times, strict=True)):
        ta = max(float(np.broadcast_to(changes[index], ratio.shape)[best]) / worst,
                 _LEAST_BLEND * float(tm[best]))  # fmt: skip
        made = one.slowed(float(tm[best]), f"stop in {len(moves)} moves")
        found.append(replace(made, ta=ta) if one.entry is None else made)
    return found


def _around_corner(first: OpenMove, last: OpenMove) -> list[OpenMove]:
    """Return moves with a corner between them: it is passed slower, as far as the first can."""
    best: tuple[float, list[OpenMove]] | None = None
    for slowness in max(first.k, last.k) * _TIMES:
        corner = last.move.ta / (2 * first.move.tm)
        slower = replace(first, exit=float(slowness))
        blend = replace(first, exit=None).used
        change, left = slower.used - blend, 1 - blend - corner
        if change > 0 and left <= 0:
            break
        hurry = first.hurry * (max(1.0, change / left) if change > 0 else 1.0)
        made = replace(
            last, tm=float(slowness) * last.move.tm, ta=float(slowness) * last.move.ta,
            entry=float(slowness), hurry=hurry, why="stop in 2 moves",
        )  # fmt: skip
        ratio = max(hurry, (corner_slowness(first, made) / slowness) ** 2, _stop_ratio(made))
        if best is None or ratio < best[0]:
            best = (ratio, [replace(slower, hurry=hurry), made])
    if best is None:  # no way is left to pass the corner more slowly
        return [first, last.loose(last.k * last.move.stop_ta / (2 * last.tm))]
    return best[1]


def _stop_ratio(last: OpenMove) -> float:
    """Return what the stop takes of the limits if it has all the room that is left."""
    need = max(abs(v) / limit for v, limit in zip(last.speed, last.limits, strict=True))
    return need / (1 - last.stop_flank) / last.room


_ROUNDS = 50
_TOLERANCE = 1 + 1e-6  # ratio to a limit that rounding explains


class TwoMoves:
    """Times moves as they come; `violations` grows meanwhile, up to `MOST`."""

    MOST = 1000

    def __init__(self, setup: Setup, *, assume_last: bool = True) -> None:
        self.setup = setup
        self.assume_last = assume_last
        self.violations: list[ExceededLimit] = []
        self.violated = 0
        motors, pixel = setup.motors, setup.pixel_ms
        self._limits = tuple([motor.planned_acceleration(pixel) for motor in motors])
        self._speeds = tuple([motor.planned_speed(pixel) for motor in motors])
        self._still = self._place = tuple([0.0] * len(motors))
        self._before: OpenMove | None = None  # the last one that is timed for good

    def timed(self, events: Iterable[ProgramMove | Dwell]) -> Iterator[Timed | Dwell]:
        """Yield the moves, two behind those that come."""
        window: list[OpenMove] = []
        for event in nominal(events):
            if isinstance(event, Dwell):
                yield from self._stopped(window)
                self._before, window = None, []
                yield event
                continue
            new = self._begun(event)
            if not window:
                window = [self._first(new)]
                continue
            *done, last = window
            last, new = self._joined(done[0] if done else None, last, new)
            for one in done:
                yield self._done(one)
            window = [last, new]
        yield from self._stopped(window)

    def _begun(self, move: Timed) -> OpenMove:
        """Return a move that keeps the limits of speed, and can stop if it were alone."""
        distance = tuple([b - a for a, b in zip(self._place, move.target, strict=True)])
        self._place = move.target
        new = OpenMove(move, distance, self._limits, move.tm, move.ta, move.why)
        new = self._within_speeds(new)
        return self._fitting([(self._still, new.stop_flank)], new) if self.assume_last else new

    def _within_speeds(self, new: OpenMove) -> OpenMove:
        pairs = zip(new.distance, self._speeds, strict=True)
        fastest = max(abs(length) / top for length, top in pairs)
        return new.slowed(fastest, f"speed of {self._name(new.distance, self._speeds)}")

    def _first(self, new: OpenMove) -> OpenMove:
        new = self._fitting([(self._still, new.flank)], new)
        return replace(new, ta=self._blend(self._still, new, new.k))

    def _fitting(self, ends: list[tuple[Speeds, float]], new: OpenMove) -> OpenMove:
        """Return a move with the least time, its own or more, that some blends fit into.

        `ends` are the speeds before or behind it and the flanks of the blends there. A blend fits
        if |v - D/TM| <= A TM for every motor, v being that speed.
        """
        tm = new.tm
        rows = [
            (old, length, limit * (1 - flank))
            for speed, flank in ends
            for old, length, limit in zip(speed, new.distance, self._limits, strict=True)
        ]
        for _ in range(_ROUNDS):
            longer = tm
            for row in rows:
                longer = max(longer, least_time(longer, *row))
            if longer == tm:
                break
            tm = longer
        return new.slowed(tm, self._accelerating(new.distance))

    def _accelerating(self, change: tuple[float, ...]) -> str:
        """Return which acceleration a change of speed asks most of."""
        return f"acceleration of {self._name(change, self._limits)}"

    def _blend(self, before: Speeds, new: OpenMove, k: float) -> float:
        """Return TA of a straight blend into a move: k times the nominal one, or longer."""
        return max(k * new.move.ta, least_ta(before, new.speed, self._limits, new.flank))

    def _joined(
        self, before: OpenMove | None, last: OpenMove, new: OpenMove
    ) -> tuple[OpenMove, OpenMove]:
        """Return the last two moves with times that fit each other."""
        if is_corner(last.distance, new.distance):
            return self._around_corner(before, last, new)
        return self._in_line(before, last, new)

    def _in_line(
        self, before: OpenMove | None, last: OpenMove, new: OpenMove
    ) -> tuple[OpenMove, OpenMove]:
        """Return two moves on a straight line: the new one's TA is what it needs."""
        stop = [(self._still, new.stop_flank)] if self.assume_last else []
        for _ in range(_ROUNDS):
            new = self._fitting([(last.speed, new.flank), *stop], new)
            ta = self._blend(last.speed, new, min(last.k, new.k))
            if ta <= last.room + SAME:
                return last, replace(new, ta=ta)
            why = self._accelerating(_change(last.speed, new.speed))
            slower = self._lengthened(before, last, last.used * last.tm + ta / 2, why)
            if slower is None:
                break
            last = slower
        least = min(last.k, new.k) * new.move.ta
        if last.room < least:
            last = last.loose(least / (2 * last.tm))
        ta = min(self._blend(last.speed, new, min(last.k, new.k)), last.room, new.tm)
        return last, replace(new, ta=ta)

    def _around_corner(
        self, before: OpenMove | None, last: OpenMove, new: OpenMove
    ) -> tuple[OpenMove, OpenMove]:
        """Return two moves whose blend is as much slower as both of them, or as the slower one."""
        slowness = corner_slowness(last, new)
        why = self._accelerating(_change(last.nominal_speed, new.nominal_speed))
        new = new.slowed(slowness * new.move.tm, why)
        corner = new.move.ta / (2 * last.move.tm)  # part of the way
        for k in (max(last.k, slowness), max(last.k, new.k)):
            trial = self._lengthened(before, last, k * last.move.tm, why)
            if trial is not None:
                trial = replace(trial, exit=max(k, new.k))
                if trial.used + corner <= 1 + SAME:
                    last = trial
                    break
        else:
            last = last.loose(corner)
        k = last.k if last.exit is None else last.exit
        return last, replace(new, entry=k, ta=k * new.move.ta)

    def _lengthened(
        self, before: OpenMove | None, last: OpenMove, tm: float, why: str
    ) -> OpenMove | None:
        """Return the move before the newest with more time; None if the one before forbids it."""
        if tm <= last.tm:
            return last
        slower = last.slowed(tm, why)
        if last.entry is not None:
            return slower if slower.used <= 1 else None
        ta = self._blend(
            before.speed if before else self._still, slower,
            min(before.k, slower.k) if before else slower.k,
        )  # fmt: skip
        room = before.room if before else ta
        if ta > room + SAME or ta > slower.tm + SAME:
            return None
        return replace(slower, ta=ta)

    def _stopped(self, window: list[OpenMove]) -> Iterator[Timed]:
        """Yield the moves of the window, the last one with its stop."""
        if not window:
            return
        *_, last = window = [*window[:-1], self._to_whole(window)]
        stop = max(last.k * last.move.stop_ta, self._least_stop(last))
        if stop > last.room + SAME:
            if self.assume_last:
                last = last.loose(last.k * last.move.stop_ta / (2 * last.tm))
                window = [*window[:-1], last]
            else:
                window = reshaped(self._before, window)
                last = window[-1]
            stop = min(max(last.k * last.move.stop_ta, self._least_stop(last)), last.room)
        for one in window[:-1]:
            yield self._done(one)
        yield self._done(last, stop)

    def _to_whole(self, window: list[OpenMove]) -> OpenMove:
        """Return the last move with its end on whole counts, where the path stops."""
        *others, last = window
        whole = tuple([float(round(value)) for value in last.move.target])
        self._place = whole
        more = _change(last.move.target, whole)
        distance = tuple([d + m for d, m in zip(last.distance, more, strict=True)])
        last = replace(last, move=last.move._replace(target=whole), distance=distance)
        last = self._within_speeds(last)
        before = others[-1] if others else None
        if last.entry is not None or not any(more):
            return last
        speed, k = (before.speed, min(before.k, last.k)) if before else (self._still, last.k)
        room = before.room if before else last.tm
        return replace(last, ta=min(max(last.ta, self._blend(speed, last, k)), room, last.tm))

    def _least_stop(self, last: OpenMove) -> float:
        return least_ta(last.speed, self._still, self._limits, last.stop_flank)

    def _done(self, one: OpenMove, stop_ta: float = 0.0) -> Timed:
        """Return a move that is timed for good, with the limits that it exceeds noted."""
        before = self._before
        speed = before.speed if before else self._still
        if before and one.entry is not None:
            ratios = [(corner_slowness(before, one) / one.entry) ** 2, one.hurry]
        else:
            ratios = [least_ta(speed, one.speed, self._limits, one.flank) / one.ta]
        self._note(one, _change(speed, one.speed), max(ratios), "acceleration")
        if stop_ta:
            self._note(one, one.speed, self._least_stop(one) / stop_ta, "acceleration")
        quickest = one.k / min(one.k, one.entry or one.k, one.exit or one.k)
        fastest = max(abs(v) / top for v, top in zip(one.speed, self._speeds, strict=True))
        self._note(one, one.speed, fastest * quickest, "speed")
        self._before = one
        return one.timed(self._accelerating(_change(speed, one.speed)), stop_ta)

    def _note(self, one: OpenMove, asked: Speeds, ratio: float, limit: str) -> None:
        """Note a limit that is exceeded and will stay so."""
        if ratio <= _TOLERANCE or self.assume_last:
            return
        self.violated += 1
        if len(self.violations) < self.MOST:
            name = self._name(asked, self._speeds if limit == "speed" else self._limits)
            self.violations.append(
                {"line": one.move.line, "motor": name, "limit": limit, "ratio": ratio}
            )

    def _name(self, distance: tuple[float, ...], limits: tuple[float, ...]) -> str:
        """Return the motor that a distance asks most of."""
        shares = [abs(d) / limit for d, limit in zip(distance, limits, strict=True)]
        return self.setup.motors[shares.index(max(shares))].name


def _change(before: Speeds, after: Speeds) -> Speeds:
    return tuple([b - a for a, b in zip(before, after, strict=True)])
