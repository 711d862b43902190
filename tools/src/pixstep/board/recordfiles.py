# SPDX-License-Identifier: MIT
"""Files of per-pixel records, CSV or Parquet by their ending, written while the records come."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from pixstep import atomic
from pixstep.errors import UserError

if TYPE_CHECKING:
    import pyarrow

    from pixstep.board.logs import Row

COLUMNS = (
    "unit", "line", "axis", "pixel", "expected_steps", "actual_steps", "edge_error_ticks",
)  # fmt: skip
CSV, PARQUET = ".csv", ".parquet"
_GROUP = 1 << 16  # rows of a Parquet file that are written at once


class Rows(Protocol):
    """What takes the records of boards."""

    def take(self, unit: int, row: Row) -> None:
        """Take a record of a board."""

    def close(self) -> None:
        """Write what is left."""


def refuse(path: Path) -> None:
    """Raise UserError for a name that does not say its form; a stream gets CSV."""
    if path.suffix.lower() not in (CSV, PARQUET) and not atomic.is_stream(path):
        raise UserError(f"{path}: a file of records ends with {CSV} or {PARQUET}")


@contextlib.contextmanager
def writing(path: Path) -> Iterator[Rows]:
    """Yield what takes records; the file appears whole at the end.

    What was read before an error is in it as well; if that was nothing there is no file. A file
    that cannot be written further, as on a full disk, does not end the block. Raises UserError for
    that at the end, at once for another ending, and where Parquet is wanted without pyarrow.
    """
    refuse(path)
    failure: BaseException | None = None
    with atomic.replacing(path) as place:
        is_parquet = path.suffix.lower() == PARQUET
        rows = _Patient(_Parquet(path, place) if is_parquet else _Csv(place))
        try:
            yield rows
        except BaseException as error:
            failure = error
        rows.close()
        if failure is not None and not rows.any:
            raise failure  # and no file: the next try needs the name
    if failure is not None:
        raise failure


class _Patient:
    """Takes records on, whatever becomes of their file: motors move meanwhile."""

    def __init__(self, rows: Rows) -> None:
        self._rows = rows
        self._failure: OSError | None = None
        self.any = False

    def take(self, unit: int, row: Row) -> None:
        """Take a record of a board."""
        self.any = True
        if self._failure is None:
            try:
                self._rows.take(unit, row)
            except OSError as error:
                self._failure = error

    def close(self) -> None:
        """Write what is left. Raises what the system had against the file."""
        if self._failure is not None:
            raise self._failure
        self._rows.close()


def _values(unit: int, row: Row) -> tuple[int, ...]:
    found = row.record
    return (
        unit, row.line, row.axis, found.pixel, found.expected_steps, found.actual_steps,
        found.edge_error_ticks,
    )  # fmt: skip


class _Csv:
    """A row for each record, as the boards' log has them, behind the address of the board."""

    def __init__(self, place: Path) -> None:
        self._file = place.open("w", encoding="ascii", newline="\n")
        print(",".join(COLUMNS), file=self._file)

    def take(self, unit: int, row: Row) -> None:
        """Take a record of a board."""
        print(",".join(map(str, _values(unit, row))), file=self._file)

    def close(self) -> None:
        """Write what is left."""
        self._file.close()


class _Parquet:
    """Whole columns, a group of rows at a time, so that no length needs memory."""

    def __init__(self, path: Path, place: Path) -> None:
        try:
            import pyarrow  # heavy, and wanted for Parquet only
            import pyarrow.parquet
        except ModuleNotFoundError:
            raise UserError(
                f"{path}: Parquet needs pyarrow: pip install 'pixstep[parquet]', or use .csv"
            ) from None
        self._arrow = pyarrow
        self._schema: pyarrow.Schema = pyarrow.schema([(name, pyarrow.int32()) for name in COLUMNS])
        self._writer = pyarrow.parquet.ParquetWriter(place, self._schema)
        self._rows: list[tuple[int, ...]] = []

    def take(self, unit: int, row: Row) -> None:
        """Take a record of a board."""
        self._rows.append(_values(unit, row))
        if len(self._rows) >= _GROUP:
            self._flush()

    def close(self) -> None:
        """Write what is left."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        columns = list(zip(*self._rows, strict=True)) or [()] * len(COLUMNS)
        self._writer.write_table(
            self._arrow.table(dict(zip(COLUMNS, columns, strict=True)), schema=self._schema)
        )
        self._rows = []
