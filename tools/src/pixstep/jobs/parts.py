# SPDX-License-Identifier: MIT
"""Per-pixel records of a run, a Parquet file a line: where each motor should have been, and was.

They are what the boards keep and this computer has read in time: `record_every` of the boards, and
pixels that were overwritten before, leave gaps. Unlike the log they are not synced.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import atomic
from pixstep.board.state import Record
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import pyarrow
    from pyarrow import parquet
else:
    pyarrow, parquet = lazy("pyarrow"), lazy("pyarrow.parquet")

FOLDER = "parts"
FIELDS = ("pixel", "expected_steps", "actual_steps", "edge_error_ticks")


class Parts:
    """The folder of the records; lines are written once nothing more comes of them."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder / FOLDER
        with atomic.told_of(self._folder):  # here, not when the first line has been made
            self._folder.mkdir(exist_ok=True)
        self._rows: dict[int, list[tuple[str, Record]]] = {}

    def take(self, line: int, motor: str, record: Record) -> None:
        """Take a record of a motor in a line."""
        self._rows.setdefault(line, []).append((motor, record))

    def write(self, last: int) -> None:
        """Write the lines up to one."""
        for line in sorted(self._rows):
            if line <= last:
                self._write(line, self._rows.pop(line))

    def _write(self, line: int, rows: Iterable[tuple[str, Record]]) -> None:
        found = sorted(rows, key=lambda row: (row[0], row[1].pixel))
        columns = {"motor": pyarrow.array([motor for motor, _ in found], pyarrow.string())} | {
            name: pyarrow.array([getattr(record, name) for _, record in found], pyarrow.int32())
            for name in FIELDS
        }
        sink = pyarrow.BufferOutputStream()
        parquet.write_table(pyarrow.table(columns), sink, compression="zstd")
        path = self._folder / f"line-{line:06}.parquet"
        with atomic.rules(atomic.WriteRules(force=True)):
            atomic.write_bytes(path, bytes(sink.getvalue().to_pybytes()))
