# SPDX-License-Identifier: MIT
"""Flash, static RAM, worst stack computed and measured, RAM left."""

import json
import shutil
import sys
from fractions import Fraction
from typing import Any

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep_dev.bench import stretch
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_trials import lines

NAME = "sizes"
_HZ = Fraction(30)
_COUNT, _SECONDS = 100, 1.0  # steps/pixel on every axis while the stack is watched


def tasks() -> list[Task]:
    """One task for each board."""
    return [Task(NAME, measure, (board,)) for board in boards.BOARD_NAMES]


def measure(board: str) -> list[dict[str, Any]]:
    """Measure one image."""
    counted = _counted(board)
    stack = max(_stack_used(board, steady) for steady in (True, False))
    return [
        {
            "board": board,
            "flash_bytes": counted["flash"],
            "flash_of_bytes": boards.load(board).flash_bytes,
            "ram_bytes": counted["static_ram"],
            "ram_of_bytes": boards.load(board).ram_bytes,
            "stack_measured_bytes": stack,
            "stack_worst_bytes": counted["worst_stack"],
            "ram_left_bytes": counted["free"],
        }
    ]


def _counted(board: str) -> dict[str, Any]:
    """Return what tools/checks/sizes.py finds in the image."""
    if not shutil.which("avr-objdump"):
        raise UserError("avr-objdump is missing: run tools/setup")
    script = natives.source("tools/checks/sizes.py")
    done = natives.run([sys.executable, str(script), "--json", f"{board}={natives.image(board)}"])
    try:
        return dict(json.loads(done.stdout)[board])
    except (ValueError, KeyError):
        text = (done.stdout + done.stderr).strip().splitlines()
        raise UserError(f"{script.name}: {text[-1] if text else 'no answer'}") from None


def _stack_used(board: str, steady: bool) -> int:
    """Return the simulator's high-water mark with all axes moving and the serial line saturated."""
    line = lines.at_peak(_COUNT, _HZ, _SECONDS, steady=steady)
    axes = boards.load(board).axes
    view = stretch.moving(board, line, _HZ, stretch.inside(line), axes=axes, serial_load=True)
    return int(view["stack_used_bytes"])


FIGURE = BenchFigure(
    NAME,
    "Size, bytes",
    "Stack seen: the simulator's high-water mark with all axes moving and the serial line "
    "saturated. Worst stack: counted path by path on the disassembly (`tools/checks/sizes.py`).",
    tasks,
    (
        key("board", "board", left=True),
        key("flash", "flash_bytes"),
        key("of", "flash_of_bytes"),
        key("static RAM", "ram_bytes"),
        key("of", "ram_of_bytes"),
        key("stack seen", "stack_measured_bytes"),
        key("worst stack", "stack_worst_bytes"),
        key("RAM left with it", "ram_left_bytes"),
    ),
)
