# SPDX-License-Identifier: MIT
"""Highest pixel clocks of pixels of few steps: one count, ramps, counts streamed by a host."""

import random
import re
import tempfile
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.simulation import judge
from pixstep.simulation.job import LineExperiment, run_job
from pixstep_dev.bench.drive import BenchDriveOutcome, BenchRun, drive
from pixstep_dev.bench.figure import BenchFigure, FigureColumn, Task, key
from pixstep_dev.bench.search import Found, Search, holes, texts, under_load
from pixstep_dev.bench.trial import CLEAN, MUTE, BenchTrial
from pixstep_dev.bench.trial import judge as judge_edges
from pixstep_trials import lines

NAME = "clocks"
STEPS = (10, 20)  # a pixel
MOTIONS = ("one count", "smooth", "ramps", "streamed", "mixed")
_UNIT_HZ, _TOP_HZ = 50, 8000
_STREAM_BAUD = 500_000
_SPREAD = 2  # steps by which streamed counts differ; mixed ones are half as many at least
_BACKLASH_STEPS = 7
# Of the clean clock, tried under serial load,
_LOADED = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.5)
_LOADED_S = 1.0  # for so long


@dataclass(frozen=True)
class ClockSearch:
    """What a search is for: pixels of at most so many steps, on so many axes at once."""

    board: str
    axes: int
    motion: str
    steps: int

    def __str__(self) -> str:
        """Return the place of a trial in a message."""
        return f"{self.board} {self.axes} {self.motion}, {self.steps} steps"

    def line(self, hz: int, seconds: float, axis: int = 0) -> Line:
        """Return the line of an axis, so long at its highest speed."""
        pixels = lines.pixels_in(seconds, Fraction(hz))
        return line_of(self.motion, self.steps, pixels, axis)


def tasks() -> list[Task]:
    """One search for each board, one axis and all of them, motion and steps a pixel."""
    return [
        Task(NAME, measure, (board, axes, motion, steps))
        for board in boards.BOARD_NAMES
        for axes in sorted({1, boards.load(board).axes})
        for motion in MOTIONS
        for steps in (STEPS[-1:] if motion == "mixed" else STEPS)
    ]


def measure(board: str, axes: int, motion: str, steps: int) -> list[dict[str, Any]]:
    """Search the highest clean pixel clock for `axes` axes at once."""
    case = ClockSearch(board, axes, motion, steps)
    tried = partial(attempt, case)
    found = Search(tried, _UNIT_HZ, _TOP_HZ).go()
    loaded = under_load(
        found.count, _LOADED, _UNIT_HZ, lambda hz: tried(hz, _LOADED_S, serial_load=True)
    )
    return [row(case, found, loaded)]


def line_of(motion: str, steps: int, pixels: int, seed: int = 0) -> Line:
    """Return a line of so many pixels of at most `steps` steps."""
    if motion == "one count":
        return lines.constant(steps, pixels)
    if motion in ("streamed", "mixed"):
        least = steps - _SPREAD if motion == "streamed" else steps // 2
        some = random.Random(seed)
        counts = tuple(some.randint(least, steps) for _ in range(pixels))
        return Line(counts, PLAIN, name="own counts")
    up = list(range(0, steps, 2)) if motion == "ramps" else [0]
    ramps = lines.smooth([*up, *[steps] * pixels, *reversed(up)])
    return Line((0, *ramps.counts), SMOOTH, backlash=_BACKLASH_STEPS, name="ramps")


def attempt(case: ClockSearch, hz: int, seconds: float, *, serial_load: bool = False) -> BenchTrial:
    """Run the case once at this clock, so long at its highest speed; say how it ended."""
    if case.motion in ("streamed", "mixed"):
        return _streamed(case, hz, seconds, serial_load)
    # Runs of equal counts: the whole line fits the board's queue.
    own = dict.fromkeys(range(case.axes), case.line(hz, seconds))
    return judge_edges(drive(BenchRun(case.board, own, Fraction(hz), serial_load=serial_load)))


def _streamed(case: ClockSearch, hz: int, seconds: float, serial_load: bool) -> BenchTrial:
    """Run a line of its own on each axis, sent meanwhile by a host that reads what is done."""
    own = {axis: case.line(hz, seconds, axis) for axis in range(case.axes)}
    job = LineExperiment(case.board, own, Fraction(hz), baud=_STREAM_BAUD, serial_load=serial_load)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        result = run_job(job, Path(folder))
    text = "; ".join(result.trouble)
    fault = re.search(r"fault (\w+)", text)
    outcome = BenchDriveOutcome(
        BenchRun(case.board, own, Fraction(hz)), result.edges, result.clock.seen
    )
    outcome.fault, outcome.trouble = (fault[1], "") if fault else ("", text)
    outcome.refused = result.refused.name if result.refused else ""
    trial = judge_edges(outcome)
    if trial.kind == CLEAN:
        summary = judge.judge(result).summary
        if summary["reasons"]:
            return BenchTrial(MUTE, summary["reasons"][0], trial.steps)
    return trial


def row(case: ClockSearch, found: Found, loaded: int) -> dict[str, Any]:
    """Return a search's result as plain data."""
    return {
        "board": case.board,
        "axes": case.axes,
        "motion": case.motion,
        "steps_per_px": case.steps,
        "pixel_hz": found.count,
        "steps_per_s": found.count * case.steps,
        "beyond": found.beyond.text if found.beyond else "not tried",
        "confirmed_hz": found.confirmed,
        "holes": texts(str(case), "Hz", found.holes),
        "serial_load_hz": loaded,
        "wrong": texts(str(case), "Hz", found.wrong),
    }


FIGURE = BenchFigure(
    NAME,
    "Highest pixel clock for pixels of few steps",
    "All axes at once, every edge exact for 2 s and no fault; searched in strides of 50 Hz. One "
    "count: plain lines with this many steps in each pixel. Smooth: smooth lines that take up "
    "backlash, reach this speed within a pixel, and come to rest within a pixel. Ramps: such lines "
    "that change their speed by 2 steps/pixel2. Streamed: each axis has counts of its own, up to 2 "
    "steps lower, which a host sends at 500,000 baud while it reads positions and thinned records. "
    "Mixed: as streamed, with counts from half as many steps up. Beyond: how the next faster clock "
    "ends. Serial load: the clock that is clean while the serial line is saturated.",
    tasks,
    (
        key("board", "board", left=True),
        key("axes", "axes"),
        key("motion", "motion", left=True),
        key("steps a pixel", "steps_per_px"),
        key("pixel clock, Hz", "pixel_hz"),
        key("steps/s", "steps_per_s"),
        key("beyond", "beyond", left=True),
        FigureColumn("holes below", holes, left=True),
        key("serial load, Hz", "serial_load_hz"),
    ),
    long=True,
)
