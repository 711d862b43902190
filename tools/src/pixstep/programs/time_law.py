# SPDX-License-Identifier: MIT
"""lookahead: how fast the path is run so that no motor exceeds a limit, in a moving window.

The unknown is w = (du/dt)^2 at the ends of the intervals of programmed time u. In an interval w is
linear in u, so a motor's acceleration q' w'/2 + q'' w is linear in the two unknowns x at its
beginning and y at its end:

    |a y - b x| <= A      with a = q'/2du (+ q''), b = q'/2du (- q'') at the end (the beginning)

Where q' is a parabola the acceleration is one too, and lies between its Bezier points: those at
both ends and one in between, which is linear in x and y as well.

A pass backwards finds the highest x from which every limit can be kept to the end of the window,
where the path may have to stop; a pass forwards takes the highest y that these allow. On a path
without bend that is the optimum; with bends it tends to it as the intervals shrink.
tools/native/core/law.h runs both passes.
"""

from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pixstep.lines.core import extension
from pixstep.programs.blends import ArrayRows, Floats, Intervals
from pixstep.programs.motors import PlanMotor, Setup


@dataclass
class LawBlock(ArrayRows):
    """Intervals in a row: |a y - b x| <= most in each bound, x and y at most their caps.

    `a` and `b` have a row of bounds for each interval, `most` a row of motors; `highest` is the x
    that the last pass backwards has found. A part of a block sees the same numbers as the block.
    """

    a: Floats
    b: Floats
    most: Floats
    cap: Floats
    end_cap: Floats
    rest: npt.NDArray[np.uint8]
    highest: Floats

    @classmethod
    def of(
        cls, a: Floats, b: Floats, most: Floats, cap: Floats, rest: npt.NDArray[np.bool_]
    ) -> "LawBlock":
        """Return a block whose x is capped by its bounds as well."""
        made = cls(
            np.ascontiguousarray(a), np.ascontiguousarray(b), np.ascontiguousarray(most),
            cap.copy(), cap, rest.astype(np.uint8), np.zeros(len(cap)),
        )  # fmt: skip
        extension().lib.law_caps(made._law()[0], _doubles(made.cap))
        return made

    def __len__(self) -> int:
        return len(self.cap)

    def backward(self, end: float) -> float:
        """Find the highest x of the intervals, the last y being at most `end`; return the first."""
        law, kept = self._law()
        first = extension().lib.law_backward(law, end, _doubles(self.highest))
        del kept
        return float(first)

    def forward(self, following: float, w: float, begin: Floats, end: Floats) -> float:
        """Run the intervals from w on and fill in w at both ends of each; return the last."""
        law, kept = self._law()
        last = extension().lib.law_forward(
            law, _doubles(self.highest), following, w, _doubles(begin), _doubles(end)
        )
        del kept
        return float(last)

    def _law(self) -> tuple[Any, list[Any]]:
        """Return the block as the extension takes it, and what must live as long as that."""
        ffi = extension().ffi
        numbers = [_doubles(one) for one in (self.a, self.b, self.most, self.cap, self.end_cap)]
        rest = ffi.from_buffer("uint8_t[]", self.rest)
        law = ffi.new(
            "struct law *",
            (len(self), self.a.shape[1], self.most.shape[1], *numbers, rest),
        )
        return law, [*numbers, rest]


def run_backward(blocks: list[LawBlock], end: float) -> None:
    """Run the pass backwards over blocks in a row."""
    for block in reversed(blocks):
        end = block.backward(end)


def run_forward(blocks: list[LawBlock], following: float, w: float) -> tuple[Floats, Floats, float]:
    """Run the pass forwards; `following` is the highest w behind the last block."""
    count = sum(map(len, blocks))
    begin, end = np.empty(count), np.empty(count)
    place = 0
    behind = [*(float(block.highest[0]) for block in blocks[1:]), following]
    for block, next_highest in zip(blocks, behind, strict=True):
        own = slice(place, place + len(block))
        w = block.forward(next_highest, w, begin[own], end[own])
        place += len(block)
    return begin, end, w


def _doubles(values: Floats) -> Any:
    return extension().ffi.from_buffer("double[]", values)


_TINY = 1e-12
_CANCELLED = 1e-9  # of the other coefficient: less is what rounding leaves of 0
_NOTHING = 1e-300  # instead of 0 below a fraction
_FREE = float("inf")
_FAST = 0.999  # of the highest w: no finer grid makes it faster
_MOST_PIECES = 20
_PLAIN_CUT = 0.45  # of the tolerance that a plain motor beside a smooth one may cut corners by
_CURVED_BOUND = 8.0  # a pixel of constant acceleration a bends by a/8 from its chord


@dataclass(frozen=True)
class PacedPath(ArrayRows):
    """Intervals with w at their ends; `straight` ones may be run faster in between."""

    path: Intervals
    begin: Floats
    end: Floats

    @property
    def ms(self) -> Floats:
        """How long each interval takes."""
        took: Floats = 2 * self.path.du / (np.sqrt(self.begin) + np.sqrt(self.end))
        return took


@dataclass(frozen=True)
class MotorLimits:
    """What each motor may do, in counts and ms.

    `corner` bounds q'' w alone, `reversal` the acceleration in a blend that turns the motor round.
    """

    speed: Floats
    acceleration: Floats
    corner: Floats
    reversal: Floats

    @classmethod
    def of(cls, setup: Setup) -> "MotorLimits":
        """Return the limits to plan with: whole steps add their share to them."""
        pixel, motors = setup.pixel_ms, setup.motors
        return cls(
            np.array([motor.planned_speed(pixel) for motor in motors]),
            np.array([motor.planned_acceleration(pixel) for motor in motors]),
            np.array([_corner(motor, setup) for motor in motors]),
            np.array([_reversal(motor, pixel) for motor in motors]),
        )


def _corner(motor: PlanMotor, setup: Setup) -> float:
    """Return how much a motor may accelerate by the bend of its path alone.

    In a pixel a smooth motor, and a plain one beside it, is at the mean of the places half a pixel
    before and behind an edge, which leaves a bent path by an eighth of its bend. A smooth motor's
    even steps make up for it; a plain one leaves half of the tolerance to its whole steps, and
    some to a tangent that turns in a pixel.
    """
    if not setup.smooth:
        return _FREE
    most = setup.path_tolerance * (1.0 if motor.smooth else _PLAIN_CUT)
    return _CURVED_BOUND * most / setup.pixel_ms**2


def _reversal(motor: PlanMotor, pixel_ms: float) -> float:
    """Return the acceleration with which the first pixel after a reversal is slow enough.

    A motor that turns just before the middle of a pixel still has a step in its old direction
    there. The next pixel then has as many steps as its acceleration, and one more by rounding.
    """
    if motor.reversal_steps is None:
        return _FREE
    return max(motor.reversal_steps - 1.0, 0.5) / pixel_ms**2


class TimeLaw:
    """Runs a path of any length within limits, `window` moves ahead."""

    def __init__(self, limits: MotorLimits, window: int) -> None:
        self.limits = limits
        self.window = max(1, window)
        self._stride = max(1, self.window // 8)
        self._w = _FREE  # where the forward pass stands
        self._blocks: list[LawBlock] = []  # of the intervals that the last pass has seen

    def runs(self, path: Iterable[Intervals]) -> Iterator[PacedPath]:
        """Yield the intervals of whole moves with their w, once the window has seen enough."""
        waiting: list[Intervals] = []
        known = 0  # intervals in the passes
        for part in path:
            waiting.append(part)
            first, last = int(waiting[0].move[0]), int(part.move[-1])
            if last - first < self.window + self._stride:
                continue
            joined = Intervals.joined(waiting)
            joined, known = yield from self._committed(joined, known)
            waiting = [joined]
        if waiting:
            joined = Intervals.joined(waiting)
            self._extend(joined.part(slice(known, None)))
            run_backward(self._blocks, _FREE)
            yield self._forward(joined)

    def _committed(
        self, joined: Intervals, known: int
    ) -> Generator[PacedPath, None, tuple[Intervals, int]]:
        """Yield what can be run for good; return the rest, and how much of it is known."""
        moves = joined.move
        last = int(moves[-1]) - 1  # the last move may go on in the next part
        place = 0
        while int(moves[place]) + self.window + self._stride <= last:
            first = int(moves[place])
            horizon = int(np.searchsorted(moves, first + self.window + self._stride, side="right"))
            if horizon > known:
                self._extend(joined.part(slice(known, horizon)))
                run_backward(self._blocks, 0.0)
                known = horizon
            after = int(np.searchsorted(moves, first + self._stride, side="left"))
            yield self._forward(joined.part(slice(place, after)))
            place = after
        return joined.part(slice(place, None)), known - place

    def _extend(self, part: Intervals) -> None:
        if len(part):
            self._blocks.append(block(part, self.limits))

    def _forward(self, part: Intervals) -> PacedPath:
        """Run the first intervals as fast as they may be."""
        run, left, missing = [], [], len(part)
        for block in self._blocks:
            run.append(block.part(slice(0, missing)))
            left.append(block.part(slice(missing, None)))
            missing = max(0, missing - len(block))
        self._blocks = [block for block in left if len(block)]
        following = float(self._blocks[0].highest[0]) if self._blocks else _FREE
        begin, end, self._w = run_forward([one for one in run if len(one)], following, self._w)
        return PacedPath(part, begin, end)


def refined(runs: Iterable[PacedPath], limits: MotorLimits) -> Iterator[Intervals]:
    """Yield the intervals again, finer where a first plan leaves limits unused.

    An interval has one w', so that a change from speeding up to slowing down, and an acceleration
    that varies inside, cost as much time as the interval is long.
    """
    for run in runs:
        yield run.path.divided(_pieces(run, limits))


def _pieces(run: PacedPath, limits: MotorLimits) -> npt.NDArray[np.int64]:
    """Return into how many pieces each interval is to be divided."""
    path = run.path
    gain = ((run.end - run.begin) / (2 * path.du))[:, None]
    first = np.abs(path.speed * gain + path.bend * run.begin[:, None])
    last = np.abs(path.end_speed * gain + path.end_bend * run.end[:, None])
    most = accelerations(path, limits)
    used = np.minimum(np.max(first / most, axis=1), np.max(last / most, axis=1))
    slow = np.minimum(run.begin, run.end) < highest(path, limits) * _FAST
    unused = np.where(_sharp(path), 1.0, 1 - used)
    unused = np.where(slow & ~path.straight & ~path.rest, unused, 0.0)
    padded = np.pad(unused, 1)
    nearby = np.maximum(np.maximum(padded[:-2], padded[2:]), unused)
    nearby[path.straight | path.rest] = 0.0
    pieces: Floats = np.clip(np.ceil(nearby * _MOST_PIECES), 1, _MOST_PIECES)
    return pieces.astype(np.int64)


def _sharp(path: Intervals) -> npt.NDArray[np.bool_]:
    """Return where a motor loses most of its q' in an interval, which hides that w may grow."""
    du = path.du[:, None]
    last, first = path.end_speed, path.speed
    ending = last * (last + 2 * du * path.end_bend) < 0
    begun = first * (first - 2 * du * path.bend) < 0
    sharp: npt.NDArray[np.bool_] = np.any(ending | begun, axis=1)
    return sharp


def block(part: Intervals, limits: MotorLimits) -> LawBlock:
    """Return the bounds of intervals: their accelerations are linear in w at both ends."""
    du = part.du[:, None]
    end_speed, end_bend = part.end_speed, part.end_bend
    first, last = part.speed / (2 * du), end_speed / (2 * du)
    a, b = [first, last + end_bend], [first - part.bend, last]
    if np.any(part.twist):
        middle = first + 0.75 * part.bend
        a.append(middle)
        b.append(middle - part.bend - part.twist * du / 2)
    a_all, b_all = np.hstack(a), np.hstack(b)
    flip = np.where(a_all < 0, -1.0, 1.0)
    # Coefficients that cancel are 0: a limit divided by what rounding leaves is any number.
    return LawBlock.of(
        np.where(np.abs(a_all) < _CANCELLED * np.abs(b_all), 0.0, a_all * flip),
        np.where(np.abs(b_all) < _CANCELLED * np.abs(a_all), 0.0, b_all * flip),
        accelerations(part, limits), highest(part, limits), part.rest,
    )  # fmt: skip


def accelerations(part: Intervals, limits: MotorLimits) -> Floats:
    """Return the limit of each interval and motor: lower in blends that turn a motor round."""
    first = int(part.move[0])
    group = part.move - first
    blended = ~part.straight
    low = np.zeros((int(group[-1]) + 1, part.speed.shape[1]))
    high = np.zeros_like(low)
    for speeds in (part.speed[blended], part.end_speed[blended]):
        np.minimum.at(low, group[blended], speeds)
        np.maximum.at(high, group[blended], speeds)
    turns = (low < 0) & (high > 0)
    lowered = np.minimum(limits.acceleration, limits.reversal)
    return np.where(turns[group] & blended[:, None], lowered, limits.acceleration)


def highest(part: Intervals, limits: MotorLimits) -> Floats:
    """Return the highest w by the speeds, and by what turns the path aside: q'' beside q'."""
    cap = speed_cap(part, limits)
    if not np.all(np.isinf(limits.corner)):
        aside = np.maximum(
            np.abs(_aside(part.speed, part.bend)), np.abs(_aside(part.end_speed, part.end_bend))
        )
        cap = np.minimum(cap, np.min(limits.corner / np.maximum(aside, _NOTHING), axis=1))
    return cap


def speed_cap(part: Intervals, limits: MotorLimits) -> Floats:
    """Return the highest w by the speeds, never above the programmed one."""
    fastest = np.maximum(np.abs(part.speed), np.abs(part.end_speed))
    with np.errstate(divide="ignore"):
        cap: Floats = np.minimum(1.0, np.min((limits.speed / fastest) ** 2, axis=1))
    return cap


def _aside(speed: Floats, bend: Floats) -> Floats:
    length = np.sum(speed**2, axis=1, keepdims=True)
    along = np.sum(speed * bend, axis=1, keepdims=True) / np.maximum(length, _NOTHING)
    return np.where(length > _TINY, bend - along * speed, 0.0)
