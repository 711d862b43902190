# SPDX-License-Identifier: MIT
"""Highest pixel clocks of pixels of few steps: one count, ramps, counts streamed by a host."""

import random
import re
import tempfile
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from pathlib import Path

from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.simulation import judge, simrun
from pixstep_dev.bench import lines
from pixstep_dev.bench.drive import Outcome, Run
from pixstep_dev.bench.figure import Column, Figure, Task, key
from pixstep_dev.bench.search import Found, Search
from pixstep_dev.bench.trial import CLEAN, FAULT, MUTE, Trial, attempt
from pixstep_dev.bench.trial import judge as judge_edges

NAME = "clocks"
STEPS = (10, 20)  # a pixel
MOTIONS = ("one count", "ramps", "streamed")
_UNIT_HZ, _TOP_HZ = 50, 8000
_STREAM_BAUD = 500_000
_SPREAD = 2  # steps by which streamed counts differ
_BACKLASH_STEPS = 7
_LOAD_PARTS = (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)  # of the clean clock, tried under serial load


def tasks() -> list[Task]:
    """One search for each board, one axis and all of them, motion and steps a pixel."""
    return [
        Task(NAME, measure, (board, axes, motion, steps))
        for board in boards.BOARD_NAMES
        for axes in sorted({1, boards.load(board).axes})
        for motion in MOTIONS
        for steps in STEPS
    ]


def measure(board: str, axes: int, motion: str, steps: int) -> list[dict]:
    """Search the highest clean pixel clock for `axes` axes at once."""
    tried = partial(streamed if motion == "streamed" else driven, board, axes, motion, steps)
    found = Search(tried, _UNIT_HZ, _TOP_HZ).go()
    return [row(board, axes, motion, steps, found, _loaded(found.count, tried))]


def line_of(motion: str, steps: int, pixels: int, seed: int = 0) -> Line:
    """Return a line of so many pixels of at most `steps` steps."""
    if motion == "one count":
        return lines.constant(steps, pixels)
    if motion == "streamed":
        some = random.Random(seed)
        counts = tuple(some.randint(steps - _SPREAD, steps) for _ in range(pixels))
        return Line(counts, PLAIN, name="own counts")
    up = list(range(0, steps, 2))
    ramps = lines.smooth([*up, *[steps] * pixels, *reversed(up)])
    return Line((0, *ramps.counts), SMOOTH, backlash=_BACKLASH_STEPS, name="ramps")


def driven(
    board: str,
    axes: int,
    motion: str,
    steps: int,
    hz: int,
    seconds: float,
    serial_load: bool = False,
) -> Trial:
    """Run one line on all axes at once; its runs of equal counts fit the board's queue."""
    line = line_of(motion, steps, lines.pixels_in(seconds, Fraction(hz)))
    return attempt(
        Run(board, dict.fromkeys(range(axes), line), Fraction(hz), serial_load=serial_load)
    )


def streamed(
    board: str,
    axes: int,
    motion: str,
    steps: int,
    hz: int,
    seconds: float,
    serial_load: bool = False,
) -> Trial:
    """Run a line of its own on each axis, sent meanwhile by a host that reads what is done."""
    pixels = lines.pixels_in(seconds, Fraction(hz))
    own = {axis: line_of(motion, steps, pixels, axis) for axis in range(axes)}
    job = simrun.Job(board, own, Fraction(hz), baud=_STREAM_BAUD, serial_load=serial_load)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        result = simrun.run_job(job, Path(folder))
    text = "; ".join(result.trouble)
    fault = re.search(r"fault (\w+)", text)
    outcome = Outcome(Run(board, own, Fraction(hz)), result.edges, result.clock.seen)
    outcome.fault, outcome.trouble = (fault[1], "") if fault else ("", text)
    outcome.refused = result.refused.name if result.refused else ""
    trial = judge_edges(outcome)
    if trial.kind == CLEAN:
        summary = judge.judge(result).summary
        if summary["reasons"]:
            return Trial(MUTE, summary["reasons"][0], trial.steps)
    return trial


def row(board: str, axes: int, motion: str, steps: int, found: Found, loaded: int) -> dict:
    """Return a search's result as plain data."""

    def text(trials: dict[int, Trial]) -> list[str]:
        place = f"{board} {axes} {motion}, {steps} steps"
        return [f"{place}, {hz} Hz: {one.text}" for hz, one in trials.items()]

    return {
        "board": board,
        "axes": axes,
        "motion": motion,
        "steps_per_px": steps,
        "pixel_hz": found.count,
        "steps_per_s": found.count * steps,
        "beyond": found.beyond.text if found.beyond else "not tried",
        "confirmed_hz": found.confirmed,
        "holes": text(found.holes),
        "serial_load_hz": loaded,
        "wrong": text(found.wrong),
    }


def _loaded(hz: int, tried: Callable[..., Trial]) -> int:
    """Return the first part of a clean clock that is clean under a saturated serial line too."""
    for part in _LOAD_PARTS if hz else ():
        some = int(part * hz) // _UNIT_HZ * _UNIT_HZ
        if tried(some, 1.0, serial_load=True).kind == CLEAN:
            return some
    return 0


def _beyond(found: dict) -> str:
    """Return how the next faster clock ended, without what a fault's text adds."""
    return (
        found["beyond"] if found["beyond"].startswith((FAULT, "refused")) else found["beyond"][:40]
    )


FIGURE = Figure(
    NAME,
    "Highest pixel clock for pixels of few steps",
    "All axes at once, every edge exact for 2 s and no fault; searched in strides of 50 Hz. One "
    "count: plain lines of so many steps in each pixel. Ramps: smooth lines that take up backlash, "
    "speed up and slow down by 2 steps/pixel2. Streamed: each axis has counts of its own, up to 2 "
    "steps lower, which a host sends at 500,000 baud while it reads positions and records "
    "(thinned). Beyond: how the next faster clock ends. Serial load: clean at this clock while the "
    "serial line is saturated.",
    tasks,
    (
        key("board", "board", left=True),
        key("axes", "axes"),
        key("motion", "motion", left=True),
        key("steps a pixel", "steps_per_px"),
        key("pixel clock, Hz", "pixel_hz"),
        key("steps/s", "steps_per_s"),
        Column("beyond", _beyond, left=True),
        Column("holes below", lambda found: "; ".join(found["holes"]) or "none", left=True),
        key("serial load, Hz", "serial_load_hz"),
    ),
    long=True,
)
