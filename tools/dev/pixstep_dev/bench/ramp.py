# SPDX-License-Identifier: MIT
"""The ramp from rest to 30,000 steps/s: how far its edges are from t = sqrt(2k/a).

At a pixel clock of 100 Hz the acceleration is a whole even number of steps/pixel2, so the line's
counts are the ramp itself. At the printer's 30 Hz each boundary speed is the nearest even number,
and the line's own path differs from the ramp by far more than the board's error.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.simulation.verdict import find_zero
from pixstep_dev.bench.drive import BenchRun, drive
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_dev.bench.trial import CLEAN, WRONG, judge
from pixstep_trials import lines

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

NAME = "ramp"
PEAK = 30_000  # steps/s
CLOCKS = (Fraction(100), Fraction(30))  # Hz; only the first gives the ramp itself
_HOLD_S = 0.05


def tasks() -> list[Task]:
    """One task for each board and pixel clock."""
    return [Task(NAME, measure, (board, hz)) for board in boards.BOARD_NAMES for hz in CLOCKS]


def line_of(hz: Fraction) -> Line:
    """Return the line: ramp, a short hold at the peak, ramp down."""
    return lines.at_peak(lines.count_at(PEAK, hz), hz, _HOLD_S, steady=True)


def steps_of(hz: Fraction) -> int:
    """Return the steps of the line's ramp."""
    return sum(line_of(hz).counts[: len(lines.ramp(lines.count_at(PEAK, hz), hz)) - 1])


def ideal_ticks(steps: int, tick_hz: int) -> np.ndarray:
    """Return the instants of the first steps of the ramp from rest, ticks after line zero."""
    k = np.arange(1, steps + 1, dtype=np.float64)
    return np.sqrt(2 * k / lines.RAMP_STEPS_PER_S2) * tick_hz


def errors_us(board: str, hz: Fraction) -> tuple[np.ndarray, np.ndarray]:
    """Run the line; return its ramp's edge errors, us: against the ramp, against the line itself.

    Line zero is the board's own, known from the steps that end a pixel exactly on its edge.
    Raises UserError if the run is not clean.
    """
    line, steps = line_of(hz), steps_of(hz)
    outcome = drive(BenchRun(board, {0: line}, hz))
    trial = judge(outcome)
    if trial.kind != CLEAN:
        kind = "" if trial.kind != WRONG else "; its edges are wrong"
        raise UserError(f"{board}: the ramp ends in {trial.text}{kind}")
    rising = outcome.edges.axis(0, 0).rising
    made = (rising - find_zero(line, outcome.run.period, rising))[:steps]
    own = exact.instants(line, outcome.run.period)[:steps]
    tick_us = 1e6 / outcome.run.tick_hz
    return (made - ideal_ticks(steps, outcome.run.tick_hz)) * tick_us, (made - own) * tick_us


def measure(board: str, hz: Fraction) -> list[dict[str, Any]]:
    """Measure the ramp at one pixel clock."""
    to_ramp, to_line = errors_us(board, hz)
    row = {"board": board, "hz": float(hz), "steps": len(to_ramp)}
    row |= {"pixels": len(lines.ramp(lines.count_at(PEAK, hz), hz)) - 1}
    for name, errors in (("ramp", to_ramp), ("line", to_line)):
        shifted = errors - errors.mean()
        row |= {
            f"{name}_max_us": float(np.abs(shifted).max()),
            f"{name}_rms_us": float(np.sqrt(np.mean(shifted**2))),
            f"{name}_max_from_zero_us": float(np.abs(errors).max()),
            f"{name}_rms_from_zero_us": float(np.sqrt(np.mean(errors**2))),
        }
    return [row]


FIGURE = BenchFigure(
    NAME,
    "Ramp from 0 to 30,000 steps/s at 100,000 steps/s2, edge error in us",
    "A smooth line. Ramp: every edge against sqrt(2k/a). Line: every edge against the exact "
    "instants of the line's counts, which at 100 Hz are the ramp and at 30 Hz only near it (even "
    "boundary speeds). The board rounds each edge up to a tick, so the errors from line zero on "
    "lie between 0 and one tick (0.0625 us at 16 MHz). Max and RMS: without the mean of the "
    "errors, which shifts all edges together. From zero: with their mean.",
    tasks,
    (
        key("board", "board", left=True),
        key("pixel clock, Hz", "hz", "g"),
        key("pixels", "pixels"),
        key("steps", "steps"),
        key("ramp max", "ramp_max_us", ".4f"),
        key("ramp RMS", "ramp_rms_us", ".4f"),
        key("ramp max from zero", "ramp_max_from_zero_us", ".4f"),
        key("ramp RMS from zero", "ramp_rms_from_zero_us", ".4f"),
        key("line max", "line_max_us", ".4f"),
        key("line RMS", "line_rms_us", ".4f"),
    ),
)
