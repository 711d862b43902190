# SPDX-License-Identifier: MIT
"""mode1: limits of speed and acceleration kept by a window of two moves, as they come.

Each new move is timed as if it were the last one, so that it can always stop. Of the moves before
it only one can still be changed; a stop that would need more exceeds the limit, which is said.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from pixstep.programs.blends import Timed
from pixstep.programs.motors import Setup
from pixstep.programs.moves import Dwell, Move

_ROUNDS = 50
_SAME = 1e-9
_TOLERANCE = 1 + 1e-6  # ratio to a limit that rounding explains


class Violation(NamedTuple):
    """A blend that exceeds a motor's acceleration; `line` is that of the program."""

    line: int
    motor: str
    ratio: float


@dataclass(frozen=True)
class _Open:
    """A move in the window; `speed` is in counts/ms, the blend before it lasts `ta`."""

    move: Move
    distance: tuple[float, ...]
    tm: float
    ta: float
    why: str = ""

    @property
    def speed(self) -> tuple[float, ...]:
        return tuple([length / self.tm for length in self.distance])

    @property
    def share(self) -> float:
        """TS as a part of TA."""
        return self.move.ts / self.move.ta

    def timed(self, stretched: str, stop_ta: float = 0.0) -> Timed:
        """Return the move for the path; `stop_ta` of the last one.

        `stretched` says why its blend lasts longer than programmed, if it does.
        """
        move, share = self.move, self.share
        longer = max(self.ta, stop_ta) > move.ta + _SAME
        return Timed(
            move.line, move.target, self.tm, self.ta, share * self.ta, stop_ta, share * stop_ta,
            move.tm, self.why or (stretched if longer else ""),
        )  # fmt: skip


class TwoMoves:
    """Times moves as they come; `violations` grows meanwhile, up to `MOST`."""

    MOST = 1000

    def __init__(self, setup: Setup, *, assume_last: bool = True) -> None:
        self.setup = setup
        self.assume_last = assume_last
        self.violations: list[Violation] = []
        self.violated = 0
        self._limits = [motor.planned_acceleration(setup.pixel_ms) for motor in setup.motors]
        self._speeds = [motor.planned_speed(setup.pixel_ms) for motor in setup.motors]
        self._place = tuple([0.0] * len(setup.motors))
        self._still = self._place

    def timed(self, events: Iterable[Move | Dwell]) -> Iterator[Timed | Dwell]:
        """Yield the moves, two behind those that come."""
        done: _Open | None = None  # the last one that cannot be changed
        last: _Open | None = None
        for event in events:
            if isinstance(event, Dwell):
                yield from self._stopped(done, last)
                done = last = None
                yield event
                continue
            new = self._begun(event)
            if last is None:
                last = self._first(new)
                continue
            last, new = self._joined(done, last, new)
            yield last.timed(self._weakest(done, last))
            done, last = last, new
        yield from self._stopped(done, last)

    def _begun(self, move: Move) -> _Open:
        """Return a move that keeps the limits of speed, and can stop if it were alone."""
        distance = tuple([b - a for a, b in zip(self._place, move.target, strict=True)])
        self._place = move.target
        pairs = list(zip(distance, self._speeds, strict=True))
        fastest = max(abs(length) / top for length, top in pairs)
        tm, why = move.tm, ""
        if move.ta > tm:
            tm, why = move.ta, "acceleration time"
        if fastest > tm:
            tm, why = fastest, f"speed of {self._name(distance, self._speeds)}"
        return _Open(move, distance, tm, move.ta, why)

    def _first(self, new: _Open) -> _Open:
        """Return a move that begins at rest."""
        new = self._fitting(self._still, new)
        return replace(new, ta=self._blend(self._still, new))

    def _fitting(self, before: tuple[float, ...], new: _Open) -> _Open:
        """Return a move with the least time, its own or more, that its blends fit into.

        A blend fits if |v - D/TM| <= A TM for every motor, v being the speed before it; a stop is
        the same with v = 0.
        """
        tm = new.tm
        speeds = [before, self._still] if self.assume_last else [before]
        rows = [
            (old, length, limit * (1 - new.share))
            for speed in speeds
            for old, length, limit in zip(speed, new.distance, self._limits, strict=True)
        ]
        for _ in range(_ROUNDS):
            longer = tm
            for row in rows:
                longer = max(longer, _least_time(longer, *row))
            if longer == tm:
                break
            tm = longer
        return new if tm == new.tm else self._slower(new, tm)

    def _slower(self, new: _Open, tm: float) -> _Open:
        name = self._name(new.distance, self._limits)
        return replace(new, tm=tm, why=f"acceleration of {name}")

    def _blend(self, before: tuple[float, ...], new: _Open) -> float:
        """Return TA of the blend into a move: as programmed, or longer for the accelerations."""
        return max(new.move.ta, self._least(before, new.speed, new.share))

    def _least(self, before: tuple[float, ...], after: tuple[float, ...], share: float) -> float:
        """Return the shortest TA that keeps every acceleration; its peak is dV/(TA - TS)."""
        return max(
            [
                abs(new - old) / (limit * (1 - share))
                for old, new, limit in zip(before, after, self._limits, strict=True)
            ]
        )

    def _joined(self, done: _Open | None, last: _Open, new: _Open) -> tuple[_Open, _Open]:
        """Return the last two moves with times that fit each other."""
        for _ in range(_ROUNDS):
            new = self._fitting(last.speed, new)
            ta = self._blend(last.speed, new)
            if ta <= 2 * (last.tm - last.ta / 2) + _SAME:
                return last, replace(new, ta=ta)
            slower = self._lengthened(done, last, (ta + last.ta) / 2)
            if slower is None:
                break
            last = slower
        room = 2 * (last.tm - last.ta / 2)
        new = replace(new, ta=min(self._blend(last.speed, new), room, new.tm))
        self._judge(last.speed, new)
        return last, new

    def _lengthened(self, done: _Open | None, last: _Open, tm: float) -> _Open | None:
        """Return the move before the newest with more time; None if the one before forbids it."""
        slower = self._slower(last, tm)
        before = done.speed if done else self._still
        ta = self._blend(before, slower)
        room = 2 * (done.tm - done.ta / 2) if done else ta
        if ta > room + _SAME or ta > slower.tm + _SAME:
            return None
        return replace(slower, ta=ta)

    def _stopped(self, done: _Open | None, last: _Open | None) -> Iterator[Timed]:
        """Yield the last move, with its stop."""
        if last is None:
            return
        stop = max(last.move.ta, self._least(last.speed, self._still, last.share))
        room = 2 * (last.tm - last.ta / 2)
        if stop > room + _SAME:
            slower = self._stopping(done, last)
            stop = min(max(last.move.ta, self._least(slower.speed, self._still, last.share)),
                       2 * (slower.tm - slower.ta / 2))  # fmt: skip
            last = slower
            self._judge(done.speed if done else self._still, last)
            self._judge_stop(last, stop)
        yield last.timed(self._weakest(done, last), stop)

    def _stopping(self, done: _Open | None, last: _Open) -> _Open:
        """Return the last move slowed down so that it ends at rest, as well as that can be."""
        before = done.speed if done else self._still
        room = 2 * (done.tm - done.ta / 2) if done else None
        for _ in range(_ROUNDS):
            ta = self._blend(before, last)
            ta = ta if room is None else min(ta, room)
            stop = max(last.move.ta, self._least(last.speed, self._still, last.share))
            need = (ta + stop) / 2
            last = replace(last, ta=ta)
            if need <= last.tm + _SAME:
                break
            last = replace(self._slower(last, need), ta=ta)
        return last

    def _judge(self, before: tuple[float, ...], new: _Open) -> None:
        """Note a blend whose acceleration is above a limit."""
        self._note(new, before, new.speed, new.ta)

    def _judge_stop(self, last: _Open, ta: float) -> None:
        self._note(last, last.speed, self._still, ta)

    def _note(
        self, new: _Open, before: tuple[float, ...], after: tuple[float, ...], ta: float
    ) -> None:
        ratios = [
            abs(b - a) / (ta * (1 - new.share) * limit)
            for a, b, limit in zip(before, after, self._limits, strict=True)
        ]
        worst = max(ratios)
        if worst > _TOLERANCE:
            self.violated += 1
            if len(self.violations) < self.MOST:
                name = self.setup.motors[ratios.index(worst)].name
                self.violations.append(Violation(new.move.line, name, worst))

    def _weakest(self, done: _Open | None, last: _Open) -> str:
        """Return which acceleration the blend into a move needs most of."""
        before = done.speed if done else self._still
        change = tuple([b - a for a, b in zip(before, last.speed, strict=True)])
        return f"acceleration of {self._name(change, self._limits)}"

    def _name(self, distance: tuple[float, ...], limits: list[float]) -> str:
        """Return the motor that a distance asks most of."""
        shares = [abs(d) / limit for d, limit in zip(distance, limits, strict=True)]
        return self.setup.motors[shares.index(max(shares))].name


def _least_time(tm: float, before: float, length: float, limit: float) -> float:
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
        if low * (1 + _SAME) < tm < high:
            return high
    return tm
