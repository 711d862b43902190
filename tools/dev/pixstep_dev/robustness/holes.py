# SPDX-License-Identifier: MIT
"""Rates that fail below one that passes: a sweep of pixel clocks and steps a pixel.

Every axis of a combination runs the same short line. A combination is swept over a grid:

    steps a pixel
      20  |  ok   ok   ok   REF         ok   every edge right and every step made
      14  |  ok   FAIL ok   ok          FAIL accepted, then a fault or a wrong edge
      10  |  ok   ok   ok   ok          REF  the board refuses the line: no promise, no hole
          +--------------------
            250  300  500  700  Hz

A failure is a hole where the same clock passes with more steps, or as many steps pass at a higher
clock. Its depth is how far it lies below the highest one that passes, in percent of that.
"""

import math
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.progress import Progress, unseen
from pixstep.simulation import judge
from pixstep.simulation.job import LOCK, START, LineExperiment, run_job

SYNCS = (START, LOCK)
MOTIONS = ("plain", "smooth", "backlash", "ramps")
ALLOWED_PERCENT = 5.0  # of depth
LEAST_HZ, MOST_HZ = 1, 5000
_MOST_STEPS = 30_000  # a pixel
_BACKLASH_STEPS = 7
_RAMP_PX = 8  # a ramp has so many pixels, or one for every two steps if these are fewer
_HELD_S = 0.12  # a line keeps its highest speed for so long
_HELD_PX = (6, 60)  # but for at least and at most so many pixels
_SLOW_PX = 3  # of both, where there are
_SLOW_HZ = 12  # fewer pixels in a second
QUICK_CLOCKS = (60, 300, 1200)
QUICK_COUNTS = (2, 14, 40, 200, 700)
OK, REFUSED = "", "refused"
PROCESSES = 2


@dataclass(frozen=True)
class Combination:
    """What is swept over clocks and counts."""

    board: str
    axes: int
    sync: str
    motion: str

    def __str__(self) -> str:
        """Return the combination as a table's row begins."""
        return f"{self.board} {self.axes} {self.sync} {self.motion}"


@dataclass(frozen=True)
class HolesPlan:
    """The combinations, and the grid of each."""

    combinations: tuple[Combination, ...]
    clocks: tuple[int, ...]
    counts: tuple[int, ...]
    processes: int = PROCESSES


@dataclass(frozen=True)
class Hole:
    """A failure below something that passes."""

    hz: int
    steps: int
    ended: str
    passes: str  # the highest one above it
    depth_percent: float


@dataclass
class Row:
    """What a combination's sweep has found."""

    combination: Combination
    tried: int = 0
    passed: int = 0
    refused: int = 0
    failed: int = 0
    holes: list[Hole] = field(default_factory=list)

    @property
    def deepest(self) -> Hole | None:
        """The deepest hole; None: there is none."""
        return max(self.holes, key=lambda hole: hole.depth_percent, default=None)


@dataclass
class HolesOutcome:
    """What happened. `complaints` is empty if no hole is deeper than ALLOWED_PERCENT."""

    rows: list[Row] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)


def spread(least: int, most: int, number: int) -> tuple[int, ...]:
    """Return so many whole numbers, or fewer, at equal ratios from `least` to `most`."""
    ratio = math.log(most / least) / max(1, number - 1)
    return tuple(sorted({round(least * math.exp(ratio * k)) for k in range(number)}))


def clocks(number: int) -> tuple[int, ...]:
    """Return so many pixel clocks, Hz."""
    return spread(LEAST_HZ, MOST_HZ, number)


def counts(number: int) -> tuple[int, ...]:
    """Return so many counts of steps a pixel."""
    return spread(1, _MOST_STEPS, number)


def combinations(
    names: Sequence[str], syncs: Sequence[str] = SYNCS, motions: Sequence[str] = MOTIONS
) -> tuple[Combination, ...]:
    """Return all combinations of these boards, each with one axis up to all of them."""
    return tuple(
        Combination(name, axes, sync, motion)
        for name in names
        for axes in range(1, boards.load(name).axes + 1)
        for sync in syncs
        for motion in motions
    )


def only_all_axes(chosen: Sequence[Combination]) -> tuple[Combination, ...]:
    """Return the combinations that have all axes of their board."""
    return tuple(case for case in chosen if case.axes == boards.load(case.board).axes)


def line_of(motion: str, steps: int, hz: int) -> Line:
    """Return a short line with so many steps in each pixel at its highest speed.

    Smooth lines have even ones: an odd number is made one less.
    """
    least, most = _HELD_PX
    held = _SLOW_PX if hz < _SLOW_HZ else min(most, max(least, round(hz * _HELD_S)))
    if motion == "plain":
        return Line((steps,) * held, PLAIN, name=motion)
    steps -= steps % 2
    up = [0]
    if motion == "ramps":
        stride = 2 * max(1, round(steps / (_SLOW_PX if hz < _SLOW_HZ else _RAMP_PX) / 2))
        up = list(range(0, steps, stride))
    speeds = [*up, *[steps] * held, *reversed(up)]
    ramps = tuple((a + b) // 2 for a, b in pairwise(speeds))
    if motion == "smooth":
        return Line(ramps, SMOOTH, name=motion)
    return Line((0, *ramps), SMOOTH, backlash=_BACKLASH_STEPS, name=motion)


def attempt(case: Combination, hz: int, steps: int) -> str:
    """Run one point of the grid; return how it ended: OK, REFUSED, or what went wrong."""
    lines = dict.fromkeys(range(case.axes), line_of(case.motion, steps, hz))
    job = LineExperiment(case.board, lines, Fraction(hz), sync=case.sync)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        try:
            result = run_job(job, Path(folder))
        except UserError:  # the board has no such clock
            return REFUSED
        if result.refused:
            return REFUSED
        if result.trouble:
            return result.trouble[0].split(":")[0]
        return "; ".join(judge.judge(result).summary["reasons"])


def climb(case: Combination, hz: int, counts: Sequence[int]) -> dict[int, str]:
    """Run rising counts at one clock, up to one that is too much for the board; return the ends."""
    ends: dict[int, str] = {}
    for steps in counts:
        if case.motion != "plain" and steps % 2:
            continue  # the same line as one step less
        ends[steps] = attempt(case, hz, steps)
        # A smooth line that is slower than its backlash is refused, too.
        if ends[steps] == REFUSED and steps > _BACKLASH_STEPS:
            break
    return ends


def run(plan: HolesPlan, progress: Progress = unseen) -> HolesOutcome:
    """Sweep every combination; raises UserError if the simulator cannot run."""
    outcome = HolesOutcome()
    with ProcessPoolExecutor(plan.processes) as pool:
        for number, case in enumerate(plan.combinations):
            climbs = [pool.submit(climb, case, hz, plan.counts) for hz in plan.clocks]
            found = {
                (hz, steps): end
                for hz, ends in zip(plan.clocks, climbs, strict=True)
                for steps, end in ends.result().items()
            }
            outcome.rows.append(row_of(case, found))
            outcome.complaints += _complaints(outcome.rows[-1])
            progress((number + 1) / len(plan.combinations))
    return outcome


def row_of(case: Combination, found: dict[tuple[int, int], str]) -> Row:
    """Return what a grid of ends says: {(hz, steps): end}."""
    ends = list(found.values())
    row = Row(case, len(ends), ends.count(OK), ends.count(REFUSED))
    row.failed = row.tried - row.passed - row.refused
    good = [point for point, end in found.items() if end == OK]
    for (hz, steps), end in found.items():
        if end in (OK, REFUSED):
            continue
        more = max((n for f, n in good if f == hz), default=0)
        faster = max((f for f, n in good if n == steps), default=0)
        depths = {f"{more} steps": 1 - steps / more if more else 0.0}
        depths[f"{faster} Hz"] = 1 - hz / faster if faster else 0.0
        passes, depth = max(depths.items(), key=lambda item: item[1])
        if depth > 0:
            row.holes.append(Hole(hz, steps, end, passes, round(100 * depth, 1)))
    return row


def table(outcome: HolesOutcome) -> list[str]:
    """Return a line for each combination."""
    lines = ["board axes sync motion         tried passed refused failed holes deepest"]
    for row in outcome.rows:
        deepest = row.deepest
        text = (
            f"{deepest.depth_percent:g} %: {deepest.steps} steps at {deepest.hz} Hz, "
            f"{deepest.ended}; {deepest.passes} pass"
            if deepest
            else "none"
        )
        lines.append(
            f"{row.combination!s:<29} {row.tried:6} {row.passed:6} {row.refused:7} "
            f"{row.failed:6} {len(row.holes):5} {text}"
        )
    return lines


def _complaints(row: Row) -> list[str]:
    return [
        f"{row.combination}: {hole.steps} steps at {hole.hz} Hz end in {hole.ended}, "
        f"{hole.passes} pass: {hole.depth_percent:g} %"
        for hole in row.holes
        if hole.depth_percent > ALLOWED_PERCENT
    ]
