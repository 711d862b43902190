# SPDX-License-Identifier: MIT
"""What a simulation gives back, and what it leaves: rows, and lists of edges, as Parquet."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from pixstep.errors import RefusedError, one_line
from pixstep.lazy import np, parquet, pyarrow

PASS, FAIL = "pass", "fail"
MOST_REASON = 400  # characters


@dataclass(frozen=True)
class LineRow:
    """What a motor made in a line.

    `steps` are the steps that it made, `wanted_steps` those of the line. `off_steps` is how far it
    ends from where the job has it. `late_ticks` is how much later than the line before ended the
    line began. Errors are the largest ones of the line: of its steps beside their exact instants on
    the board's own grid, of its pixel edges beside the clock's true ones, of its pixel edges beside
    other motors', of its load at pixel edges. Where there is nothing to compare an error is none.
    `zero_cycle` is line zero, `sha256` the sum of cycles and directions in the list of edges.
    """

    line: int
    motor: str
    board: str
    axis: int
    verdict: str
    reason: str
    steps: int
    wanted_steps: int
    off_steps: int
    late_ticks: float | None
    edge_error_ticks: float | None
    clock_error_ticks: float | None
    apart_ticks: float | None
    load_error_steps: int | None
    zero_cycle: int | None
    sha256: str


@dataclass(frozen=True)
class Edges:
    """The steps of a motor in a line: cycles from the first step of the block on, directions."""

    line: int
    motor: str
    cycles: np.ndarray
    directions: np.ndarray

    def sum(self) -> str:
        """Return the SHA-256 of cycles, 8 bytes each, then directions, 1 byte each."""
        content = hashlib.sha256(self.cycles.astype("<i8").tobytes())
        content.update(self.directions.astype("i1").tobytes())
        return content.hexdigest()


def schema() -> pyarrow.Schema:
    """Return the columns of rows."""
    kinds = {
        "int": pyarrow.int64(), "str": pyarrow.string(), "float | None": pyarrow.float64(),
        "int | None": pyarrow.int64(),
    }  # fmt: skip
    return pyarrow.schema([(one.name, kinds[str(one.type)]) for one in fields(LineRow)])


def pack(found: Sequence[LineRow]) -> bytes:
    """Return rows as Parquet."""
    columns: list[tuple[Any, ...]] = list(zip(*map(astuple, found), strict=True))
    table = pyarrow.table(
        [pyarrow.array(column, kind.type) for column, kind in zip(columns, schema(), strict=True)],
        schema=schema(),
    )
    return _packed(table)


def read(path: Path) -> pyarrow.Table:
    """Return the table of a file of rows. Raises RefusedError for what is none."""
    try:
        found = parquet.read_table(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise RefusedError(f"{path}: {one_line(str(error))}") from None
    if not found.schema.equals(schema()):
        raise RefusedError(f"{path}: no rows of a simulation")
    return found


def pack_edges(found: Iterable[Edges]) -> bytes:
    """Return lists of edges as Parquet: `line` (of the block, from 1), motor, cycle, direction."""
    several = list(found)
    names = pyarrow.array([one.motor for one in several], pyarrow.string())
    owner = np.repeat(np.arange(len(several)), [len(one.cycles) for one in several])
    lines = np.array([one.line for one in several], dtype=np.int32)
    nothing = np.zeros(0, dtype=np.int64)
    table = pyarrow.table({
        "line": pyarrow.array(lines[owner]),
        "motor": pyarrow.DictionaryArray.from_arrays(pyarrow.array(owner), names)
        .cast(pyarrow.string()),
        "cycle": pyarrow.array(np.concatenate([nothing, *(one.cycles for one in several)])),
        "direction": pyarrow.array(
            np.concatenate([nothing, *(one.directions for one in several)]).astype(np.int8)
        ),
    })  # fmt: skip
    return _packed(table, use_dictionary=["line", "motor", "direction"],
                   column_encoding={"cycle": "DELTA_BINARY_PACKED"})  # fmt: skip


def _packed(table: pyarrow.Table, **more: Any) -> bytes:
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(table, sink, compression="zstd", write_statistics=False, **more)
    return bytes(sink.getvalue().to_pybytes())
