# SPDX-License-Identifier: MIT
"""Constant rates: rate error and interval error, with and without a saturated serial line."""

from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.simulation import verdict
from pixstep_dev.bench.drive import BenchRun, drive
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_dev.bench.trial import CLEAN, WRONG, judge
from pixstep_trials import lines

NAME = "accuracy"
RATES = (10_000, 20_000, 30_000)  # steps/s
STEPS = 60_000
_HZ = Fraction(50)  # the rates are whole counts at this pixel clock


def tasks() -> list[Task]:
    """One task for each board, rate and serial traffic."""
    return [
        Task(NAME, measure, (board, rate, load))
        for board in boards.BOARD_NAMES
        for rate in RATES
        for load in (False, True)
    ]


def measure(board: str, rate: int, load: bool) -> list[dict[str, Any]]:
    """Run STEPS steps and compare the edges with the exact instants.

    Raises UserError if the board cannot do the rate: there is no error to speak of then.
    """
    count = lines.count_at(rate, _HZ)
    line = lines.constant(count, STEPS // count)
    outcome = drive(BenchRun(board, {0: line}, _HZ, serial_load=load))
    edges = outcome.edges.axis(0, 0)
    found = verdict.judge_axis(line, outcome.run.period, edges, tick_hz=outcome.run.tick_hz)
    trial = judge(outcome)
    place = f"{board} at {rate} steps/s"
    if trial.kind not in (CLEAN, WRONG):
        raise UserError(f"{place}: {trial.text}")
    return [
        {
            "board": board,
            "steps_per_s": rate,
            "serial_load": load,
            "steps": found.steps,
            "outcome": trial.text,
            "rate_error_ppm": round(found.rate_error_ppm, 3) + 0.0,
            "interval_error_ticks": round(found.max_interval_error_ticks, 6),
            "edge_error_ticks": round(found.max_edge_error_ticks, 6),
            "wrong": [f"{place}: {trial.text}"] if trial.kind == WRONG else [],
        }
    ]


FIGURE = BenchFigure(
    NAME,
    "Constant rates: rate and interval error over 60,000 steps",
    "Rate error: the slope of the edges over the exact instants. Interval error: the largest "
    "difference between an interval and the exact interval, in ticks of the board's clock.",
    tasks,
    (
        key("board", "board", left=True),
        key("steps/s", "steps_per_s"),
        key("serial line saturated", "serial_load", left=True),
        key("steps", "steps"),
        key("rate error, ppm", "rate_error_ppm", ".3f"),
        key("interval error, ticks", "interval_error_ticks", ".3f"),
        key("edge error, ticks", "edge_error_ticks", ".3f"),
        key("outcome", "outcome", left=True),
    ),
)
