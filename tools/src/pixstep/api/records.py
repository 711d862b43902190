# SPDX-License-Identifier: MIT
"""The per-pixel records that a board made while it ran a line, as arrays."""

from __future__ import annotations

import contextlib
import threading
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep import arguments
from pixstep.api.shown import Facts, Shown, count, frame
from pixstep.board import recording
from pixstep.board.errors import BoardError
from pixstep.board.recording import Recorder, Row
from pixstep.board.state import Record
from pixstep.lazy import lazy
from pixstep.simulation.small_pickle import SmallPickle

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
else:
    np, npt = lazy("numpy"), lazy("numpy.typing")


@dataclass(frozen=True, eq=False, repr=False)
class AxisRecords(SmallPickle, Shown):
    """The records of an axis: where the motor should have been and was at each pixel's edge."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis of the board, from 0."""
    every: int
    """Every how many pixels there is a record; 1: of each. Deviations have one besides."""
    missed: int
    """Records that were overwritten on the board before they were read."""
    line: npt.NDArray[np.int32] = field(repr=False)
    """Line of the axis since the board's reset, from 1."""
    pixel: npt.NDArray[np.int32] = field(repr=False)
    """Pixel, from 1."""
    expected_steps: npt.NDArray[np.int32] = field(repr=False)
    """Position at its edge by exact arithmetic, in steps from the beginning of the line."""
    actual_steps: npt.NDArray[np.int32] = field(repr=False)
    """Position by the steps that were made, from there too."""
    edge_error_ticks: npt.NDArray[np.int32] = field(repr=False)
    """Edge of the pixel clock minus the planned edge, in ticks of the board's timer."""

    def __len__(self) -> int:
        """Return the number of records."""
        return len(self.pixel)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write a CSV or Parquet file, by its ending; return its path.

        An existing file is replaced.
        """
        target = arguments.path("path", path)
        with recording.writing(target) as rows:
            for line, *values in zip(*(column.tolist() for column in self._columns), strict=True):
                rows.take(self.unit, Row(line, self.axis, Record(*values)))
        return target

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table without pandas: a row a record."""
        names = ("line", "pixel", "expected_steps", "actual_steps", "edge_error_ticks")
        return frame(dict(zip(names, self._columns, strict=True)))

    def _headline(self) -> str:
        every = "of each pixel" if self.every == 1 else f"of every {self.every}th pixel"
        missed = f", {self.missed} missed" if self.missed else ""
        return f"board {self.unit} axis {self.axis}: {count(len(self), 'record')} {every}{missed}"

    def _facts(self) -> Facts:
        if len(self):
            yield "last pixel", int(self.pixel[-1])
            yield "last position, steps", int(self.actual_steps[-1])
            off = np.abs(self.expected_steps - self.actual_steps)
            yield "largest position error, steps", int(off.max())
            yield "largest edge error, ticks", int(np.abs(self.edge_error_ticks).max())

    @property
    def _columns(self) -> tuple[npt.NDArray[np.int32], ...]:
        return self.line, self.pixel, self.expected_steps, self.actual_steps, self.edge_error_ticks


class Recording:
    """Takes the records of one board's axes while they run; they may be looked at meanwhile."""

    def __init__(self, unit: int, axes: Sequence[int]) -> None:
        self._unit, self._axes = unit, axes
        self._lock = threading.Lock()
        self._values: dict[int, array[int]] = {axis: array("i") for axis in axes}
        self.recorder: Recorder | None = None
        """What reads them; None of a board that keeps none."""

    def take(self, row: Row) -> None:
        """Take a record."""
        found = row.record
        with self._lock:
            self._values[row.axis].extend((
                row.line, found.pixel, found.expected_steps, found.actual_steps,
                found.edge_error_ticks,
            ))  # fmt: skip

    def read_last(self) -> None:
        """Read what lines that were stopped have left on the board, if it still answers."""
        if self.recorder is not None:
            with contextlib.suppress(BoardError):
                self.recorder.look([], ended=True)

    def of(self, axis: int) -> AxisRecords | None:
        """Return the records of an axis so far; None of a board that keeps none."""
        if self.recorder is None:
            return None
        with self._lock:
            values = self._values[axis][:]
        table = np.array(values, dtype=np.int32).reshape(-1, 5)
        return AxisRecords(
            self._unit, axis, self.recorder.every, self.recorder.missed[axis],
            *np.ascontiguousarray(table.T),
        )  # fmt: skip

    def records(self) -> tuple[AxisRecords, ...]:
        """Return the records of all axes so far."""
        found = (self.of(axis) for axis in self._axes)
        return tuple(one for one in found if one is not None)
