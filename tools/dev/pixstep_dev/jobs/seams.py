# SPDX-License-Identifier: MIT
"""Seams between the lines of a job: no gap, boards together, the load where it has to be.

Everything is measured on the pins. The last step of a pixel is on the pixel's end edge, so steps
show the grid of each board, all lines through. The clock is off by some ppm and jitters; the
oscillators of the boards differ.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from pixstep.progress import Progress, unseen
from pixstep.simulation.logs import AxisEdges, AxisPlant, read_clock_log, read_edges, read_plant
from pixstep_dev.jobs.press import PLACES, Press

PLAY = 50
_TICK_HZ = 16_000_000
_HZ = Fraction(110)  # a pixel is not a whole number of ticks: a seam could lose the rest
_APART_TICKS, _GRID_TICKS, _LOAD_STEPS = 2.0, 1.0, 1
_DRIFT_TICKS = 1.0
_LOCK = "lock"


@dataclass(frozen=True)
class SeamsPlan:
    """A job of so many lines, a clock that is off by `ppm` and jitters, an oscillator beside."""

    lines: int = 20
    ppm: float = 300.0
    jitter_us: float = 5.0
    oscillator_ppm: float = -300.0
    sync: str = _LOCK
    seed: int = 1


@dataclass
class SeamsOutcome:
    """The largest figures of all lines: gaps in pixels, times in ticks, the load in steps."""

    lines: int = 0
    chains: int = 0
    gap_px: float = 0.0
    apart_ticks: float = 0.0
    grid_ticks: float = 0.0
    drift_ticks: float = 0.0
    clock_ticks: float = 0.0
    load_steps: int = 0
    load_pixels: int = 0
    complaints: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Grid:
    """Pixel edges as an axis shows them: their numbers from line zero of the job, and cycles."""

    numbers: np.ndarray
    cycles: np.ndarray


def run(plan: SeamsPlan, show: Progress = unseen) -> SeamsOutcome:
    """Print a job and measure its seams."""
    outcome = SeamsOutcome(plan.lines)
    with tempfile.TemporaryDirectory() as folder:
        press = Press.make(Path(folder), plan.lines, sync=plan.sync, pixel_hz=_HZ)
        options: dict[str, Any] = {
            "pixel_ppm": plan.ppm, "pixel_jitter_ns": round(1000 * plan.jitter_us),
            "seed": plan.seed,
            "oscillators_ppm": {1: plan.oscillator_ppm}, "clock_log": press.folder / "clock.csv",
            "plant_log": press.folder / "plant.csv",
            "plants": {PLACES["M39"]: f"play={PLAY},taken_up=minus"},
        }  # fmt: skip
        with press.bus(**options) as link:
            done = press.run(link, press.folder / "a.pxrun")
            link.simulator.quit()
        show(0.8)
        if done["state"] != "finished":
            outcome.complaints.append(done.page())
            return outcome
        _measure(press, plan, outcome)
    show(1.0)
    return outcome


def _measure(press: Press, plan: SeamsPlan, outcome: SeamsOutcome) -> None:
    log = read_edges(press.edges)
    grids = {name: _grid(press, name, log.axis(*place)) for name, place in PLACES.items()}
    _seams(press, plan, grids["M39"], outcome)
    if plan.sync == _LOCK:
        _together(grids, outcome)
        _beside_clock(press, grids["M39"], outcome)
    _inside(press, log.axis(*PLACES["M39"]), outcome)
    plants = read_plant(press.folder / "plant.csv")
    _load(press, plants[PLACES["M39"]], grids["M39"], outcome)


def _grid(press: Press, name: str, edges: AxisEdges) -> Grid:
    """Return the pixel edges that an axis shows: where a pixel with steps ends on its edge."""
    numbers, cycles, before = [], [], 0
    rising = edges.rising
    for line in range(1, press.job.lines + 1):
        made = press.job.line(line)[name]
        places = np.abs(np.diff(press.job.expected(line, name), prepend=_start(press, line, name)))
        ends = np.cumsum(places)
        first = _aligned_from(press, name, line)
        for pixel in np.flatnonzero(places):
            if pixel >= first:
                numbers.append((line - 1) * press.job.pixels + int(pixel) + 1)
                cycles.append(rising[before + int(ends[pixel]) - 1])
        before += int(made.total_steps)
    return Grid(np.array(numbers), np.array(cycles, dtype=float))


def _aligned_from(press: Press, name: str, line: int) -> int:
    """Return the first pixel that ends on an edge: a line that takes play up comes to it later."""
    return press.job.runs_of(line)[name].image_pixel - 2 if name == "M39" else 0


def _start(press: Press, line: int, name: str) -> int:
    return press.job.runs_of(line)[name].start_steps


def _seams(press: Press, plan: SeamsPlan, grid: Grid, outcome: SeamsOutcome) -> None:
    """Measure from each line to the next, at the same pixels of both."""
    lines = (grid.numbers - 1) // press.job.pixels
    period = float(_TICK_HZ / _HZ)
    starts = [grid.cycles[lines == one] for one in range(press.job.lines)]
    steps = np.array([np.mean(after - one) for one, after in pairwise(starts)])
    if not len(steps):
        return
    whole = press.job.pixels * period / (1 + 1e-6 * plan.ppm if plan.sync == _LOCK else 1)
    outcome.gap_px = float(np.max(np.abs(np.round((steps - whole) / period))))
    outcome.drift_ticks = float(np.sum(steps - whole)) if plan.sync != _LOCK else 0.0
    if outcome.gap_px:
        outcome.complaints.append(f"a gap of {outcome.gap_px:g} px between two lines")
    if abs(outcome.drift_ticks) > _DRIFT_TICKS:
        outcome.complaints.append(f"the grid drifts by {outcome.drift_ticks:.2f} ticks")


def _together(grids: dict[str, Grid], outcome: SeamsOutcome) -> None:
    """Compare the boards' pixel edges."""
    for name, other in (("M39", "M41"), ("M40", "M41"), ("M39", "M40")):
        one, two = grids[name], grids[other]
        _, mine, its = np.intersect1d(one.numbers, two.numbers, return_indices=True)
        if len(mine):
            apart = float(np.max(np.abs(one.cycles[mine] - two.cycles[its])))
            outcome.apart_ticks = max(outcome.apart_ticks, apart)
            if apart > _APART_TICKS:
                outcome.complaints.append(f"{name} and {other}: edges {apart:.1f} ticks apart")


def _beside_clock(press: Press, grid: Grid, outcome: SeamsOutcome) -> None:
    """Compare a board's grid with the clock's true edges, and its drift over all lines."""
    true = read_clock_log(press.folder / "clock.csv").true
    first = int(np.argmin(np.abs(true - grid.cycles[0]))) - int(grid.numbers[0])
    off = grid.cycles - true[first + grid.numbers]
    outcome.clock_ticks = float(np.max(np.abs(off)))
    part = max(1, len(off) // 4)
    outcome.drift_ticks = float(np.mean(off[-part:]) - np.mean(off[:part]))
    jitter = 1e-6 * _TICK_HZ * 5
    if abs(outcome.drift_ticks) > jitter:
        outcome.complaints.append(f"the grid drifts by {outcome.drift_ticks:.2f} ticks")


def _inside(press: Press, edges: AxisEdges, outcome: SeamsOutcome) -> None:
    """Compare the steps of image pixels with the board's own grid."""
    rising, before = edges.rising.astype(float), 0
    for line in range(1, press.job.lines + 1):
        run = press.job.runs_of(line)["M39"]
        table = np.abs(np.array(press.job.expected(line, "M39")) - run.start_steps)
        for pixel in range(run.image_pixel, run.image_pixel + press.job.header.line.image_pixels):
            first, last = int(table[pixel - 2]), int(table[pixel - 1])
            made = rising[before + first - 1 : before + last]
            even = np.linspace(made[0], made[-1], len(made))
            outcome.grid_ticks = max(outcome.grid_ticks, float(np.max(np.abs(made - even))))
        before += int(press.job.line(line)["M39"].total_steps)
    if outcome.grid_ticks > _GRID_TICKS:
        outcome.complaints.append(f"a step {outcome.grid_ticks:.2f} ticks off its board's grid")


def _load(press: Press, plant: AxisPlant, grid: Grid, outcome: SeamsOutcome) -> None:
    """Compare the load at each edge of the image, forth and back, with the first line's."""
    where = dict(zip(grid.numbers.tolist(), grid.cycles.tolist(), strict=True))
    pixels = press.job.header.line.image_pixels
    wanted: np.ndarray | None = None
    for line in range(1, press.job.lines + 1):
        run = press.job.runs_of(line)["M39"]
        numbers = [
            (line - 1) * press.job.pixels + run.image_pixel - 1 + pixel
            for pixel in range(pixels + 1)
        ]
        load = plant.load_at(np.array([where[number] for number in numbers], dtype=np.int64))
        load = load[::-1] if run.negative else load
        wanted = load if wanted is None else wanted
        outcome.load_steps = max(outcome.load_steps, int(np.max(np.abs(load - wanted))))
        outcome.load_pixels += len(load)
    if outcome.load_steps > _LOAD_STEPS:
        outcome.complaints.append(f"the load is {outcome.load_steps} steps off at an image pixel")
