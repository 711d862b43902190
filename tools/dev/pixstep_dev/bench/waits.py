# SPDX-License-Identifier: MIT
"""The longest stretch with interrupts off, and the longest wait of the step interrupt."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line
from pixstep_dev.bench import sections, stretch
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_trials import lines

NAME = "waits"
_HZ = Fraction(30)
_RATE = 20_000  # steps/s of all axes together
_SECONDS = 1.0


@dataclass(frozen=True)
class Scene:
    """What goes on: motion or rest, and the serial traffic meanwhile."""

    name: str
    moving: bool = True
    serial_load: bool = False
    streamed: bool = False  # every pixel a queue entry of its own, records read as they come


SCENES = (
    Scene("at rest", moving=False),
    Scene("at rest, serial line saturated", moving=False, serial_load=True),
    Scene("moving"),
    Scene("moving, serial line saturated", serial_load=True),
    Scene("moving, line uploaded and records read meanwhile", streamed=True),
)


def tasks() -> list[Task]:
    """One task for each board and scene."""
    return [Task(NAME, measure, (board, scene)) for board in boards.BOARD_NAMES for scene in SCENES]


def measure(board: str, scene: Scene) -> list[dict[str, Any]]:
    """Measure one scene with all axes."""
    axes = boards.load(board).axes
    if scene.moving:
        line, window = _line(board, streamed=scene.streamed)
        view = stretch.moving(
            board, line, _HZ, window, axes=axes,
            serial_load=scene.serial_load, records=scene.streamed,
        )  # fmt: skip
    else:
        view = stretch.at_rest(board, _HZ, _SECONDS, serial_load=scene.serial_load)
    return [
        {
            "board": board,
            "axes": axes,
            "scene": scene.name,
            "steps_per_s": _RATE // axes if scene.moving else 0,
            "interrupts_off_cycles": view["interrupts_off_cycles"],
            "interrupts_off_main_cycles": view["interrupts_off_main_cycles"],
            "step_wait_cycles": sections.latest_start(view, board, axes),
        }
    ]


def _line(board: str, *, streamed: bool) -> tuple[Any, ...]:
    """Return the line of a board's moving scenes and the window on it."""
    count = lines.count_at(_RATE // boards.load(board).axes, _HZ)
    pixels = lines.pixels_in(_SECONDS, _HZ)
    if streamed:
        queue_twice = 300
        line = Line(tuple(count - k % 2 for k in range(queue_twice)), PLAIN, name="streamed")
        return line, stretch.inside(line)
    line = lines.at_peak(count, _HZ, float(pixels / _HZ))
    return line, stretch.inside(line)


FIGURE = BenchFigure(
    NAME,
    "Interrupts off, and the step interrupt's longest wait, cycles",
    "Off: the longest stretch with the I bit clear, handlers included. Off in the main loop: "
    "without handlers. Step interrupt waits: from its flag to its service, on any axis.",
    tasks,
    (
        key("board", "board", left=True),
        key("axes", "axes"),
        key("steps/s", "steps_per_s"),
        key("while", "scene", left=True),
        key("off", "interrupts_off_cycles"),
        key("off in the main loop", "interrupts_off_main_cycles"),
        key("step interrupt waits", "step_wait_cycles"),
    ),
)
