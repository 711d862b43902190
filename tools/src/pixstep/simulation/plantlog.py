# SPDX-License-Identifier: MIT
"""The runner's plant log: where motor and load of each axis were, at every change."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

HEADER = "cycle,board,axis,motor,load"


@dataclass(frozen=True)
class AxisPlant:
    """One axis, in cycle order, as int64: cycles, and motor and load (steps) from then on.

    The first row is where both are at reset.
    """

    cycles: np.ndarray
    motor: np.ndarray
    load: np.ndarray

    def load_at(self, cycles: np.ndarray) -> np.ndarray:
        """Return the load's steps from its start, moves at exactly a cycle included."""
        index = np.searchsorted(self.cycles, cycles, side="right") - 1
        return self.load[np.maximum(index, 0)] - self.load[0]


def read_plant(path: Path) -> dict[tuple[int, int], AxisPlant]:
    """Read a plant log by (board, axis); raises UserError naming the line of a malformed one."""
    rows: dict[tuple[int, int], list[list[int]]] = {}
    try:
        with Path(path).open(encoding="ascii", newline="") as file:
            reader = csv.reader(file)
            if ",".join(next(reader, [])) != HEADER:
                raise UserError(f"{path}:1: the header is not {HEADER!r}")
            for words in reader:
                cycle, board, axis, motor, load = _numbers(path, reader.line_num, words)
                rows.setdefault((board, axis), []).append([cycle, motor, load])
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    return {key: AxisPlant(*np.array(table, dtype=np.int64).T) for key, table in rows.items()}


def _numbers(path: Path, number: int, words: list[str]) -> list[int]:
    """Return the five numbers of a row."""
    try:
        values = [int(word) for word in words]
    except ValueError:
        values = []
    if len(values) != 5:
        raise UserError(f"{path}:{number}: {','.join(words)!r} is not a row of a plant log")
    return values
