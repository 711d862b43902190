# SPDX-License-Identifier: MIT
"""Lines at the guaranteed rates beside a saturated bus: `pixstep-dev guarantee --rates`.

Whether a request meets the moment at which a ring is lowest is a matter of chance: each line runs
several times, on clocks that are off by other shares; and at each baud rate at what is guaranteed
there, since each byte takes its time.
"""

import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from pathlib import Path

from pixstep.board import boards, guarantee
from pixstep.board.port import BAUD
from pixstep.progress import Progress, unseen
from pixstep.simulation.job import LOCK, START, LineExperiment, run_job
from pixstep_dev import guaranteed
from pixstep_dev.guarantee.sets import world_of

CLOCKS_HZ = (30, 100, 300, 1000, 2000)
MOST_PPM = 900
BAUDS = (115_200, 250_000, 500_000)


@dataclass(frozen=True)
class RatedLine:
    """A line for all of so many axes, and the world it runs in."""

    board: str
    axes: int
    sync: str
    motion: str
    hz: int
    baud: int = BAUD

    @cached_property
    def steps(self) -> int:
        """What is guaranteed, steps a pixel; 0: nothing."""
        clock = {"sync": 2 if self.sync == LOCK else 1, "divider": 1}
        return guaranteed.steps(
            self.board, self.axes, self.motion, Fraction(self.hz), clock, self.baud
        )

    @property
    def world(self) -> guarantee.LineConditions:
        """What it is judged by."""
        return world_of(self.board, self.hz, self.sync, self.baud)

    def run(self, phase: int, phases: int) -> str:
        """Run the line in one of so many phases; return its fault, or an empty text."""
        line = guarantee.line_at(self.motion, self.steps, Fraction(self.hz))
        job = LineExperiment(
            self.board,
            dict.fromkeys(range(self.axes), line),
            Fraction(self.hz),
            sync=self.sync,
            pixel_ppm=MOST_PPM * (1 - 2 * phase / phases),
            serial_load=True,
            baud=self.baud,
        )
        with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
            result = run_job(job, Path(folder))
        refused = [result.refused.name] if result.refused else []
        return "; ".join([*refused, *result.trouble])

    def __str__(self) -> str:
        """Return the line as a table's row begins."""
        return f"{self.board} {self.axes} {self.sync} {self.motion} {self.hz} Hz {self.baud} baud"


@dataclass
class RatesOutcome:
    """Rows of a table; `complaints` are lines that did not run to their end."""

    rows: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)


def rated(
    names: Sequence[str] = (),
    clocks_hz: Sequence[int] = CLOCKS_HZ,
    bauds: Sequence[int] = BAUDS,
) -> list[RatedLine]:
    """Return the lines of some boards, or of all, with one axis and with all axes."""
    return [
        RatedLine(board, axes, sync, motion, hz, baud)
        for board in names or boards.BOARD_NAMES
        for axes in sorted({1, boards.load(board).axes})
        for sync in (START, LOCK)
        for motion in guarantee.MOTIONS
        for baud in bauds
        for hz in clocks_hz
    ]


def _attempt(line: RatedLine, phases: int) -> tuple[int, list[str]]:
    steps = line.steps
    ends = [line.run(phase, phases) for phase in range(phases)] if steps else []
    return steps, [end for end in ends if end]


def run(
    lines: Sequence[RatedLine], phases: int, processes: int = 2, progress: Progress = unseen
) -> RatesOutcome:
    """Run each line in so many phases."""
    outcome = RatesOutcome()
    with ProcessPoolExecutor(processes) as pool:
        waiting = [pool.submit(_attempt, line, phases) for line in lines]
        for k, (line, one) in enumerate(zip(lines, waiting, strict=True)):
            steps, ends = one.result()
            outcome.rows.append(f"{line!s:<46} {steps:6} steps/px {phases:4} runs {len(ends):4}")
            outcome.complaints += [f"{line}, {steps} steps/px: {end}" for end in ends]
            progress((k + 1) / len(lines))
    return outcome
