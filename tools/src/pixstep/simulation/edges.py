# SPDX-License-Identifier: MIT
"""The runner's edge list and clock log, as arrays."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

HEADER = "cycle,board,axis,signal,level"
_SIGNALS = ("STEP", "DIR", "ENABLE", "PERMIT")
_AXES = 256  # more than a board has
_ROW = re.compile(rf"\d+,\d+,\d+,({'|'.join(_SIGNALS)}),[01]")


def no_cycles() -> np.ndarray:
    """Return an array without a cycle."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class AxisEdges:
    """The edges of one axis, in cycle order: cycles as int64.

    Levels are those after each edge; a pin that the program does not drive counts as low, so that
    all are low at reset. The permit output is the whole board's: its edges are with axis 0.
    """

    step_cycles: np.ndarray = field(default_factory=no_cycles)
    step_levels: np.ndarray = field(default_factory=no_cycles)
    direction_cycles: np.ndarray = field(default_factory=no_cycles)
    direction_levels: np.ndarray = field(default_factory=no_cycles)
    enable_cycles: np.ndarray = field(default_factory=no_cycles)
    enable_levels: np.ndarray = field(default_factory=no_cycles)
    permit_cycles: np.ndarray = field(default_factory=no_cycles)
    permit_levels: np.ndarray = field(default_factory=no_cycles)

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

    axes: dict[tuple[int, int], AxisEdges] = field(default_factory=dict)

    def axis(self, board: int, axis: int) -> AxisEdges:
        """Return the edges of one axis; all empty if it had none."""
        return self.axes.get((board, axis), AxisEdges())


def read_edges(path: Path) -> EdgeLog:
    """Read edges.csv; raises UserError naming the line for a malformed one."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    head, _, body = data.partition(b"\n")
    if head != HEADER.encode():
        raise UserError(f"{path}:1: the header is not {HEADER!r}")
    table = _table(body if body.endswith(b"\n") or not body else body + b"\n")
    if table is None:
        for number, line in enumerate(body.decode("ascii", "replace").splitlines(), 2):
            if not _ROW.fullmatch(line):
                raise UserError(f"{path}:{number}: {line!r} is not an edge")
        raise UserError(f"{path}: not an edge list")
    keys = table[:, 1] * _AXES + table[:, 2]
    found = np.flatnonzero(np.bincount(keys)).tolist()
    return EdgeLog({divmod(key, _AXES): _axis_edges(table[keys == key]) for key in found})


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


def _table(body: bytes) -> np.ndarray | None:
    """Return the rows as integers, the signal by its place in _SIGNALS; None if one is malformed.

    All rows are converted at once: a run of seconds has a million of them.
    """
    rows = body.count(b"\n")
    named = 0
    for index, name in enumerate(_SIGNALS):
        named += body.count(f",{name},".encode())
        body = body.replace(f",{name},".encode(), f",{index},".encode())
    words = body.replace(b"\n", b",").split(b",")[:-1]
    if len(words) != 5 * rows or named != rows:
        return None
    try:
        table = np.array(words, dtype=np.int64).reshape(-1, 5)
    except ValueError:
        return None
    fine = np.all(table >= 0) and np.all(table[:, 2] < _AXES) and np.all(table[:, 4] <= 1)
    return table if fine else None


def _axis_edges(table: np.ndarray) -> AxisEdges:
    columns = []
    for name in _SIGNALS:
        chosen = table[table[:, 3] == _SIGNALS.index(name)]
        columns += [chosen[:, 0], chosen[:, 4]]
    return AxisEdges(*columns)
