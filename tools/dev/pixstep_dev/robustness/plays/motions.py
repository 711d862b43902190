# SPDX-License-Identifier: MIT
"""Random motions of an axis with play, and where its load must be during each of them."""

import random
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate
from math import sqrt

from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import Seek, queue_entries, seek_entries

MOST_PLAY = 400
_MOST_SPEED = 500  # steps/px
_CYCLES = 8  # from an edge of the clock to the STEP edge that lies on it, at most


@dataclass(frozen=True)
class PlayMotion:
    """What an axis is given at once: lines without a pause between them, or a seek."""

    lines: tuple[Line, ...] = ()
    seek: Seek | None = None

    @property
    def entries(self) -> list[list[tuple[int, int]]]:
        """The entries of its queue, line by line."""
        if self.seek:
            return [seek_entries(self.seek)]
        return [queue_entries(line) for line in self.lines]

    @property
    def pixels(self) -> int:
        """Pixels of all of it."""
        return self.seek.pixels if self.seek else sum(line.pixels for line in self.lines)

    @property
    def judged(self) -> bool:
        """True if the load must be where the lines say."""
        return any(line.backlash for line in self.lines)


def smooth(rng: random.Random, play: int, *, clocked: bool = True) -> Line:
    """Return a smooth line up to a speed and down again, with a zero pixel at both ends.

    Without play it begins at once.
    """
    least = max(8, play)
    speed = min(_MOST_SPEED, round(least * (_MOST_SPEED / least) ** rng.random()) // 4 * 4 + 4)
    ramp = (speed // 4, speed * 3 // 4)
    counts = (*ramp, *(speed,) * rng.randint(1, 4), *ramp[::-1])
    if play:
        counts = (0, *counts, 0)
    return Line(counts, SMOOTH, play, negative=rng.random() < 0.5, clocked=clocked)


def plain(rng: random.Random, play: int) -> Line:
    """Return a plain line of one direction, mostly shorter than the play."""
    steps = rng.randint(1, max(2, play * 3 // 2))
    pixels = rng.randint(1, 3)
    count = rng.choice((-1, 1)) * max(1, steps // pixels)
    return Line((count,) * pixels, PLAIN)


def wiggle(rng: random.Random, play: int) -> Line:
    """Return a plain line that turns round several times."""
    counts: list[int] = []
    for _ in range(rng.randint(2, 5)):
        counts += [rng.choice((-1, 1)) * rng.randint(1, max(1, play)), 0]
    return Line(tuple(counts), PLAIN)


def seek(rng: random.Random) -> Seek:
    """Return a search for the home switch."""
    sign = rng.choice((-1, 1))
    return Seek(tuple(sign * count for count in (4, 12, 20)), 12, smooth=rng.random() < 0.5)


def motion(rng: random.Random, play: int, *, chains: bool) -> PlayMotion:
    """Return a random motion; `chains`: it may be two lines with backlash without a pause."""
    kind = rng.random()
    if kind < 0.5:
        return PlayMotion((smooth(rng, play),))
    if chains and kind < 0.6:
        return PlayMotion((smooth(rng, play), smooth(rng, play, clocked=False)))
    if kind < 0.8:
        return PlayMotion((plain(rng, play),))
    return PlayMotion((wiggle(rng, play) if kind < 0.92 else smooth(rng, 0),))


@dataclass(frozen=True)
class ClockEdges:
    """The pixel clock's edges: cycle of the first, and cycles from one to the next."""

    first: int
    pixel: int


def edges(
    given: PlayMotion, first_cycle: int, lacking: int, clock: ClockEdges
) -> Iterator[tuple[int, int]]:
    """Yield cycle and the load's way at each pixel edge away from take-ups.

    Which edge of the clock is line zero the first STEP edge tells: the first line takes up what was
    lacking when it began.
    """
    head = given.lines[0]
    first = next(count for count in head.counts if count)
    begun = Fraction(head.counts.index(first)) - Fraction(lacking, head.line_speed)
    pixels = (first_cycle - clock.first) / clock.pixel - float(begun) - 1 / sqrt(first)
    zero = clock.first + round(pixels) * clock.pixel
    way = 0
    for line in given.lines:
        ways = list(accumulate((line.direction * n for n in line.counts), initial=way))
        for pixel in range(line.shifted_pixels, line.pixels + 1):
            yield zero + pixel * clock.pixel + _CYCLES, ways[pixel]
        zero += line.pixels * clock.pixel
        way = ways[-1]
