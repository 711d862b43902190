# SPDX-License-Identifier: MIT
"""CPU share while one axis moves at one rate: handlers, decoding, following, and the rest."""

from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep_dev.bench import sections, stretch
from pixstep_dev.bench.figure import BenchFigure, FigureColumn, Task, key
from pixstep_trials import lines

NAME = "share"
RATE = 30_000  # steps/s
_HZ = Fraction(30)
_SECONDS = 1.2  # 1 s of it in the window


def tasks() -> list[Task]:
    """One task for each board and kind of motion."""
    return [
        Task(NAME, measure, (board, motion))
        for board in boards.BOARD_NAMES
        for motion in ("constant", "smooth")
    ]


def measure(board: str, motion: str) -> list[dict[str, Any]]:
    """Measure one second at RATE."""
    count = lines.count_at(RATE, _HZ)
    lead = 0
    line = lines.constant(count, lines.pixels_in(_SECONDS, _HZ))
    if motion == "smooth":
        line, lead = lines.at_peak(count, _HZ, _SECONDS), len(lines.ramp(count, _HZ)) - 1
    view = stretch.moving(board, line, _HZ, stretch.inside(line, lead, lead))
    return [{"board": board, "motion": motion, "steps_per_s": RATE, **shares(view, board)}]


def shares(view: dict[str, Any], board: str) -> dict[str, Any]:
    """Return the shares of all cycles of a view.

    `share` is handlers, decoding and following what the handlers did. The loop looks for work
    without end, so the cycles of its other sections are mostly idleness; `upper` counts as work
    all that goes beyond the passes of a board at rest, although a busy board would make fewer.
    """
    cycles = view["cycles"]
    handlers = view["interrupt_cycles"] / cycles
    decoding = sections.decoding(view) / cycles
    following = sections.following(view) / cycles
    rest = sections.pass_cycles(stretch.at_rest(board, _HZ, 0.2))
    return {
        "handlers": handlers,
        "decoding": decoding,
        "following": following,
        "share": handlers + decoding + following,
        "upper": 1 - sections.passes(view) * rest / cycles,
        "sections": {
            name: spent / cycles
            for name, spent in zip(sections.SECTIONS, view["sections"], strict=True)
        },
    }


def _others(row: dict[str, Any]) -> str:
    parts = [
        f"{name} {share:.1%}"
        for name, share in row["sections"].items()
        if name not in (*sections.DECODING, "start", "ledger")
    ]
    return ", ".join(parts)


FIGURE = BenchFigure(
    NAME,
    "CPU share, one axis",
    "Share: what grows with the steps, that is all handlers, decoding, and following what the "
    "handlers did. In its other sections the main loop looks for work without end, so their time "
    "says nothing about load. Upper bound: counts as work also what these sections take beyond as "
    "many passes of a board at rest.",
    tasks,
    (
        key("board", "board", left=True),
        key("motion", "motion", left=True),
        key("steps/s", "steps_per_s"),
        key("handlers", "handlers", ".1%"),
        key("decoding", "decoding", ".1%"),
        key("following", "following", ".1%"),
        key("share", "share", ".1%"),
        key("upper bound", "upper", ".1%"),
        FigureColumn("the loop's other sections", _others, left=True),
    ),
)
