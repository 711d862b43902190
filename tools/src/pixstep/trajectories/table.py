# SPDX-License-Identifier: MIT
"""A table of two axes: what makes one fit to be run, and its forms as files.

A file has 16-byte records as a tabular controller streams them (four signed 32-bit integers,
little-endian: p1, v1, p2, v2), or the same columns by name as CSV or Parquet. Reading goes by the
content, writing by the end of the name.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep import atomic
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import np
from pixstep.lines.line_check import MAX_COUNT
from pixstep.owndata.layout import LINE_END, decoded
from pixstep.owndata.table import MINUS, SEPARATORS

if TYPE_CHECKING:
    from types import ModuleType


AXES = 2
COLUMNS = ("p1", "v1", "p2", "v2")
MOST_RECORDS = 2_000_000
LEAST_INT32, MOST_INT32 = -(2**31), 2**31 - 1


@dataclass(frozen=True)
class TwoAxisTable:
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

    def without_holds(self) -> TwoAxisTable:
        """Return the table from where it stands last: a record at rest, then the motion."""
        first = max(self.holds - 1, 0)
        return TwoAxisTable(self.positions[first:], self.velocities[first:], self.name)

    def counts(self, axis: int) -> np.ndarray:
        """Return the signed counts from each point to the next of an axis, 0 or 1."""
        return np.diff(self.positions[:, axis])


def made(positions: np.ndarray, velocities: np.ndarray, name: str) -> TwoAxisTable:
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
    moves = np.abs(np.diff(positions, axis=0, prepend=positions[:1]))
    for row, axis in np.argwhere(moves > MAX_COUNT)[:1].tolist():
        raise RefusedError(
            f"{name}: record {row + 1}: p{axis + 1} = {positions[row, axis]} is "
            f"{moves[row, axis]} counts from the record before: {_FAST}"
        )
    return TwoAxisTable(positions, velocities, name)


_WIDE = f"a record holds {LEAST_INT32} to {MOST_INT32}"
_FAST = f"a pixel holds at most {MAX_COUNT}"


def _refuse(values: np.ndarray, wrong: np.ndarray, kind: str, name: str, why: str) -> None:
    for row, axis in np.argwhere(wrong)[:1].tolist():
        raise RefusedError(
            f"{name}: record {row + 1}: {kind}{axis + 1} = {values[row, axis]}: {why}"
        )


RECORDS, CSV, PARQUET = "records", "csv", "parquet"
RECORD_BYTES = 16
_MOST_BYTES = 256 << 20
_MAGIC = b"PAR1"
_SUFFIXES = {".csv": CSV, ".parquet": PARQUET}
_TEXT = bytes(range(0x20, 0x7F)) + b"\r\n\t"
_SEPARATOR_LINE = re.compile(r'"?sep=', re.IGNORECASE)
_MOST_SHOWN = 40


def kind_of_name(path: Path) -> str:
    """Return the form in which a file of this name is written; the standard output gets CSV."""
    if atomic.is_stdout(path):
        return CSV
    return _SUFFIXES.get(path.suffix.lower(), RECORDS)


def read(path: Path) -> tuple[TwoAxisTable, tuple[str, ...]]:
    """Read a table; return it and notes of what was assumed.

    Raises RefusedError naming the place of what is no table: byte, or line and column, or record.
    """
    data = _bytes(path)
    if data.startswith(_MAGIC):
        return _of_columns(_parquet_columns(path, data), str(path))
    if path.suffix.lower() == ".csv" or (data and not data.translate(None, _TEXT)):
        return _of_columns(
            _csv_columns(path, LINE_END.sub("\n", decoded(path, data)[0])), str(path)
        )
    return _read_records(path, data)


def write(path: Path, made: TwoAxisTable, kind: str | None = None) -> None:
    """Write a table, whole or not at all, in the form that its name says."""
    columns = np.empty((made.records, 4), dtype=np.int64)
    columns[:, 0::2], columns[:, 1::2] = made.positions, made.velocities
    kind = kind or kind_of_name(path)
    if kind == RECORDS:
        atomic.write_bytes(path, columns.astype("<i4").tobytes())
    else:
        write_columns(path, dict(zip(COLUMNS, columns.astype(np.int32).T, strict=True)), kind)


def write_columns(path: Path, columns: dict[str, np.ndarray], kind: str | None = None) -> None:
    """Write named columns of equal length as CSV or Parquet."""
    if (kind or kind_of_name(path)) == PARQUET:
        arrow, parquet = _arrow(path)
        rows = arrow.table({name: arrow.array(values) for name, values in columns.items()})
        atomic.write_with(path, lambda place: parquet.write_table(rows, place))
        return
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(_cells(values) for values in columns.values()), strict=True))
    atomic.write_text(path, text.getvalue())


def _cells(values: np.ndarray) -> Sequence[object]:
    """Return whole numbers as they are, others with the digits that tell 0.01 count."""
    if np.issubdtype(values.dtype, np.floating):
        return [f"{value:.12g}" for value in values.tolist()]
    cells: list[object] = values.tolist()
    return cells


def _bytes(path: Path) -> bytes:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise RefusedError(f"{path}: larger than {_MOST_BYTES >> 20} MiB")
        return path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


def _read_records(path: Path, data: bytes) -> tuple[TwoAxisTable, tuple[str, ...]]:
    whole, rest = divmod(len(data), RECORD_BYTES)
    if rest:
        raise RefusedError(
            f"{path}: record {whole + 1} at byte {whole * RECORD_BYTES} is cut off: {rest} of "
            f"{RECORD_BYTES} bytes"
        )
    values = np.frombuffer(data, dtype="<i4").reshape(-1, 4).astype(np.int64)
    return _checked(values[:, 0::2], values[:, 1::2], str(path))


def _checked(
    positions: np.ndarray, velocities: np.ndarray, name: str
) -> tuple[TwoAxisTable, tuple[str, ...]]:
    """Return a table whose hold records are at rest, and a note if that had to be made so."""
    found = made(positions, velocities, name)
    still = np.all(found.positions == found.positions[0], axis=1)
    holds = int(np.argmin(still)) if not np.all(still) else found.records
    moving = int(np.count_nonzero(np.any(found.velocities[: holds - 1] != 0, axis=1)))
    if not moving:
        return found, ()
    velocities = found.velocities.copy()
    velocities[: holds - 1] = 0
    note = f"{name}: {moving} hold records have a velocity: taken as 0, as they stand still"
    return TwoAxisTable(found.positions, velocities, name), (note,)


def _of_columns(columns: dict[str, np.ndarray], name: str) -> tuple[TwoAxisTable, tuple[str, ...]]:
    """Return the table of named columns; velocities that are missing are differences."""
    positions = np.column_stack([columns["p1"], columns["p2"]])
    if "v1" in columns:
        return _checked(positions, np.column_stack([columns["v1"], columns["v2"]]), name)
    found = made(positions, np.zeros_like(positions), name)
    note = f"{name}: no velocities: half the way from the record before to the record after"
    return TwoAxisTable(found.positions, _differences(found.positions), name), (note,)


def _differences(positions: np.ndarray) -> np.ndarray:
    """Return half the way from the record before to the one after, toward zero; 0 at the ends."""
    around = np.zeros_like(positions)
    around[1:-1] = positions[2:] - positions[:-2]
    return np.trunc(around / 2).astype(np.int64)


def _wanted(path: Path, names: Sequence[str]) -> list[str]:
    """Return the columns to read: both positions, and velocities if both are there."""
    for name in ("p1", "p2"):
        if list(names).count(name) != 1:
            raise RefusedError(
                f"{path}: expected one column {name}: a table has {', '.join(COLUMNS)}, or 16-byte "
                f"records"
            )
    both = {"v1", "v2"} <= set(names)
    if not both and {"v1", "v2"} & set(names):
        raise RefusedError(f"{path}: columns v1 and v2 come together or not at all")
    return [*COLUMNS] if both else ["p1", "p2"]


def _csv_columns(path: Path, text: str) -> dict[str, np.ndarray]:
    """Return the columns of a CSV with a header; raises RefusedError naming line and column."""
    rows = csv.reader(io.StringIO(text), delimiter=_delimiter(text), skipinitialspace=True)
    try:
        names = _names(rows)
        wanted = _wanted(path, names)
        places = [names.index(name) for name in wanted]
        found: list[list[int]] = [[] for _ in wanted]
        empty = 0
        for row in rows:
            if not any(map(str.strip, row)):
                empty = empty or rows.line_num
                continue
            if empty:
                raise RefusedError(f"{path}:{empty}: an empty row between records")
            if len(row) < len(names) or any(row[len(names) :]):
                raise RefusedError(
                    f"{path}:{rows.line_num}: {len(row)} fields, the header has {len(names)}"
                )
            for column, place, name in zip(found, places, wanted, strict=True):
                column.append(_whole(row[place], f"{path}:{rows.line_num}: {name}"))
            if len(found[0]) > MOST_RECORDS:
                raise RefusedError(f"{path}:{rows.line_num}: more than {MOST_RECORDS} records")
    except csv.Error as error:
        raise RefusedError(f"{path}:{rows.line_num}: {error}") from None
    return {
        name: np.array(column, dtype=np.int64) for name, column in zip(wanted, found, strict=True)
    }


def _delimiter(text: str) -> str:
    """Return what divides the names of the header: most of what could."""
    lines = (line for line in text.splitlines() if not _SEPARATOR_LINE.match(line))
    header = next(lines, "")
    return max(SEPARATORS.values(), key=lambda mark: (header.count(mark), mark == ","))


def _names(rows: Iterator[list[str]]) -> list[str]:
    """Return the names of the header, past a line `sep=` and without empty ones behind."""
    names = [name.strip().lower() for name in next(rows, [])]
    if names and _SEPARATOR_LINE.match(names[0]):
        names = [name.strip().lower() for name in next(rows, [])]
    while names and not names[-1]:
        del names[-1]
    return names


def _whole(text: str, where: str) -> int:
    """Return a whole number of at most 18 digits. Raises RefusedError for anything else."""
    word = text.strip().translate(MINUS)
    digits = word.removeprefix("-")
    if not digits.isdecimal() or len(digits) > 18:
        shown = word if len(word) <= _MOST_SHOWN else f"{word[:_MOST_SHOWN]}..."
        raise RefusedError(f"{where} = {shown!r}: expected a whole number")
    return int(word)


def _parquet_columns(path: Path, data: bytes) -> dict[str, np.ndarray]:
    """Return the columns of a Parquet file; raises RefusedError naming column and row."""
    arrow, parquet = _arrow(path)
    try:
        file = parquet.ParquetFile(arrow.BufferReader(data))
        wanted = _wanted(path, file.schema_arrow.names)
        if file.metadata.num_rows > MOST_RECORDS:
            raise RefusedError(f"{path}: more than {MOST_RECORDS} records")
        read = file.read(columns=wanted)
    except (arrow.ArrowException, OSError) as error:
        reason = " ".join(str(error).split())
        raise RefusedError(f"{path}: not a Parquet file that can be read: {reason}") from None
    return {name: _whole_column(path, name, read.column(name)) for name in wanted}


def _whole_column(path: Path, name: str, column: Any) -> np.ndarray:
    values = column.to_numpy()
    if values.dtype.kind not in "iuf":
        raise RefusedError(f"{path}: {name}: expected whole numbers, not {column.type}")
    numbers = values.astype(np.float64)
    wrong = ~np.isfinite(numbers) | (numbers != np.trunc(numbers)) | (np.abs(numbers) >= 2**53)
    if np.any(wrong):
        row = int(np.argmax(wrong))
        raise RefusedError(
            f"{path}: record {row + 1}: {name} = {values[row]}: expected a whole number"
        )
    whole: np.ndarray = numbers.astype(np.int64)
    return whole


def _arrow(path: Path) -> tuple[ModuleType, ModuleType]:
    """Return pyarrow and its Parquet module. Raises UserError where it is not installed."""
    try:
        import pyarrow  # heavy, and wanted for Parquet only
        import pyarrow.parquet
    except ModuleNotFoundError:
        raise UserError(
            f"{path}: Parquet needs pyarrow: pip install 'pixstep[parquet]', or use .csv"
        ) from None
    return pyarrow, pyarrow.parquet
