# SPDX-License-Identifier: MIT
"""Decoding: cycles of the main loop for each step, by kind of pixel, one run for each kind."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep.lines.line import Line
from pixstep_dev.bench import sections, stretch
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_trials import lines

NAME = "decode"


@dataclass(frozen=True)
class PixelKind:
    """Pixels of one kind: their boundary speeds go from low to high and back, in steps/pixel."""

    name: str
    hz: Fraction
    low: int
    high: int
    pixels: int
    plain: bool = False

    def line(self) -> tuple[Line, int]:
        """Return a line of such pixels and how many at either end lead up to them."""
        if self.plain:
            return lines.constant(self.high, self.pixels), 0
        up = lines.ramp(self.low, self.hz)
        turns = [self.low] * self.pixels
        if self.high > self.low:
            turns = [*lines.wobble(self.low, self.high, self.pixels)[1:], self.low]
        return lines.smooth([*up, *turns, *reversed(up[:-1])]), len(up) - 1


KINDS = (
    PixelKind("plain, constant", Fraction(30), 1000, 1000, 40, plain=True),
    PixelKind("smooth, constant", Fraction(30), 1000, 1000, 40),
    PixelKind("smooth, flat (below a tick from step to step)", Fraction(30), 860, 900, 40),
    PixelKind("smooth, steep", Fraction(30), 200, 600, 40),
    PixelKind("smooth, slow", Fraction(30), 40, 60, 60),
    PixelKind("smooth, 40-bit (long pixels)", Fraction(10), 960, 1000, 16),
)


def tasks() -> list[Task]:
    """One task for each board and kind."""
    return [Task(NAME, measure, (board, kind)) for board in boards.BOARD_NAMES for kind in KINDS]


def measure(board: str, kind: PixelKind) -> list[dict[str, Any]]:
    """Measure decoding of one kind of pixel on one axis."""
    line, lead = kind.line()
    view = stretch.moving(board, line, kind.hz, stretch.inside(line, lead, lead))
    steps = view["steps"]
    return [
        {
            "board": board,
            "pixels": kind.name,
            "hz": float(kind.hz),
            "steps_per_s": round(steps / view["cycles"] * boards.load(board).tick_hz),
            "steps": steps,
            "decode_cycles_per_step": sections.decoding(view) / steps,
            "handler_cycles_per_step": sections.step_cycles(view, board),
        }
    ]


FIGURE = BenchFigure(
    NAME,
    "Decoding, cycles a step in the main loop",
    "One axis, lines of one kind of pixel. Decoding: the main loop, interrupts not counted.",
    tasks,
    (
        key("board", "board", left=True),
        key("pixels", "pixels", left=True),
        key("pixel clock, Hz", "hz", "g"),
        key("steps/s", "steps_per_s"),
        key("decoding", "decode_cycles_per_step", ".1f"),
        key("step interrupt", "handler_cycles_per_step", ".1f"),
    ),
)
