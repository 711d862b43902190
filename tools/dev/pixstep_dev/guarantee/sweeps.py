# SPDX-License-Identifier: MIT
"""Guaranteed rates over the whole range of clocks: `pixstep-dev guarantee --sweep`.

A slower clock leaves a board more time for each pixel. Where it is promised fewer steps a pixel
than a faster one, and the faster one's line is refused there, the replay has a dip, which a
campaign does not find that asks few clocks. A clock's own line has steeper ramps, the slower the
clock: their pixels have more steps, of which each takes long to find.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby

from pixstep.board import guarantee
from pixstep.board.port import BAUD
from pixstep.progress import Progress, unseen
from pixstep_dev.guarantee import rates
from pixstep_dev.guarantee.rates import RatedLine

CLOCKS_HZ = tuple(round(20 * 1.16**k) for k in range(36))  # to 3.6 kHz
LEAST_SHARE = 0.75  # of what a faster clock is promised: what ends a bisection is chance


@dataclass(frozen=True)
class Dip:
    """A clock that is promised less than a faster one."""

    line: RatedLine
    steps: int
    faster_hz: int
    faster_steps: int

    @property
    def of_ramps(self) -> bool:
        """Whether the faster clock's line is followed here too: the ramps are at fault."""
        line = guarantee.line_at(self.line.motion, self.faster_steps, Fraction(self.faster_hz))
        return guarantee.follows([line] * self.line.axes, self.line.world)

    def __str__(self) -> str:
        return f"{self.line}: {self.steps} steps/px, but {self.faster_steps} at {self.faster_hz} Hz"


@dataclass(frozen=True)
class Sweep:
    """What is guaranteed, steps a pixel, of each line; and the dips."""

    steps: dict[RatedLine, int]
    dips: list[Dip]

    @property
    def rows(self) -> list[str]:
        """A row for each board, axes, sync and motion: what each clock is promised."""
        return [
            f"{board} {axes} {sync} {motion}: {' '.join(str(self.steps[line]) for line in lines)}"
            for (board, axes, sync, motion), lines in groupby(self.steps, _kind)
        ]


def run(
    names: Sequence[str] = (),
    clocks_hz: Sequence[int] = CLOCKS_HZ,
    processes: int = 2,
    progress: Progress = unseen,
) -> Sweep:
    """Ask what all lines of some boards, or of all, are guaranteed at each clock."""
    lines = rates.rated(names, clocks_hz, (BAUD,))
    steps = {}
    with ProcessPoolExecutor(processes) as pool:
        for line, found in zip(lines, pool.map(_steps, lines), strict=True):
            steps[line] = found
            progress(len(steps) / len(lines))
    kinds = (list(of_kind) for _, of_kind in groupby(steps, _kind))
    less = (dip for of_kind in kinds for dip in dips(of_kind, steps))
    return Sweep(steps, [dip for dip in less if not dip.of_ramps])


def dips(lines: Sequence[RatedLine], steps: dict[RatedLine, int]) -> Iterator[Dip]:
    """Yield the dips of one kind of line, whose clocks rise."""
    for place, line in enumerate(lines[:-1], 1):
        best = max(lines[place:], key=lambda faster: steps[faster])
        if steps[line] < LEAST_SHARE * steps[best]:
            yield Dip(line, steps[line], best.hz, steps[best])


def _steps(line: RatedLine) -> int:
    return line.steps


def _kind(line: RatedLine) -> tuple[str, int, str, str]:
    return line.board, line.axes, line.sync, line.motion
