# SPDX-License-Identifier: MIT
"""Random sets of lines that run together, of which each has a highest speed that is guaranteed."""

import math
import random
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from pixstep.board import boards, guarantee
from pixstep.board.capability import PLAIN as PLAIN_KIND
from pixstep.board.capability import SMOOTH as SMOOTH_KIND
from pixstep.board.capability import of as capability_of
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.simulation.job import LOCK, START, LineExperiment
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep_trials import lines

_OWN = ("own counts", "wild counts", "turns", "rests", "bursts")
KINDS = ("constant", *_OWN, "smooth", "ramps", "backlash")
LEAST_HZ, MOST_HZ = 20, 5000
_SECONDS, _PIXELS = 1.2, (24, 1500)
_CURVES_PX = 18
_STREAM_S = 1.0  # of counts that a host sends while the board moves
OWN_PX = {"uno": 20, "mega": 56, "m1284": 56}  # a count of their own, so that the queue holds them
DIVIDERS = (1, 1, 1, 2, 3, 8, 30)
_JITTER = 0.005  # of an interval between edges: with more of it some edge is odd to a board
SHARE = (0.4, 1.2)  # of the limit,
BEYOND = 1 / 0.85  # which lies so far beyond what is guaranteed


@dataclass(frozen=True)
class SetShape:
    """The lines of a set but for their speed: `share` is that of each axis, of the highest."""

    kind: str
    seed: int
    shares: tuple[float, ...]
    ramp_px: int
    backlash: int
    streamed: bool = False

    def lines(self, steps: int, hz: int, board: str) -> dict[int, Line]:
        """Return a line for each axis, the fastest with so many steps a pixel."""
        return {
            axis: self._line(axis, max(2, round(share * steps)), hz, board)
            for axis, share in enumerate(self.shares)
        }

    def _line(self, axis: int, steps: int, hz: int, board: str) -> Line:
        some = random.Random(f"{self.seed} {axis}")
        held = min(_PIXELS[1], max(_PIXELS[0], round(_SECONDS * hz)))
        if self.kind == "constant":
            return Line((steps,) * held, PLAIN, name=f"constant {axis}")
        if self.kind in _OWN:
            few = round(hz * _STREAM_S) if self.streamed else OWN_PX[board]
            if self.kind == "turns":
                able = capability_of(board, Fraction(hz))
                most = min(steps, max(1, round(0.97 * able.direct_reversal_speed)))
                counts = [some.choice((-1, 1)) * some.randint(0, most) for _ in range(few)]
            elif self.kind == "bursts":
                alike = random.Random(self.seed) if self.seed % 2 else some
                pattern = _bursts(alike, steps)
                counts = pattern * max(1, few // len(pattern))
            elif self.kind == "rests":
                low = some.choice((0, 1))
                counts = [some.choice((low, some.randint(steps // 2, steps))) for _ in range(few)]
            else:
                wild = self.kind == "wild counts"
                least = steps // 2 if wild else max(0, steps - some.choice((2, steps // 10)))
                counts = [some.randint(least, steps) for _ in range(few)]
            return Line(tuple(counts), PLAIN, name=f"own {axis}")
        return self._smooth(some, axis, steps // 2 * 2, held)

    def _smooth(self, some: random.Random, axis: int, steps: int, held: int) -> Line:
        steps = max(steps, 2)
        ramp = max(1, min(self.ramp_px, steps // 2))
        up = [0, *sorted({2 * round(steps * k / ramp / 2) for k in range(1, ramp)}), steps]
        up = [v for k, v in enumerate(up) if k == 0 or v > up[k - 1]]
        peak = [steps] * held
        if self.kind == "ramps":
            low = max(0, steps - 2 * max(1, steps // 20))
            peak = [steps, *lines.wobble(low, steps, min(held, _CURVES_PX))]
        speeds = [*up, *peak, *reversed(up)]
        counts = tuple((a + b) // 2 for a, b in pairwise(speeds))
        if self.kind == "backlash" and steps > self.backlash:
            return Line((0, *counts), SMOOTH, backlash=self.backlash, name=f"backlash {axis}")
        return Line(counts, SMOOTH, name=f"{self.kind} {axis}")


def _bursts(some: random.Random, steps: int) -> list[int]:
    """Return bursts of a few pixels, between which there are rests, slow pixels or turns."""
    counts: list[int] = []
    sign = 1
    for _ in range(some.randint(1, 3)):
        counts += [sign * steps] * some.randint(1, 4)
        turns = some.random() < 0.6
        counts += some.choice(([0], [sign, -sign] if turns else [sign] * some.randint(1, 3)))
        sign = -sign if turns else sign
    return counts if sign > 0 else counts + [-count for count in counts]


@dataclass(frozen=True)
class LineSet:
    """Lines and the world they run in."""

    board: str
    kind: str
    hz: int
    sync: str
    shape: SetShape
    steps: int  # a pixel, of the fastest axis
    limit: int  # the most that is guaranteed
    ppm: float
    jitter_us: float
    loaded: bool
    baud: int
    divider: int = 1  # edges of the clock a pixel
    first: int = 0  # axis

    @property
    def lines(self) -> dict[int, Line]:
        """The lines by axis."""
        return self.shape.lines(self.steps, self.hz, self.board)

    @property
    def job(self) -> LineExperiment:
        """What is simulated."""
        return LineExperiment(
            self.board,
            {self.first + axis: line for axis, line in self.lines.items()},
            Fraction(self.hz * self.divider),
            divider=self.divider,
            sync=self.sync,
            pixel_ppm=self.ppm,
            flaws=ClockFlaws(jitter_us=self.jitter_us),
            serial_load=self.loaded,
            baud=self.baud,
        )

    @property
    def world(self) -> guarantee.LineConditions:
        """What is judged."""
        return world_of(self.board, self.hz, self.sync, self.baud, self.divider)

    def __str__(self) -> str:
        """Return it in a line."""
        return (
            f"{self.board} {len(self.shape.shares)} from {self.first} {self.kind} {self.sync} "
            f"{self.hz} Hz"
            f"{f' of {self.divider} edges' if self.divider > 1 else ''}, "
            f"{self.steps} of {self.limit} steps, {self.ppm:+.0f} ppm, {self.jitter_us:.1f} us, "
            f"{self.baud} baud{', loaded' if self.loaded else ''}"
            f"{', streamed' if self.shape.streamed else ''}, shape {self.shape.seed}"
        )


def world_of(
    board: str, hz: int, sync: str, baud: int, divider: int = 1
) -> guarantee.LineConditions:
    """Return the world of a set."""
    return guarantee.LineConditions(
        board, Fraction(hz), 2 if sync == LOCK else 1, divider, baud=baud
    )


def random_set(seed: str, board: str | None = None) -> LineSet:
    """Return the set of a seed."""
    some = random.Random(seed)
    board = board or some.choice(boards.BOARD_NAMES)
    axes = some.randint(1, boards.load(board).axes)
    kind = some.choice(KINDS)
    sync = some.choice((START, LOCK))
    hz = round(math.exp(some.uniform(math.log(LEAST_HZ), math.log(MOST_HZ))))
    baud = some.choice((115_200, 115_200, 250_000, 500_000))
    shares = tuple(1.0 if some.random() < 0.6 else some.uniform(0.3, 1) for _ in range(axes))
    shares = (1.0, *shares[1:])
    shape = SetShape(
        kind,
        some.randrange(1 << 30),
        shares,
        some.choice((1, 2, 4, 8, 16)),
        some.choice((3, 7, 20)),
        some.random() < 0.4,
    )
    divider = random.Random(f"{seed} divider").choice(DIVIDERS)
    divider = divider if hz * divider <= MOST_HZ else 1
    first = random.Random(f"{seed} first").randint(0, boards.load(board).axes - axes)
    clock = {"sync": 2 if sync == LOCK else 1, "divider": divider}
    able = capability_of(board, Fraction(hz), axes=axes, clock=clock)
    smooth = kind in ("smooth", "ramps", "backlash")
    most = able.top_speed(SMOOTH_KIND if smooth else PLAIN_KIND)
    world = world_of(board, hz, sync, baud, divider)

    def fits(steps: int) -> bool:
        return guarantee.first_late(list(shape.lines(steps, hz, board).values()), world) is None

    limit = guarantee.highest(most, fits)
    loaded = some.random() < 0.4 and not (shape.streamed and kind in _OWN)
    top = min(most, limit * BEYOND) if limit else most * 0.5
    steps = max(1, min(most, round(some.uniform(*SHARE) * top)))
    jitter_us = some.choice((0.0, 0.0, some.uniform(0, min(3, _JITTER * 1e6 / (hz * divider)))))
    return LineSet(
        board, kind, hz, sync, shape, steps, limit,
        some.uniform(-900, 900), jitter_us,
        loaded, baud, divider, first,
    )  # fmt: skip
