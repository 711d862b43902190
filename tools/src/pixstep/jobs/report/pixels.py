# SPDX-License-Identifier: MIT
"""The figures of a report, pixel by pixel, as arrays of the smallest kind that holds them.

    expected   where each motor should be at each pixel edge: from the job, a row a shape
    actual     where it was, less where it should have been: from the records of the run
    error      how many ticks an edge was off
    measured   where an encoder saw it, less where it should have been

Positions of the last three are rows of lines that have such figures; MISSING is a pixel without.
"""

from __future__ import annotations

import base64
import gzip
import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.errors import RefusedError, UserError
from pixstep.jobs import run_folder
from pixstep.jobs.job import Job
from pixstep.lazy import lazy, parquet

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray
    from pyarrow import csv
else:
    numpy, csv = (lazy("numpy"), lazy("pyarrow.csv"))

MISSING = -(1 << 31)
_KINDS = ("int8", "int16", "int32")
_MEASURED = ("line", "motor", "pixel", "measured_steps")
Table = dict[str, "NDArray[Any]"]


@dataclass
class ReportFigures:
    """The arrays of a report by name, and what they say as a whole.

    `worst_off` is the largest distance of a motor from where it should have been, in steps, with
    its place; `worst_error` the largest edge error, in ticks. `strange` counts records in which a
    board expected another position than the job has.
    """

    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    records: int = 0
    measured: int = 0
    worst_off: int = 0
    off_at: str = ""
    worst_error: int = 0
    strange: int = 0

    def packed(self) -> tuple[list[dict[str, Any]], str]:
        """Return a list of the arrays, and their bytes: gzip in base64."""
        listed, parts_, at = [], [], 0
        for name, values in self.arrays.items():
            small = _smallest(values)
            listed.append({"name": name, "type": small.dtype.name, "at": at, "count": small.size})
            data = small.tobytes()
            data += bytes(-len(data) % 4)  # typed arrays begin at multiples of their size
            parts_.append(data)
            at += len(data)
        return listed, base64.b64encode(gzip.compress(b"".join(parts_), 9, mtime=0)).decode()


def of_run(job: Job, folder: Path, measured: Path | None = None) -> ReportFigures:
    """Return the figures of a run: of its job, its records, and what was measured if there is."""
    found = ReportFigures()
    expected = _of_job(job, found)
    _of_records(job, folder, expected, found)
    if measured is not None:
        _of_measured(job, measured, expected, found)
    return found


@dataclass(frozen=True)
class _Expected:
    """Where motors should be: a row of `steps` a shape, and a shape a line and motor."""

    steps: NDArray[Any]
    shape: NDArray[Any]
    sign: NDArray[Any]
    start: NDArray[Any]

    def of(self, place: int) -> NDArray[Any]:
        """Return the way of a line and motor from the line's start."""
        found: NDArray[Any] = self.sign[place] * self.steps[self.shape[place]]
        return found


def _of_job(job: Job, found: ReportFigures) -> _Expected:
    keys = {key: number for number, key in enumerate(dict.fromkeys(run.shape for run in job.runs))}
    steps = numpy.array([job.shapes[key].expected for key in keys], numpy.int64)
    steps = steps.reshape(len(keys), job.pixels)
    runs = job.runs
    made = _Expected(
        steps,
        numpy.array([keys[run.shape] for run in runs]),
        numpy.array([-1 if run.negative else 1 for run in runs]),
        numpy.array([run.start_steps for run in runs]),
    )
    found.arrays |= {
        "counts": numpy.diff(steps, axis=1, prepend=0), "shape": made.shape, "sign": made.sign,
        "start": made.start, "image": numpy.array([run.image_pixel for run in runs]),
    }  # fmt: skip
    return made


def _of_records(job: Job, folder: Path, expected: _Expected, found: ReportFigures) -> None:
    numbers = {name: number for number, name in enumerate(job.motors)}
    rows = [-1] * len(job.runs)
    off: list[NDArray[Any]] = []
    error: list[NDArray[Any]] = []
    for line, table in _tables(folder, job.lines):
        for name, number in numbers.items():
            mine = table["motor"] == name
            pixel = table["pixel"][mine] - 1
            inside = (pixel >= 0) & (pixel < job.pixels)
            if not inside.any():
                continue
            place, pixel = (line - 1) * len(numbers) + number, pixel[inside]
            way = expected.of(place)[pixel]
            actual, told = (table[key][mine][inside] for key in ("actual_steps", "expected_steps"))
            errors = table["edge_error_ticks"][mine][inside]
            found.strange += int((told != way).sum())
            _note_worst(found, actual - way, errors, pixel, f"{name} in line {line}")
            rows[place] = len(off)
            off.append(_row(job.pixels, pixel, actual - way))
            error.append(_row(job.pixels, pixel, errors))
            found.records += len(pixel)
    found.arrays |= {"row": numpy.array(rows), "actual": _stacked(off), "error": _stacked(error)}


def _note_worst(
    found: ReportFigures, off: NDArray[Any], errors: NDArray[Any], pixel: NDArray[Any], where: str
) -> None:
    at = int(numpy.abs(off).argmax())
    if abs(int(off[at])) > abs(found.worst_off):
        found.worst_off, found.off_at = int(off[at]), f"{where} at pixel {int(pixel[at]) + 1}"
    found.worst_error = max(found.worst_error, int(numpy.abs(errors).max()))


def _tables(folder: Path, lines: int) -> Iterator[tuple[int, Table]]:
    """Yield the records of each line that has some."""
    for path in sorted((folder / run_folder.FOLDER).glob("line-*.parquet")):
        try:
            line = int(path.stem.rpartition("-")[2])
            table = _columns(parquet.read_table(path))
            table = {key: table[key] for key in ("motor", *run_folder.FIELDS)}
            strange = next(
                (key for key in run_folder.FIELDS if table[key].dtype.kind not in "iu"), None
            )
        except KeyError as error:
            raise RefusedError(f"{path}: no records of a run: no column {error}") from None
        except (OSError, ValueError):
            raise RefusedError(f"{path}: no records of a run: no Parquet, or damaged") from None
        if strange:
            raise RefusedError(f"{path}: no records of a run: {strange}: no whole numbers")
        if 1 <= line <= lines:
            yield line, table


def _of_measured(job: Job, path: Path, expected: _Expected, found: ReportFigures) -> None:
    table = _measured(path)
    numbers = {name: number for number, name in enumerate(job.motors)}
    motors = numpy.array([numbers.get(str(name), -1) for name in table["motor"]])
    place = (table["line"] - 1) * len(numbers) + motors
    inside = (motors >= 0) & (table["line"] >= 1) & (table["line"] <= job.lines)
    inside &= (table["pixel"] >= 1) & (table["pixel"] <= job.pixels)
    if not inside.all():
        row = int(numpy.flatnonzero(~inside)[0])
        told = ", ".join(f"{name} {table[name][row]}" for name in _MEASURED[:3])
        raise RefusedError(
            f"{path}: row {row + 1}: {told}: the job has lines 1 to {job.lines}, pixels 1 to "
            f"{job.pixels}, motors {', '.join(job.motors)}"
        )
    _refuse_doubled(path, table, place * job.pixels + table["pixel"])
    rows = [-1] * len(job.runs)
    off: list[NDArray[Any]] = []
    order = numpy.argsort(place, kind="stable")
    for one in numpy.split(order, numpy.flatnonzero(numpy.diff(place[order])) + 1):
        if len(one):
            at, pixel = int(place[one[0]]), table["pixel"][one] - 1
            where = expected.start[at] + expected.of(at)[pixel]
            rows[at] = len(off)
            off.append(_row(job.pixels, pixel, table["measured_steps"][one] - where))
            found.measured += len(pixel)
    found.arrays |= {"measured_row": numpy.array(rows), "measured": _stacked(off)}


def _refuse_doubled(path: Path, table: Table, places: NDArray[Any]) -> None:
    """Refuse a pixel that two rows measure: nothing says which of them is right."""
    order = numpy.argsort(places, kind="stable")
    again = numpy.flatnonzero(numpy.diff(places[order]) == 0)
    if again.size:
        at = int(again[order[again + 1].argmin()])
        first, second = int(order[at]), int(order[at + 1])
        told = ", ".join(f"{name} {table[name][second]}" for name in _MEASURED[:3])
        raise RefusedError(
            f"{path}: row {second + 1}: {told}: row {first + 1} has measured it already: one row a "
            f"pixel is wanted"
        )


def _measured(path: Path) -> Table:
    """Return a table of what was measured."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    try:
        reads = parquet.read_table if path.suffix == ".parquet" else csv.read_csv
        table = _columns(reads(io.BytesIO(data)))
    except (OSError, ValueError):
        raise RefusedError(
            f"{path}: no table, as Parquet (.parquet) or as CSV with commas and a row of names: "
            f"{', '.join(_MEASURED)}"
        ) from None
    for name in _MEASURED:
        if name not in table:
            raise RefusedError(f"{path}: no column {name}: {', '.join(_MEASURED)} are needed")
    for name in ("line", "pixel", "measured_steps"):
        if table[name].dtype.kind not in "iu":
            raise RefusedError(f"{path}: {name}: whole numbers are needed")
    return table


def _columns(table: Any) -> Table:
    return {name: table.column(name).to_numpy() for name in table.column_names}


def _row(pixels: int, at: NDArray[Any], values: NDArray[Any]) -> NDArray[Any]:
    row = numpy.full(pixels, MISSING, numpy.int64)
    row[at] = values
    return row


def _stacked(rows: list[NDArray[Any]]) -> NDArray[Any]:
    return numpy.array(rows, numpy.int64)


def _smallest(values: NDArray[Any]) -> NDArray[Any]:
    """Return whole numbers in the smallest kind; its lowest number stands for MISSING."""
    gone = values == MISSING
    there = values[~gone]
    low, high = (int(there.min()), int(there.max())) if there.size else (0, 0)
    for kind in _KINDS:
        lowest = int(numpy.iinfo(kind).min)
        if lowest < low and high <= numpy.iinfo(kind).max:
            return numpy.where(gone, lowest, values).astype(f"<i{numpy.dtype(kind).itemsize}")
    raise UserError(f"positions of {low} to {high} steps are more than a report can show")
