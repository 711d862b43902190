# SPDX-License-Identifier: MIT
"""Beyond the highest rate: refused by name, or a named fault after right edges only; never else."""

from fractions import Fraction
from itertools import groupby
from typing import Any

from pixstep.board import boards
from pixstep_dev.bench import rates
from pixstep_dev.bench.drive import BenchRun
from pixstep_dev.bench.figure import BenchFigure, FigureColumn, Task, key
from pixstep_dev.bench.trial import FAULT, MUTE, WRONG, attempt
from pixstep_trials import lines

NAME = "overload"
_HZ = Fraction(100)  # so that the counts of the highest rate fit a pixel
_FROM, _TO, _EACH_DECADE = 10_000, 1_000_000, 12  # steps/s
_SECONDS = 0.5
MOTIONS = ("constant", "smooth")


def rates_tried() -> list[int]:
    """Return the rates in steps/s, evenly spread on a logarithmic scale."""
    found: list[int] = []
    power = 0
    while not found or found[-1] < _TO:
        found.append(round(_FROM * 10 ** (power / _EACH_DECADE)))
        power += 1
    return found


def tasks() -> list[Task]:
    """One task for each board, motion and rate; all axes of the board at once."""
    return [
        Task(NAME, measure, (board, motion, rate))
        for board in boards.BOARD_NAMES
        for motion in MOTIONS
        for rate in rates_tried()
    ]


def measure(board: str, motion: str, rate: int) -> list[dict[str, Any]]:
    """Force a line of this rate onto the board, unchecked by the host; say how it ends."""
    axes = boards.load(board).axes
    line = rates.line_of(motion, lines.count_at(rate, _HZ), _HZ, _SECONDS)
    trial = attempt(BenchRun(board, dict.fromkeys(range(axes), line), _HZ))
    place = f"{board}, {axes} axes, {motion} at {rate} steps/s"
    return [
        {
            "board": board,
            "axes": axes,
            "motion": motion,
            "steps_per_s": rate,
            "outcome": trial.kind,
            "detail": trial.detail,
            "edges": trial.steps,
            "wrong": [f"{place}: {trial.text}"] if trial.kind in (WRONG, MUTE) else [],
        }
    ]


def spans(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return rows that ended alike at neighbouring rates as one, from the lowest to the highest."""
    merged = []
    for _, group in groupby(
        rows, key=lambda r: (r["board"], r["motion"], r["outcome"], r["detail"])
    ):
        some = list(group)
        span = {"lowest": some[0]["steps_per_s"], "highest": some[-1]["steps_per_s"]}
        edges = [row["edges"] for row in some]
        merged.append(some[0] | span | {"rates": len(some), "edges": sum(edges)})
    return merged


def _outcome(row: dict[str, Any]) -> str:
    after = ", every edge before it right" if row["outcome"] == FAULT else ""
    return f"{row['outcome']} {row['detail']}".strip() + after


FIGURE = BenchFigure(
    NAME,
    "Beyond the highest rate",
    "Lines at rates up to 1,000,000 steps/s at a pixel clock of 100 Hz, sent to the board without "
    "the host's check, all axes at once. A row: the lowest and the highest of the rates that ended "
    "in the same way.",
    tasks,
    (
        key("board", "board", left=True),
        key("axes", "axes"),
        key("motion", "motion", left=True),
        key("from steps/s", "lowest"),
        key("to steps/s", "highest"),
        key("rates", "rates"),
        FigureColumn("outcome", _outcome, left=True),
        key("edges compared", "edges"),
    ),
    long=True,
    merge=spans,
)
