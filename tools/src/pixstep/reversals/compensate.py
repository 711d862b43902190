# SPDX-License-Identifier: MIT
"""From ideal counts, the load's motion, to motor counts that take up the play at each reversal.

The offset between motor and ideal is 0 in the direction in which the play is taken up at the start
and `play` steps against it in the other. It changes only inside the transition windows: there extra
steps are laid over the counts, within the motor's limits.

Which count may follow which is a constraint on neighbours only, and closed under minimum and
maximum: if two sequences keep it, so do the lower and the higher of the two at every pixel. Hence
under any caps there is one highest sequence (two passes find it), and between two sequences, one
above the other, there is always a pixel that may give up one step.
"""

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.line_check import ERROR, MAX_COUNT, Limits, check


@dataclass(frozen=True)
class Stroke:
    """Pixels that move in one direction, the zero pixels before the motion included."""

    start: int  # 0-based
    end: int  # behind the last
    direction: int


def directions(counts: Sequence[int]) -> list[int]:
    """Return each pixel's direction: the sign of the next count that is not zero.

    So zero pixels between two motions belong to the one that follows: the play is taken up while
    the load rests. The zero pixels at the end keep the last direction; 0 if nothing moves.
    """
    last = next((count for count in reversed(counts) if count), 0)
    sign = (last > 0) - (last < 0)
    found = []
    for count in reversed(counts):
        sign = sign if count == 0 else (count > 0) - (count < 0)
        found.append(sign)
    return found[::-1]


def strokes(counts: Sequence[int]) -> list[Stroke]:
    """Return the strokes of a line; none if nothing moves."""
    signs = directions(counts)
    if not any(signs):
        return []
    starts = [0, *(i for i, (a, b) in enumerate(pairwise(signs), 1) if a != b)]
    return [Stroke(start, end, signs[start]) for start, end in pairwise([*starts, len(counts)])]


def load_positions(motor: Iterable[int], play: int, taken_up: int) -> list[int]:
    """Return the load's position at each of the motor's, both in steps from 0 at the start.

    `taken_up` is the direction (+1 or -1) in which the play is taken up at the start. The motor
    must not turn back between two of its positions (a plain pixel has one direction), so that
    looking at the pixel edges alone loses nothing.
    """
    low = 0 if taken_up > 0 else -play  # of load - motor; the play is above it
    load = 0
    positions = []
    for position in motor:
        load = min(max(load, position + low), position + low + play)
        positions.append(load)
    return positions


@dataclass(frozen=True)
class MotionLimits:
    """What the motor can do from pixel to pixel: speeds in steps/pixel, steps/pixel2.

    Counts up to `start_stop` may follow each other freely, whatever their directions; beyond it a
    count changes by at most `max_acceleration` (at least 1) and never turns to the other direction.
    """

    max_acceleration: int
    start_stop: int
    max_speed: int = MAX_COUNT

    def highest_beside(self, count: int) -> int:
        """Return the highest count >= 0 that may stand next to `count`, before or after it."""
        if count < 0:
            free = self.start_stop if -count <= self.start_stop else 0
        elif count <= self.start_stop:
            free = max(count + self.max_acceleration, self.start_stop)
        else:
            free = count + self.max_acceleration
        return min(free, self.max_speed)


@dataclass(frozen=True)
class Window:
    """The ideal counts of a window's pixels and the counts made just before and behind it."""

    ideal: tuple[int, ...]
    before: int
    behind: int
    limits: MotionLimits

    def highest(self, level: int) -> list[int]:
        """Return the highest counts within the limits, at most `level` above the ideal ones."""
        counts = []
        last = self.before
        for count in self.ideal:
            last = min(count + level, self.limits.highest_beside(last))
            counts.append(last)
        last = self.behind
        for index in reversed(range(len(counts))):
            last = counts[index] = min(counts[index], self.limits.highest_beside(last))
        return counts

    def room(self, level: int | None = None) -> int:
        """Return the extra steps that fit, at most `level` a pixel (None: any number)."""
        level = self.limits.max_speed if level is None else level
        return sum(self.highest(level)) - sum(self.ideal)

    def take_up(self, steps: int) -> list[int] | None:
        """Return counts with exactly `steps` extra, no pixel taking more than it must.

        None if they do not fit. What the lowest sufficient level gives too much is given up at the
        last pixels that may, so that the play is taken up as early as that level allows.
        """
        if self.room() < steps:
            return None
        counts = self.highest(
            bisect_left(range(self.limits.max_speed), steps, key=self.room)  # the lowest level
        )
        start = len(counts) - 1
        for _ in range(sum(counts) - sum(self.ideal) - steps):
            index = self._last_spare(counts, start)
            counts[index] -= 1
            start = min(index + 1, len(counts) - 1)  # only its neighbours can have become spare
        return counts

    def _last_spare(self, counts: list[int], start: int) -> int:
        """Return the last pixel up to `start` that can do with one step less.

        Only the pixel before can forbid it: the one behind is at its ideal, or was passed over
        because this one is too high for it.
        """
        for index in range(start, -1, -1):
            best = self.limits.highest_beside(counts[index] - 1)
            before = counts[index - 1] if index else self.before
            if counts[index] > self.ideal[index] and before <= best:
                return index
        raise AssertionError("two sequences within the limits and no step between them")


FIRST = "first"
UNKNOWN = "unknown"
INITIAL_DIRECTIONS = (FIRST, "+", "-", UNKNOWN)


@dataclass(frozen=True)
class TakeUpRequest:
    """What to do: play in steps, pixels of each transition (None: as few as the limits allow).

    `initial_direction` says how the play is taken up before the line: in the direction of its first
    motion, in + or -, or nobody knows; then the first motion takes up all of it.
    """

    play: int
    limits: MotionLimits
    transition_px: int | None = None
    initial_direction: str = FIRST


@dataclass(frozen=True)
class LineTransition:
    """What happens at one reversal; pixels are 1-based, errors are load minus ideal in steps."""

    pixel: int  # first of the window
    direction: int
    window_px: int
    steps: int  # taken up
    missing: int  # of the play, because the next reversal came first
    peak_extra: int  # steps/pixel above the ideal speed
    peak_speed: int  # steps/pixel
    peak_acceleration: int  # steps/pixel2, from the pixel before the window to the one behind it
    worst_error: int
    worst_pixel: int | None  # at the end of which that is; None if the load never lags
    recovered_pixel: int | None  # from its end on the load is where it should be; None: not before
    #                              the next reversal

    @property
    def last_pixel(self) -> int:
        """Last pixel of the window."""
        return self.pixel + self.window_px - 1


@dataclass(frozen=True)
class MotorCounts:
    """The motor's counts and what to expect of them."""

    ideal: tuple[int, ...]
    counts: tuple[int, ...]
    offsets: tuple[int, ...]  # motor minus ideal position at the end of each pixel
    load_errors: tuple[int, ...]  # predicted load minus ideal at the end of each pixel
    transitions: tuple[LineTransition, ...]
    taken_up: int  # direction in which the play is, or is held to be, taken up before the line

    @property
    def worst_outside(self) -> int:
        """Largest predicted load error, steps, at a pixel edge outside the transitions."""
        inside = {k for item in self.transitions for k in range(item.pixel, item.last_pixel + 1)}
        return max(
            (abs(error) for k, error in enumerate(self.load_errors, 1) if k not in inside),
            default=0,
        )

    @property
    def complete(self) -> bool:
        """True if every transition takes up all of the play."""
        return all(item.missing == 0 for item in self.transitions)


def compensate(counts: Sequence[int], request: TakeUpRequest, name: str = "line") -> MotorCounts:
    """Return the motor's counts for a plain line's ideal ones.

    Raises UserError naming the pixel if the line itself breaks the limits, or if a transition does
    not fit; with a fixed length also the smallest that does.
    """
    ideal = tuple(counts)
    _refuse_bad(ideal, request.limits, name)
    try:
        return _StrokeChain(ideal, request, name).result()
    except _DoesNotFitError as error:
        shortest = _shortest(ideal, request, name)
        raise UserError(AskedText(
            f"{{name}}: pixel {error.pixel}: the play of {error.steps} steps does not fit a "
            f"transition of {request.transition_px} pixels within the limits: {error.room} steps "
            f"do; the smallest {{transition_px}} for this line is {shortest}",
            name=name,
        )) from None  # fmt: skip


class _DoesNotFitError(Exception):
    """A fixed transition is too short though longer ones are possible."""

    def __init__(self, pixel: int, steps: int, room: int) -> None:
        super().__init__(pixel)
        self.pixel, self.steps, self.room = pixel, steps, room


def _refuse_bad(ideal: tuple[int, ...], limits: MotionLimits, name: str) -> None:
    """Raise for a line that breaks the limits before anything is added to it."""
    bounds = Limits(limits.max_speed, limits.max_acceleration, limits.start_stop)
    for item in check(Line(ideal, PLAIN), bounds):
        if item.severity == ERROR:
            raise RefusedError(
                f"{name}: pixel {item.pixel}: {item.name} before any compensation: {item.message}"
            )


def _shortest(ideal: tuple[int, ...], request: TakeUpRequest, name: str) -> int:
    """Return the smallest fixed length that works at every reversal of a line."""
    chosen = _StrokeChain(ideal, replace(request, transition_px=None), name).result().transitions
    length = max(item.window_px for item in chosen)
    while True:
        try:
            _StrokeChain(ideal, replace(request, transition_px=length), name).result()
        except _DoesNotFitError:
            length += 1
        else:
            return length


class _StrokeChain:
    """Goes through the strokes of a line, carrying the offset from one to the next."""

    def __init__(self, ideal: tuple[int, ...], request: TakeUpRequest, name: str) -> None:
        self.ideal, self.request, self.name = ideal, request, name
        self.made = list(ideal)
        self.strokes = strokes(ideal)
        first = self.strokes[0].direction if self.strokes else 1
        self.taken_up = {FIRST: first, UNKNOWN: -first, "+": 1, "-": -1}[request.initial_direction]
        self.windows: list[tuple[Stroke, int, int, int]] = []  # stroke, pixels, steps, missing

    def result(self) -> MotorCounts:
        """Return the whole line; raises UserError or _DoesNotFitError."""
        offset = 0
        before = self.taken_up
        for stroke in self.strokes:
            if stroke.direction != before:
                side = 0 if stroke.direction == self.taken_up else self.request.play
                wanted = abs(stroke.direction * side - offset)
                offset += stroke.direction * self._transition(stroke, wanted)
            before = stroke.direction
        motor, load = tuple(accumulate(self.made)), tuple(accumulate(self.ideal))
        moved = load_positions(motor, self.request.play, self.taken_up)
        errors = tuple(a - b for a, b in zip(moved, load, strict=True))
        return MotorCounts(
            self.ideal,
            tuple(self.made),
            tuple(a - b for a, b in zip(motor, load, strict=True)),
            errors,
            tuple(self._report(*window, errors) for window in self.windows),
            self.taken_up,
        )

    def _window(self, stroke: Stroke, pixels: int) -> Window:
        """Return the window of so many pixels at the beginning of a stroke."""
        end = stroke.start + pixels
        return Window(
            tuple(stroke.direction * count for count in self.ideal[stroke.start : end]),
            stroke.direction * self._made(stroke.start - 1),
            stroke.direction * self._made(end),
            self.request.limits,
        )

    def _made(self, index: int) -> int:
        """Return the count made in a pixel so far; outside the line the motor rests."""
        return self.made[index] if 0 <= index < len(self.made) else 0

    def _transition(self, stroke: Stroke, wanted: int) -> int:
        """Lay a transition over the beginning of a stroke; return the steps it takes up."""
        pixels = self._length(stroke, wanted)
        window = self._window(stroke, pixels)
        steps = min(wanted, window.room())
        counts = window.take_up(steps)
        assert counts is not None  # there is room for so many
        self.made[stroke.start : stroke.start + pixels] = [stroke.direction * n for n in counts]
        self.windows.append((stroke, pixels, steps, wanted - steps))
        return steps

    def _length(self, stroke: Stroke, wanted: int) -> int:
        """Return the pixels of a stroke's transition; all of the stroke if it is broken off."""
        longest = stroke.end - stroke.start
        room = self._window(stroke, longest).room()
        if stroke.end == len(self.ideal) and room < wanted:
            raise UserError(
                f"{self.name}: pixel {stroke.start + 1}: the play of {wanted} steps does not fit "
                f"the {longest} pixels up to the end of the line, {room} steps do: "
                "put zero pixels at the end"
            )
        fixed = self.request.transition_px
        if fixed is None:  # the fewest pixels that do; a longer window has no less room
            return 1 + bisect_left(
                range(1, longest), wanted, key=lambda pixels: self._window(stroke, pixels).room()
            )
        if fixed < longest:
            room = self._window(stroke, fixed).room()
            if room < wanted:
                raise _DoesNotFitError(stroke.start + 1, wanted, room)
        return min(fixed, longest)

    def _report(
        self, stroke: Stroke, pixels: int, steps: int, missing: int, errors: tuple[int, ...]
    ) -> LineTransition:
        """Describe a transition, its load errors up to the next reversal."""
        end = stroke.start + pixels
        around = [self._made(index) for index in range(stroke.start - 1, end + 1)]
        mine = [abs(error) for error in errors[stroke.start : stroke.end]]
        worst = max(mine)
        late = [index for index, error in enumerate(mine) if error]
        recovered = stroke.start + (late[-1] + 1 if late else 0) + 1
        return LineTransition(
            pixel=stroke.start + 1,
            direction=stroke.direction,
            window_px=pixels,
            steps=steps,
            missing=missing,
            peak_extra=max(
                abs(a - b)
                for a, b in zip(around[1:-1], self.ideal[stroke.start : end], strict=True)
            ),
            peak_speed=max(map(abs, around[1:-1])),
            peak_acceleration=max(abs(b - a) for a, b in pairwise(around)),
            worst_error=errors[stroke.start + mine.index(worst)],
            worst_pixel=stroke.start + mine.index(worst) + 1 if worst else None,
            recovered_pixel=recovered if recovered <= stroke.end else None,
        )
