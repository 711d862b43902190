# SPDX-License-Identifier: MIT
"""From ideal counts, the load's motion, to motor counts that take up the play at each reversal.

The offset between motor and ideal is 0 in the direction in which the play is taken up at the start
and `play` steps against it in the other. It changes only inside the transition windows.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from pixstep.errors import RefusedError, UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.line_check import ERROR, Limits, check
from pixstep.reversals.play import Stroke, load_positions, strokes
from pixstep.reversals.takeup import MotionLimits, Window

FIRST = "first"
UNKNOWN = "unknown"
INITIAL_DIRECTIONS = (FIRST, "+", "-", UNKNOWN)


@dataclass(frozen=True)
class Request:
    """What to do: play in steps, pixels of each transition (None: as few as the limits allow).

    `initial_direction` says how the play is taken up before the line: in the direction of its first
    motion, in + or -, or nobody knows; then the first motion takes up all of it.
    """

    play: int
    limits: MotionLimits
    transition_px: int | None = None
    initial_direction: str = FIRST


@dataclass(frozen=True)
class Transition:
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
class Compensated:
    """The motor's counts and what to expect of them."""

    ideal: tuple[int, ...]
    counts: tuple[int, ...]
    offsets: tuple[int, ...]  # motor minus ideal position at the end of each pixel
    load_errors: tuple[int, ...]  # predicted load minus ideal at the end of each pixel
    transitions: tuple[Transition, ...]
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


def compensate(counts: Sequence[int], request: Request, name: str = "line") -> Compensated:
    """Return the motor's counts for a plain line's ideal ones.

    Raises UserError naming the pixel if the line itself breaks the limits, or if a transition does
    not fit; with a fixed length also the smallest that does.
    """
    ideal = tuple(counts)
    _refuse_bad(ideal, request.limits, name)
    try:
        return _Chain(ideal, request, name).result()
    except _DoesNotFitError as error:
        shortest = _shortest(ideal, request, name)
        raise UserError(
            f"{name}: pixel {error.pixel}: the play of {error.steps} steps does not fit a "
            f"transition of {request.transition_px} pixels within the limits: "
            f"{error.room} steps do; the smallest --transition-px for this line is {shortest}"
        ) from None


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


def _shortest(ideal: tuple[int, ...], request: Request, name: str) -> int:
    """Return the smallest fixed length that works at every reversal of a line."""
    chosen = _Chain(ideal, _with_length(request, None), name).result().transitions
    length = max(item.window_px for item in chosen)
    while True:
        try:
            _Chain(ideal, _with_length(request, length), name).result()
        except _DoesNotFitError:
            length += 1
        else:
            return length


def _with_length(request: Request, pixels: int | None) -> Request:
    return Request(request.play, request.limits, pixels, request.initial_direction)


class _Chain:
    """Goes through the strokes of a line, carrying the offset from one to the next."""

    def __init__(self, ideal: tuple[int, ...], request: Request, name: str) -> None:
        self.ideal, self.request, self.name = ideal, request, name
        self.made = list(ideal)
        self.strokes = strokes(ideal)
        first = self.strokes[0].direction if self.strokes else 1
        self.taken_up = {FIRST: first, UNKNOWN: -first, "+": 1, "-": -1}[request.initial_direction]
        self.windows: list[tuple[Stroke, int, int, int]] = []  # stroke, pixels, steps, missing

    def result(self) -> Compensated:
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
        return Compensated(
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
        if fixed is None:
            return self._fewest(stroke, wanted) if room >= wanted else longest
        if fixed < longest:
            room = self._window(stroke, fixed).room()
            if room < wanted:
                raise _DoesNotFitError(stroke.start + 1, wanted, room)
        return min(fixed, longest)

    def _fewest(self, stroke: Stroke, wanted: int) -> int:
        """Return the fewest pixels that `wanted` steps fit; a longer window has no less room."""
        low, high = 1, stroke.end - stroke.start
        while low < high:
            middle = (low + high) // 2
            if self._window(stroke, middle).room() >= wanted:
                high = middle
            else:
                low = middle + 1
        return low

    def _report(
        self, stroke: Stroke, pixels: int, steps: int, missing: int, errors: tuple[int, ...]
    ) -> Transition:
        """Describe a transition, its load errors up to the next reversal."""
        end = stroke.start + pixels
        around = [self._made(index) for index in range(stroke.start - 1, end + 1)]
        mine = [abs(error) for error in errors[stroke.start : stroke.end]]
        worst = max(mine)
        late = [index for index, error in enumerate(mine) if error]
        recovered = stroke.start + (late[-1] + 1 if late else 0) + 1
        return Transition(
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
