# SPDX-License-Identifier: MIT
"""Highest clean rates: constant; smooth, every pixel at the peak accelerating; ramp and hold."""

from fractions import Fraction
from functools import partial
from typing import Any

from pixstep.board import boards
from pixstep.lines.line import Line
from pixstep.lines.units import period_ticks
from pixstep.profiles.generator import MAX_SPEED
from pixstep_dev.bench.drive import BenchRun
from pixstep_dev.bench.figure import BenchFigure, FigureColumn, Task, key
from pixstep_dev.bench.search import LONG_S, Found, Search, holes, texts, under_load
from pixstep_dev.bench.trial import BenchTrial, attempt
from pixstep_dev.guaranteed import rate
from pixstep_trials import lines

NAME = "rates"
CLOCKS_HZ = (30, 100, 200, 500, 1000, 2000)  # the first is the printer's
MOTIONS = ("constant", "smooth", "ramp and hold")
# Of the clean rate, tried under serial load.
_LOADED = (1.0, 0.98, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.6, 0.5)


def tasks() -> list[Task]:
    """One search for each board, number of axes, motion and pixel clock."""
    return [
        Task(NAME, measure, (board, axes, motion, Fraction(hz)))
        for board in boards.BOARD_NAMES
        for axes in range(1, boards.load(board).axes + 1)
        for motion in MOTIONS
        for hz in CLOCKS_HZ
    ]


def measure(board: str, axes: int, motion: str, hz: Fraction) -> list[dict[str, Any]]:
    """Search the highest clean rate of `axes` axes that run the same line at once."""
    tried = partial(_attempt, board, axes, motion, hz)
    unit = lines.grid(hz)
    found = Search(
        tried, unit, MAX_SPEED, partial(awkward, unit, period_ticks(hz, boards.load(board).tick_hz))
    ).go()
    loaded = under_load(
        found.count, _LOADED, 2, lambda count: tried(count, LONG_S, serial_load=True)
    )
    return [row(board, axes, motion, hz, found, loaded)]


def line_of(motion: str, count: int, hz: Fraction, seconds: float) -> Line:
    """Return the line whose peak is `count` steps/pixel for so long."""
    if motion == "constant":
        return lines.constant(count, lines.pixels_in(seconds, hz))
    return lines.at_peak(count, hz, seconds, steady=motion == "ramp and hold")


def awkward(unit: int, period: Fraction, count: int) -> int:
    """Return the even count within `unit` below whose interval is nearest to a half tick.

    There the whole-tick intervals change most often. The pixel period is in ticks.
    """
    choice = [n for n in range(count - unit + 2, count + 1, 2) if n > 1] or [count]
    return min(choice, key=lambda n: abs(period / n % 1 - Fraction(1, 2)))


def row(
    board: str, axes: int, motion: str, hz: Fraction, found: Found, loaded: int
) -> dict[str, Any]:
    """Return a search's result as plain data, rates in steps/s."""

    def rate(count: int) -> int:
        return round(count * hz)

    def text(trials: dict[int, BenchTrial]) -> list[str]:
        place = f"{board} {axes} {motion} {float(hz):g} Hz"
        return texts(place, "steps/s", {rate(count): one for count, one in trials.items()})

    return {
        "board": board,
        "axes": axes,
        "motion": motion,
        "hz": float(hz),
        "seconds": LONG_S,
        "steps_per_s": rate(found.count),
        "beyond": found.beyond.text if found.beyond else "not representable",
        "confirmed_steps_per_s": [rate(count) for count in found.confirmed],
        "holes": text(found.holes),
        "serial_load_steps_per_s": rate(loaded),
        "wrong": text(found.wrong),
    }


def _attempt(
    board: str,
    axes: int,
    motion: str,
    hz: Fraction,
    count: int,
    seconds: float,
    serial_load: bool = False,
) -> BenchTrial:
    line = line_of(motion, count, hz, seconds)
    return attempt(BenchRun(board, dict.fromkeys(range(axes), line), hz, serial_load=serial_load))


def guaranteed(row: dict[str, Any]) -> str:
    """Return what is guaranteed of a row's motion, steps/s on each axis."""
    return str(rate(row["board"], row["axes"], row["motion"], Fraction(row["hz"])))


FIGURE = BenchFigure(
    NAME,
    "Highest clean rate, steps/s on each of the axes at once",
    "Clean: every edge exact for 2 s, after the line's own ramp of 100,000 steps/s2 where there "
    "is one, and no fault; searched in strides of at most 500 steps/s, or of two steps a pixel "
    "where these are more. Constant: plain lines. Smooth: every pixel near the peak accelerates "
    "or brakes. Beyond: how the next higher rate ends. Holes: which of the rates at 50, 75, 90 "
    "and 95 % of the result were not clean. Serial load: the rate that is clean while the serial "
    "line is saturated. Guaranteed: what `limits` promises, whatever a host asks meanwhile and "
    "with a clock as bad as declared.",
    tasks,
    (
        key("board", "board", left=True),
        key("axes", "axes"),
        key("motion", "motion", left=True),
        key("pixel clock, Hz", "hz", "g"),
        key("steps/s", "steps_per_s"),
        FigureColumn("guaranteed", guaranteed),
        key("beyond", "beyond", left=True),
        FigureColumn("holes below", holes, left=True),
        key("serial load", "serial_load_steps_per_s"),
    ),
    long=True,
)
