# SPDX-License-Identifier: MIT
"""The simulator: seconds of a board's time for each second of this machine's CPU time."""

from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep.errors import UserError
from pixstep_dev.bench.drive import BenchRun, drive
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_dev.bench.trial import CLEAN, judge
from pixstep_trials import lines

NAME = "simulator"
RATES = (30_000, 25_000, 20_000, 15_000, 10_000, 5_000)  # steps/s: the first that all axes can do
_HZ = Fraction(30)
_SECONDS = 4.0


def tasks() -> list[Task]:
    """One task for each board, all its axes at once; nothing beside it."""
    return [Task(NAME, measure, (board,), alone=True) for board in boards.BOARD_NAMES]


def measure(board: str) -> list[dict[str, Any]]:
    """Measure with every edge logged."""
    axes = boards.load(board).axes
    for rate in RATES:
        line = lines.constant(lines.count_at(rate, _HZ), lines.pixels_in(_SECONDS, _HZ))
        outcome = drive(BenchRun(board, dict.fromkeys(range(axes), line), _HZ))
        if judge(outcome).kind == CLEAN:
            speed = outcome.stats["cycle"] / outcome.run.tick_hz / outcome.stats["cpu_s"]
            row = {"board": board, "axes": axes, "steps_per_s": rate, "edges": outcome.steps}
            return [row | {"times_real_time": round(speed, 2)}]
    raise UserError(f"{board}: no rate down to {RATES[-1]} steps/s is clean")


FIGURE = BenchFigure(
    NAME,
    "The simulator's speed, times real time (depends on the machine)",
    "Simulated seconds in a second of CPU time, on one core, with every edge logged.",
    tasks,
    (
        key("board", "board", left=True),
        key("axes", "axes"),
        key("steps/s", "steps_per_s"),
        key("steps", "edges"),
        key("times real time", "times_real_time", ".1f"),
    ),
)
