# SPDX-License-Identifier: MIT
"""The runner's plant log: where motor and load of each axis were, at every change."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.errors import RefusedError, UserError
from pixstep.lazy import lazy
from pixstep.simulation.edges import blocks, numbers

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

HEADER = "cycle,board,axis,motor,load"
_COLUMNS = 5
_AXES = 256  # more than a board has
_ROW = re.compile(r"\d+,\d+,\d+,-?\d+,-?\d+")


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
        moved: np.ndarray = self.load[np.maximum(index, 0)] - self.load[0]
        return moved


def read_plant(path: Path) -> dict[tuple[int, int], AxisPlant]:
    """Read a plant log by (board, axis); raises UserError naming the line of a malformed one."""
    parts: dict[tuple[int, int], list[np.ndarray]] = {}
    for first, body in blocks(path, HEADER):
        rows = numbers(body, _COLUMNS)
        if rows is None:
            raise _malformed(path, first, body)
        places = rows[:, 1] * _AXES + rows[:, 2]
        for place in np.unique(places).tolist():
            mine = rows[places == place][:, [0, 3, 4]]
            parts.setdefault(divmod(place, _AXES), []).append(mine)
    return {key: AxisPlant(*np.concatenate(tables).T) for key, tables in parts.items()}


def _malformed(path: Path, first: int, body: bytes) -> UserError:
    """Return the refusal of the first row that is none; `first` is the number of its first line."""
    for number, row in enumerate(body.decode("ascii", "replace").splitlines(), first):
        if not _ROW.fullmatch(row):
            return RefusedError(f"{path}:{number}: {row!r} is not a row of a plant log")
    return RefusedError(f"{path}: not a plant log")
