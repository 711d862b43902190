# SPDX-License-Identifier: MIT
"""Moves and jogs by speeds and accelerations per second: exactly N steps, in whole steps a pixel.

The motion is a trapezoid: it begins at the base speed, accelerates, keeps its speed, and slows down
to the base speed again. Its positions at the edges of pixels are rounded to whole steps, and the
differences are the counts of a plain line. Pixels may be much shorter than the motion's changes:
the counts then change some hundred times a second at most, so that a bus can carry the line.

A constant speed of at least 100 steps/pixel is lowered to whole steps/pixel, by less than 1 %. One
of whole steps/pixel has one run in the line, however long it is. Speeds are never higher than
asked, but for the rounding of a pixel's count to the next whole step.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from pixstep.lines import runs as entries

Run = tuple[int, int]
"""Signed steps in each pixel, and for how many pixels."""

_WHOLE_STEPS_PX = 100  # from this speed on a constant speed is made whole
_STRETCHES_HZ = 100  # how often counts may change, at most
_PART = 1 / 16  # of a step: no stretch is longer, at the highest speed
_LEAST_STEPS_S = 1e-6
_MERGED = 64  # runs become one, at most: the first run of a move of days must not take long
_NEARLY = 1e-9  # of a pixel: what is left by rounding is no further pixel


@dataclass(frozen=True)
class MoveKinematics:
    """Speed and base speed in steps/s, acceleration in steps/s2; 0: at its speed at once."""

    speed_steps_s: float
    base_steps_s: float = 0.0
    acceleration_steps_s2: float = 0.0

    def within(
        self, top_steps_px: int, pixel_hz: float, acceleration_steps_s2: float | None = None
    ) -> "MoveKinematics":
        """Return what a board and its motor can do of it, the constant speed made whole."""
        speed = max(_LEAST_STEPS_S, min(self.speed_steps_s, top_steps_px * pixel_hz))
        if speed >= _WHOLE_STEPS_PX * pixel_hz:
            speed = math.floor(speed / pixel_hz + _NEARLY) * pixel_hz
        acceleration = max(0.0, self.acceleration_steps_s2)
        if acceleration_steps_s2:
            acceleration = min(acceleration or acceleration_steps_s2, acceleration_steps_s2)
        base = max(0.0, min(self.base_steps_s, speed))
        return replace(
            self, speed_steps_s=speed, base_steps_s=base, acceleration_steps_s2=acceleration
        )


class Trapezoid:
    """A move of `steps` signed steps, not 0, by kinematics that the board can keep."""

    def __init__(self, steps: int, wanted: MoveKinematics, pixel_hz: float) -> None:
        self.steps, self._hz = steps, pixel_hz
        self._distance, self._sign = abs(steps), 1 if steps > 0 else -1
        self._base, self._acceleration = wanted.base_steps_s, wanted.acceleration_steps_s2
        self._top = wanted.speed_steps_s
        self._ramp_s = self._ramp = 0.0
        if self._acceleration > 0 and self._base < self._top:
            reached = math.sqrt(self._base**2 + self._acceleration * self._distance)
            self._top = min(self._top, reached)
            self._ramp_s = (self._top - self._base) / self._acceleration
            self._ramp = (self._top + self._base) / 2 * self._ramp_s
        cruise_s = max(0.0, self._distance - 2 * self._ramp) / self._top
        self.seconds = 2 * self._ramp_s + cruise_s
        """How long it takes, before it is rounded up to whole pixels."""
        self.pixels = max(1, math.ceil(self.seconds * pixel_hz - _NEARLY))
        self._stretch_px = _stretch_px(pixel_hz, self._top)
        self._whole_px = self._whole_pixels(cruise_s)

    @property
    def lasts_s(self) -> float:
        """How long its pixels are."""
        return self.pixels / self._hz

    def runs(self) -> Iterator[Run]:
        """Return its runs, made as they are taken: a long move can begin at once."""
        return merged(self._spread())

    def _whole_pixels(self, cruise_s: float) -> range:
        """Return the pixels at a constant speed of whole steps, which are one run; maybe none."""
        if (self._top / self._hz) % 1:
            return range(0)
        first = math.ceil(self._ramp_s * self._hz)
        return range(first, math.floor((self._ramp_s + cruise_s) * self._hz))

    def _spread(self) -> Iterator[Run]:
        at = made = 0
        while at < self.pixels:
            if at in self._whole_px:
                size = self._whole_px.stop - at
                now = made + size * round(self._top / self._hz)
            else:
                size = self._size(at)
                now = max(made, self._made(at + size))
            for count, repeat in spread(now - made, size):
                yield self._sign * count, repeat
            at, made = at + size, now

    def _size(self, at: int) -> int:
        """Return how many pixels the stretch from one on has."""
        ends = [self.pixels]
        if at < self._whole_px.start < self._whole_px.stop:
            ends.append(self._whole_px.start)
        return min(self._stretch_px, *(end - at for end in ends))

    def _made(self, pixel: int) -> int:
        """Return the steps made at the end of so many pixels, rounded."""
        if pixel >= self.pixels:
            return self._distance
        return min(self._distance, math.floor(self._position(pixel / self._hz) + 0.5))

    def _position(self, at_s: float) -> float:
        left_s = self.seconds - at_s
        if at_s <= self._ramp_s:
            return (self._base + self._acceleration / 2 * at_s) * at_s
        if left_s <= self._ramp_s:
            left_s = max(0.0, left_s)
            return self._distance - (self._base + self._acceleration / 2 * left_s) * left_s
        return self._ramp + self._top * (at_s - self._ramp_s)


class JogLaw:
    """A motion without a target whose speed is changed as it goes; counts are made pixel by pixel.

    It keeps the acceleration from the base speed on, through both directions. Where the direction
    turns at a speed that the board cannot turn at, it rests for `rest_px` pixels.
    """

    def __init__(
        self, pixel_hz: float, turns_below_steps_px: int, rest_px: int, steps_s: float = 0.0
    ) -> None:
        self._hz, self._turns_below, self._rest_px = pixel_hz, turns_below_steps_px, rest_px
        self.steps_s = steps_s
        """Signed speed at the end of what was made."""
        self._position = 0.0
        self._made = self._last = 0

    def pixels(self, wanted: MoveKinematics, direction: int, count: int) -> list[Run]:
        """Return the next pixels, `count` of them and those of a turn, at a speed wanted now."""
        found: list[Run] = []
        for _ in range(count):
            before, self.steps_s = self.steps_s, self._next(wanted, direction)
            self._position += (before + self.steps_s) / 2 / self._hz
            made = math.floor(self._position + 0.5)
            now, self._made = made - self._made, made
            if now * self._last < 0 and max(abs(now), abs(self._last)) > self._turns_below:
                found.append((0, self._rest_px))
            self._last = now or self._last
            found.append((now, 1))
        return list(merged(found))

    def _next(self, wanted: MoveKinematics, direction: int) -> float:
        """Return the speed one pixel later."""
        target, base = direction * wanted.speed_steps_s, wanted.base_steps_s
        if not wanted.acceleration_steps_s2:
            return target
        change = wanted.acceleration_steps_s2 / self._hz
        speed = self.steps_s
        if abs(speed) <= base and speed * target >= 0:  # from rest, and from the base speed
            speed = math.copysign(base, target)
        if abs(target - speed) <= change:
            return target
        speed += math.copysign(change, target - speed)
        return math.copysign(base, target) if abs(speed) < base else speed


def ramp_counts(wanted: MoveKinematics, pixel_hz: float) -> list[int]:
    """Return the steps in each pixel of an acceleration to a speed: whole, 1 or more, not falling.

    It is what a seek speeds up by, and slows down by mirrored.
    """
    top = max(1, math.floor(wanted.speed_steps_s / pixel_hz + _NEARLY))
    counts: list[int] = []
    speed, change = wanted.base_steps_s / pixel_hz, wanted.acceleration_steps_s2 / pixel_hz**2
    while change > 0 and speed + change / 2 < top:
        counts.append(max(1, math.floor(speed + change / 2)))
        speed += change
    return [*counts, top]


def spread(steps: int, pixels: int) -> Iterator[Run]:
    """Return steps that are spread over pixels as evenly as their number allows."""
    low, more = divmod(steps, pixels)
    if low or not more:
        yield low, pixels - more
        if more:
            yield low + 1, more
        return
    at = 0
    for index in range(steps):  # less than one in a pixel: each for itself
        place = (2 * index + 1) * pixels // (2 * steps)
        if place > at:
            yield 0, place - at
        yield 1, 1
        at = place + 1
    if at < pixels:
        yield 0, pixels - at


def merged(runs: Iterable[Run]) -> Iterator[Run]:
    """Return runs, equal ones that follow each other as one; none is longer than an entry holds.

    Of very many equal runs the first ones are yielded before the others are taken.
    """
    count = repeat = taken = 0
    for now, more in runs:
        taken += 1
        if repeat and now == count and taken < _MERGED:
            repeat += more
        else:
            yield from _split(count, repeat)
            count, repeat, taken = now, more, 0
    yield from _split(count, repeat)


def line_entries(runs: Iterable[Run]) -> Iterator[Run]:
    """Return the queue entries of a plain line that does not wait for the pixel clock."""
    yield from entries.head_entries(entries.MARK_START, (0, 0), None)
    yield from runs
    yield entries.MARK_END, 0


def _split(count: int, repeat: int) -> Iterator[Run]:
    while repeat > 0:
        yield count, min(repeat, entries.MAX_REPEAT)
        repeat -= entries.MAX_REPEAT


def _stretch_px(pixel_hz: float, steps_s: float) -> int:
    """Return how many pixels are planned at once: of slow steps a small part of a step."""
    return max(1, round(pixel_hz / _STRETCHES_HZ), int(_PART * pixel_hz / steps_s))
