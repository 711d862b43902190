# SPDX-License-Identifier: MIT
"""The nominal path: moves blended as programmed, as intervals of the programmed time u.

Blend i is centred on the boundary of moves i-1 and i and lasts TA; the speed changes there from
V of one move to V of the next by a trapezoid of acceleration whose flanks last TS each. Distances
stay exact, as the blend is symmetric.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from pixstep.programs.moves import Dwell, ProgramMove

Floats = npt.NDArray[np.float64]
_FLANK, _TOP = 6, 10  # intervals of a flank and of the top of a trapezoid of acceleration
_TOGETHER = 512  # moves whose intervals are made at once
ACCELERATION_TIME = "acceleration time"  # why a move takes longer: rule 2
_NOTHING_MS = 1e-9  # shorter intervals are left out


class CornerRamp(NamedTuple):
    """Where a move's straight part changes from its own speed to that of a corner, or back.

    `share` is the corner's speed as a part of the move's own.
    """

    share: float = 1.0
    ms: float = 0.0


class Timed(NamedTuple):
    """A move with the times that it gets; a stop behind it takes `stop_ta` with flanks `stop_ts`.

    `why` says what changed the programmed times, "" for nothing.
    """

    line: int
    target: tuple[float, ...]
    tm: float
    ta: float
    ts: float
    stop_ta: float
    stop_ts: float
    asked: float  # TM as programmed
    asked_ta: float  # TA as programmed
    why: str = ""
    entry: CornerRamp = CornerRamp()
    exit: CornerRamp = CornerRamp()
    clipped: bool = False  # rule 3 has shortened its blend
    segment: int = 0  # the move's


class ArrayRows:
    """A dataclass of arrays, or of such dataclasses, that have a row for each of some things."""

    def part(self, choice: slice | npt.NDArray[np.bool_ | np.intp]) -> Self:
        """Return some of the rows."""
        return type(self)(
            **{
                name: one.part(choice) if isinstance(one, ArrayRows) else one[choice]
                for name, one in vars(self).items()
            }
        )

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return parts in a row."""
        return cls(
            **{
                name: type(one).joined([getattr(part, name) for part in parts])
                if isinstance(one, ArrayRows)
                else np.concatenate([getattr(part, name) for part in parts])
                for name, one in vars(parts[0]).items()
            }
        )


@dataclass(frozen=True)
class Intervals(ArrayRows):
    """Pieces of a path over programmed time; positions are cubic in each, one column a motor."""

    du: Floats
    place: Floats
    speed: Floats
    bend: Floats  # second derivative at the beginning
    twist: Floats  # third derivative
    move: npt.NDArray[np.int64]
    rest: npt.NDArray[np.bool_]  # a dwell

    def __len__(self) -> int:
        return len(self.du)

    def divided(self, pieces: npt.NDArray[np.int64]) -> "Intervals":
        """Return each interval in a number of equal pieces."""
        index = np.repeat(np.arange(len(self)), pieces)
        number = np.arange(len(index)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        du = self.du[index] / pieces[index]
        return self.part(index).within(number * du, du)

    def within(self, begin: Floats, du: Floats) -> "Intervals":
        """Return of each interval what begins `begin` after its own beginning and is `du` long."""
        s, speed, bend, twist = begin[:, None], self.speed, self.bend, self.twist
        return replace(
            self,
            du=du,
            place=self.place + s * (speed + s * (bend / 2 + s * twist / 6)),
            speed=speed + s * (bend + s * twist / 2),
            bend=bend + s * twist,
        )

    @property
    def end_speed(self) -> Floats:
        """Derivative of the position at the end of each interval."""
        du = self.du[:, None]
        return self.speed + self.bend * du + self.twist * du**2 / 2

    @property
    def end_bend(self) -> Floats:
        """Second derivative at the end of each interval."""
        return self.bend + self.twist * self.du[:, None]

    @property
    def straight(self) -> npt.NDArray[np.bool_]:
        """Which of them have a constant speed."""
        curved: npt.NDArray[np.bool_] = np.any((self.bend != 0) | (self.twist != 0), axis=1)
        return ~curved


def nominal(events: Iterable[ProgramMove | Dwell]) -> Iterator[Timed | Dwell]:
    """Yield the moves with their times by the three rules of blending, no limit considered."""
    before: Timed | None = None
    for event in events:
        if isinstance(event, Dwell):
            before = None
            yield event
            continue
        before = _by_rules(event, before)
        yield before


def _by_rules(move: ProgramMove, before: Timed | None) -> Timed:
    """Return a move with TM >= TA, and with a blend that leaves the one before it alone."""
    tm = move.tm if move.fixed else max(move.tm, move.ta)
    why = ACCELERATION_TIME if tm > move.tm else ""
    room = 2 * (before.tm - before.ta / 2) if before else move.ta
    ta = min(move.ta, room)
    ts = min(move.ts, ta / 2)
    return Timed(
        move.line, move.target, tm, ta, ts, move.ta, move.ts, move.tm, move.ta, why,
        clipped=ta < move.ta, segment=move.segment,
    )  # fmt: skip


class NominalPath:
    """Makes intervals of moves as they come; a stop is at whole counts."""

    def __init__(self, motors: int) -> None:
        self._place = np.zeros(motors)
        self._speed = np.zeros(motors)
        self._moves: list[Timed] = []
        self._count = 0  # moves whose intervals are made

    def intervals(self, timed: Iterable[Timed | Dwell]) -> Iterator[Intervals]:
        """Yield the intervals, a number of moves at a time."""
        for item in timed:
            if isinstance(item, Dwell):
                yield from self._stop()
                if item.ms:
                    yield self._rest(item.ms)
                continue
            self._moves.append(item)
            if len(self._moves) > _TOGETHER:
                last = self._moves.pop()
                yield self._made(self._moves, last.ta, None)
                self._moves = [last]
        yield from self._stop()

    def _stop(self) -> Iterator[Intervals]:
        """Yield what is left of a section; its end is put on whole counts."""
        if not self._moves:
            return
        last = self._moves[-1]
        whole = tuple(float(round(value)) for value in last.target)
        self._moves[-1] = last._replace(target=whole)
        yield self._made(self._moves, last.stop_ta, last)
        self._moves = []

    def _rest(self, ms: float) -> Intervals:
        still = np.zeros((1, len(self._place)))
        return Intervals(
            np.array([ms]), self._place[None, :].copy(), still, still, still,
            np.array([max(self._count - 1, 0)]), np.array([True]),
        )  # fmt: skip

    def _made(self, moves: list[Timed], next_ta: float, stop: Timed | None) -> Intervals:
        """Return the intervals of moves: the blend before each, then what is straight."""
        tm, ta, ts = np.array([(move.tm, move.ta, move.ts) for move in moves]).T
        ramps = np.array([(*move.entry, *move.exit) for move in moves])
        enter, rise, leave, fall = ramps.T
        target = np.array([move.target for move in moves])
        begin = np.vstack([self._place, target[:-1]])
        speed = (target - begin) / tm[:, None]
        first, last = speed * enter[:, None], speed * leave[:, None]
        before = np.vstack([self._speed, last[:-1]])
        taken = enter * ta + leave * np.append(ta[1:], next_ta)
        taken += (1 + enter) * rise + (1 + leave) * fall
        straight = np.maximum(tm - taken / 2, 0.0)
        numbers = self._count + np.arange(len(moves))
        risen = begin + first * ta[:, None] / 2
        level = risen + (first + speed) * rise[:, None] / 2
        parts = [
            _blends(ta, ts, before, first, begin, numbers),
            _ramps(rise, ts / ta, first, speed, risen, numbers),
            Intervals(
                straight, level, speed, np.zeros_like(speed),
                np.zeros_like(speed), numbers, np.zeros(len(moves), dtype=bool),
            ),
            _ramps(fall, ts / ta, speed, last, level + speed * straight[:, None], numbers),
        ]  # fmt: skip
        joined = Intervals.joined(parts)
        found = joined.part(np.argsort(joined.move, kind="stable"))  # a move's one after the other
        self._place, self._speed = target[-1], last[-1]
        self._count += len(moves)
        if stop is not None:
            nought = np.zeros_like(self._speed)
            end = _blends(
                np.array([stop.stop_ta]), np.array([stop.stop_ts]), self._speed[None, :],
                nought[None, :], self._place[None, :], numbers[-1:],
            )  # fmt: skip
            found = Intervals.joined([found, end])
            self._speed = nought
        return found.part(found.du > _NOTHING_MS)


def _ramps(
    ms: Floats,
    flank: Floats,
    before: Floats,
    after: Floats,
    begin: Floats,
    move: npt.NDArray[np.int64],
) -> Intervals:
    """Return the intervals of changes of speed on straight parts, from where they begin on.

    `flank` is a flank's part of the time. A move that takes no time for it has none.
    """
    some = ms > _NOTHING_MS
    ms, before = ms[some], before[some]
    centre = begin[some] + before * ms[:, None] / 2
    return _blends(ms, flank[some] * ms, before, after[some], centre, move[some])


def _nodes(count: int) -> Floats:
    """Return nodes from 0 to 1, closer at both ends: there the limits change abruptly."""
    return (1 - np.cos(np.pi * np.arange(count + 1) / count)) / 2


def _blends(
    ta: Floats,
    ts: Floats,
    before: Floats,
    after: Floats,
    centre: Floats,
    move: npt.NDArray[np.int64],
) -> Intervals:
    """Return the intervals of blends from one speed to another around positions."""
    flank, top = _nodes(_FLANK), _nodes(_TOP)[1:]
    a, s = ta[:, None], ts[:, None]
    nodes = np.hstack([s * flank, s + (a - 2 * s) * top, a - s * (1 - flank[1:])])
    first = nodes[:, :-1]
    rising = np.arange(first.shape[1]) < _FLANK
    falling = np.arange(first.shape[1]) >= _FLANK + _TOP
    height, steep = 1 / (a - s), 1 / np.where(s > 0, s, 1.0)
    left = a - first
    share = np.where(rising, height * first**2 * steep / 2, height * (first - s / 2))
    share = np.where(falling, 1 - height * left**2 * steep / 2, share)
    area = np.where(
        rising, height * first**3 * steep / 6, height * (first**2 / 2 - s * first / 2 + s**2 / 6)
    )
    area = np.where(falling, a / 2 - left + height * left**3 * steep / 6, area)
    bend = np.where(rising, height * first * steep, height)
    bend = np.where(falling, height * left * steep, bend)
    twist = np.where(rising, height * steep, 0.0) - np.where(falling, height * steep, 0.0)
    change = (after - before)[:, None, :]
    start = (centre - before * a / 2)[:, None, :]
    count, motors = first.size, before.shape[1]

    def flat(values: Floats) -> Floats:
        return values.reshape(count, motors)

    return Intervals(
        np.diff(nodes, axis=1).ravel(),
        flat(start + before[:, None, :] * first[:, :, None] + change * area[:, :, None]),
        flat(before[:, None, :] + change * share[:, :, None]),
        flat(change * bend[:, :, None]),
        flat(change * twist[:, :, None]),
        np.repeat(move, first.shape[1]),
        np.zeros(count, dtype=bool),
    )
