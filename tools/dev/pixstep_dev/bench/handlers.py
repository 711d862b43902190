# SPDX-License-Identifier: MIT
"""Interrupt handlers: cycles from the flag's service to the end of RETI, response included."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep_dev.bench import sections, stretch
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_trials import lines

RATE = 30_000  # steps/s, of the step interrupt's figures
_PRINTER_HZ = Fraction(30)
_RAMP_HZ = Fraction(100)  # here the ramp's speeds are whole
_LOADED_RATE = 20_000  # steps/s of all axes together, under serial load
_SECONDS = 1.0

NAME = "handlers"


def tasks() -> list[Task]:
    """One task for each board and kind of motion."""
    return [
        Task(NAME, work, (board,))
        for board in boards.BOARD_NAMES
        for work in (step_constant, step_ramp, whole_line, others)
    ]


def step_constant(board: str) -> list[dict[str, Any]]:
    """Measure the step interrupt at a constant rate."""
    count = lines.count_at(RATE, _PRINTER_HZ)
    line = lines.constant(count, lines.pixels_in(_SECONDS, _PRINTER_HZ))
    view = stretch.moving(board, line, _PRINTER_HZ, stretch.inside(line))
    return _step_rows(view, board, f"{RATE} steps/s constant")


def step_ramp(board: str) -> list[dict[str, Any]]:
    """Measure the step interrupt in ramps from rest to RATE and back."""
    line = lines.triangles(lines.count_at(RATE, _RAMP_HZ), _RAMP_HZ, _SECONDS)
    view = stretch.moving(board, line, _RAMP_HZ, stretch.inside(line))
    return _step_rows(view, board, f"ramps 0 to {RATE} steps/s")


def whole_line(board: str) -> list[dict[str, Any]]:
    """Measure the step interrupt from boot to the end of a line, commands and idle periods too."""
    line = lines.triangles(lines.count_at(RATE, _RAMP_HZ), _RAMP_HZ, _SECONDS)
    view = stretch.whole(board, replace(line, negative=True), _RAMP_HZ)
    rows = _step_rows(view, board, "boot to the end of a line, commands included")
    return [row | {"step": False, "cycles_per_step": None} for row in rows]


def others(board: str) -> list[dict[str, Any]]:
    """Measure every handler while all axes move under a saturated serial line."""
    axes = boards.load(board).axes
    rate = _LOADED_RATE // axes
    line = lines.at_peak(lines.count_at(rate, _PRINTER_HZ), _PRINTER_HZ, _SECONDS)
    window = stretch.inside(line)
    view = stretch.moving(board, line, _PRINTER_HZ, window, axes=axes, serial_load=True)
    text = f"{axes} x {rate} steps/s, serial line saturated"
    return [_row(found, board, text) for found in view["handlers"].values()]


def _step_rows(view: dict[str, Any], board: str, text: str) -> list[dict[str, Any]]:
    """Return a row for each handler of the first axis' timer, with its cost per step."""
    rows = [_row(found, board, text) for found in sections.step_handlers(view, board)]
    for row in rows:
        row["step"] = True
        row["cycles_per_step"] = row["cycles_sum"] / view["steps"]
    return rows


def _row(found: dict[str, Any], board: str, text: str) -> dict[str, Any]:
    return {"board": board, "handler": found["name"], "while": text, "step": False} | {
        name: found[name]
        for name in (
            "count", "cycles_sum", "cycles_min", "cycles_mean", "cycles_max", "latency_max",
        )
    }  # fmt: skip


FIGURE = BenchFigure(
    NAME,
    "Interrupt handlers, cycles from the flag's service to the end of RETI",
    "With the response (4 cycles, 5 on the Mega) and the vector's jump, without nested handlers. "
    "A step: all cycles of the handler, divided by the steps that were made meanwhile. Latest "
    "start: the longest time from the flag to its service.",
    tasks,
    (
        key("board", "board", left=True),
        key("handler", "handler", left=True),
        key("while", "while", left=True),
        key("min", "cycles_min"),
        key("mean", "cycles_mean", ".1f"),
        key("max", "cycles_max"),
        key("a step", "cycles_per_step", ".1f"),
        key("latest start", "latency_max"),
    ),
)
