# SPDX-License-Identifier: MIT
"""A table of positions and velocities of two axes, and what makes one fit to be run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pixstep.errors import RefusedError
from pixstep.lazy import lazy
from pixstep.lines.line_check import MAX_COUNT

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

AXES = 2
COLUMNS = ("p1", "v1", "p2", "v2")
MOST_RECORDS = 2_000_000
LEAST_INT32, MOST_INT32 = -(2**31), 2**31 - 1


@dataclass(frozen=True)
class Table:
    """Positions (counts) and velocities (counts a point) of both axes: arrays of (records, 2)."""

    positions: np.ndarray
    velocities: np.ndarray
    name: str = field(default="trajectory", compare=False)

    @property
    def records(self) -> int:
        """Number of records, the hold records included."""
        return len(self.positions)

    @property
    def holds(self) -> int:
        """Number of identical records at rest that the table begins with."""
        same = np.all(self.positions == self.positions[0], axis=1)
        same &= np.all(self.velocities == 0, axis=1)
        return int(np.argmin(same)) if not np.all(same) else self.records

    def without_holds(self) -> Table:
        """Return the table from where it stands last: a record at rest, then the motion."""
        first = max(self.holds - 1, 0)
        return Table(self.positions[first:], self.velocities[first:], self.name)

    def counts(self, axis: int) -> np.ndarray:
        """Return the signed counts from each point to the next of an axis, 0 or 1."""
        return np.diff(self.positions[:, axis])


def made(positions: np.ndarray, velocities: np.ndarray, name: str) -> Table:
    """Return a table of whole numbers. Raises RefusedError naming the first record that is wrong.

    A record is wrong if a number is outside of 32 bits, or if it or its velocity is further from
    the one before than a pixel can hold.
    """
    positions, velocities = (np.asarray(item, dtype=np.int64) for item in (positions, velocities))
    if not 2 <= len(positions) <= MOST_RECORDS:
        raise RefusedError(f"{name}: {len(positions)} records, a table has 2 to {MOST_RECORDS}")
    for kind, values in (("p", positions), ("v", velocities)):
        _refuse(values, (values < LEAST_INT32) | (values > MOST_INT32), kind, name, _WIDE)
    _refuse(velocities, np.abs(velocities) > MAX_COUNT, "v", name, _FAST)
    moves = np.vstack([np.zeros((1, AXES), dtype=np.int64), np.diff(positions, axis=0)])
    far = np.abs(moves) > MAX_COUNT
    if np.any(far):
        row, axis = (int(value) for value in np.argwhere(far)[0])
        raise RefusedError(
            f"{name}: record {row + 1}: p{axis + 1} = {positions[row, axis]} is "
            f"{abs(int(moves[row, axis]))} counts from the record before: {_FAST}"
        )
    return Table(positions, velocities, name)


_WIDE = f"a record holds {LEAST_INT32} to {MOST_INT32}"
_FAST = f"a pixel holds at most {MAX_COUNT}"


def _refuse(values: np.ndarray, wrong: np.ndarray, kind: str, name: str, why: str) -> None:
    """Raise RefusedError for the first value that is wrong."""
    if np.any(wrong):
        row, axis = (int(value) for value in np.argwhere(wrong)[0])
        raise RefusedError(
            f"{name}: record {row + 1}: {kind}{axis + 1} = {values[row, axis]}: {why}"
        )
