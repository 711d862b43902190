# SPDX-License-Identifier: MIT
"""The runner's edge list and clock log, as arrays."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pixstep.errors import UserError

HEADER = "cycle,board,axis,signal,level"


@dataclass(frozen=True)
class AxisEdges:
    """The edges of one axis, in cycle order: cycles as int64.

    `step_levels` and `direction_levels` are the levels after each edge; DIR is low at reset.
    """

    step_cycles: np.ndarray
    step_levels: np.ndarray
    direction_cycles: np.ndarray
    direction_levels: np.ndarray

    @property
    def rising(self) -> np.ndarray:
        """Cycles of the rising STEP edges: the steps."""
        return self.step_cycles[self.step_levels == 1]

    def directions(self) -> np.ndarray:
        """Return +1 (DIR low) or -1 (DIR high) at every rising STEP edge."""
        index = np.searchsorted(self.direction_cycles, self.rising, side="right")
        levels = np.concatenate([[0], self.direction_levels])
        return np.where(levels[index] == 1, -1, 1).astype(np.int64)


@dataclass(frozen=True)
class EdgeLog:
    """All edges of a run by (board, axis)."""

    axes: dict[tuple[int, int], AxisEdges]

    def axis(self, board: int, axis: int) -> AxisEdges:
        """Return the edges of one axis; all empty if it had none."""
        return self.axes.get((board, axis), _axis_edges([]))


def read_edges(path: Path) -> EdgeLog:
    """Read edges.csv; raises UserError naming the line for a malformed one."""
    try:
        lines = Path(path).read_text(encoding="ascii").splitlines()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    if not lines or lines[0] != HEADER:
        raise UserError(f"{path}:1: the header is not {HEADER!r}")
    rows: dict[tuple[int, int], list[tuple[int, str, int]]] = {}
    for number, line in enumerate(lines[1:], 2):
        try:
            cycle, board, axis, signal, level = line.split(",")
            rows.setdefault((int(board), int(axis)), []).append((int(cycle), signal, int(level)))
        except ValueError:
            raise UserError(f"{path}:{number}: {line!r} is not an edge") from None
    return EdgeLog({key: _axis_edges(found) for key, found in rows.items()})


def read_clock(path: Path) -> np.ndarray:
    """Return the cycles of the pixel clock's rising edges from the runner's clock log."""
    try:
        words = Path(path).read_text(encoding="ascii").split()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    if words and not words[0].isdigit():
        words = words[1:]
    try:
        return np.array(words, dtype=np.int64)
    except ValueError:
        raise UserError(f"{path}: not a clock log") from None


def _axis_edges(rows: list[tuple[int, str, int]]) -> AxisEdges:
    columns = []
    for signal in ("STEP", "DIR"):
        chosen = [(cycle, level) for cycle, name, level in rows if name == signal]
        columns.append(np.array([cycle for cycle, _ in chosen], dtype=np.int64))
        columns.append(np.array([level for _, level in chosen], dtype=np.int64))
    return AxisEdges(*columns)
