# SPDX-License-Identifier: MIT
"""A table of positions as lines: a column a motor, a row a pixel edge, a column `line` for many.

    line,M39_mm,M40
    1,0,0
    1,0.01,2
    ...

The first row of a line is where the motors are at line zero: one row more than pixels. A line
begins where the one before ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.jobs.assembly import ImagePlace, MotorStroke
from pixstep.jobs.header import SourceTable
from pixstep.jobs.making import JobOptions, NewJob, of_lines, source_files
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable
from pixstep.owndata import readings
from pixstep.owndata.columns import POSITION, factor_of, meaning_of
from pixstep.owndata.importing import line_of
from pixstep.owndata.readings import TableReading

_LINE = "line"


@dataclass(frozen=True)
class _Positions:
    """A motor's positions of all rows in its steps, and where they stand."""

    motor: MotorTable
    read: TableReading
    values: Sequence[Fraction]


def of_table(machine: MachineFile, path: Path, asked: JobOptions) -> NewJob:
    """Return the job of a table. Raises UserError naming line, column and value of a wrong one."""
    names = _names(path)
    motors = {name: column for name in machine.motors if (column := _column(names, name))}
    if not motors:
        raise RefusedError(
            f"{path}: no column is called as a motor: {', '.join(machine.motors)}, or M39_mm"
        )
    tables = {name: _positions(machine, path, name, column) for name, column in motors.items()}
    lines = _lines(next(iter(tables.values())).read)
    strokes = {name: [*_strokes(table, lines)] for name, table in tables.items()}
    starts = {name: round(table.values[0]) for name, table in tables.items()} | {**asked.starts}
    asked = replace(asked, starts=starts)
    places = [ImagePlace(0)] * len(lines)
    source = SourceTable(kind="table", files=source_files([path]))
    return of_lines(machine, strokes, places, source, asked)


def _names(path: Path) -> tuple[str, ...]:
    """Return the names of a table's columns, by the first of them that holds numbers."""
    read = readings.read(path, readings.TableHints("1"))
    if not read.table.names:
        raise RefusedError(f"{path}: a header is wanted, which names the motors")
    return read.table.names


def _column(names: Sequence[str], motor: str) -> str | None:
    """Return the column of a motor: of its name, or of that and what it holds."""
    for name in names:
        rest = name.removeprefix(motor)
        if name.startswith(motor) and not rest[:1].isalnum():
            return name
    return None


def _positions(machine: MachineFile, path: Path, name: str, column: str) -> _Positions:
    motor = machine[name]
    read = readings.read(path, readings.TableHints(column))
    said = meaning_of(column.removeprefix(name))
    number = read.column.number
    if said.unclear is not None:
        raise RefusedError(f"{path}: {read.table.title(number)}: {said.unclear!r} is no unit")
    unit = said.unit or "steps"
    try:
        factor = factor_of(unit, POSITION, motor.steps_per_unit, None)
    except UserError as error:
        raise UserError(f"{path}: {read.table.title(number)}: {error}") from None
    sign = -1 if motor.negative else 1
    return _Positions(motor, read, [sign * factor * one for one in read.table.values(number)])


def _lines(read: TableReading) -> list[range]:
    """Return the rows of each line."""
    names = read.table.names or ()
    count = len(read.table.rows)
    if _LINE not in names:
        return [range(count)]
    numbers = read.table.values(names.index(_LINE))
    found: list[range] = []
    for number, rows in groupby(range(count), key=numbers.__getitem__):
        row = [*rows]
        if number != len(found) + 1:
            raise read.table.error(
                row[0], names.index(_LINE), f"lines are numbered one by one: {len(found) + 1}"
            )
        if len(row) < 2:
            raise read.table.error(row[0], names.index(_LINE), "a line has two rows at least")
        found.append(range(row[0], row[-1] + 1))
    return found


def _strokes(table: _Positions, lines: Sequence[range]) -> Iterator[MotorStroke]:
    last: int | None = None
    for rows in lines:
        places = [table.values[row] for row in rows]
        _refuse_jump(table, rows[0], last, round(places[0]))
        refuse = _Refusal(table, rows[0] + 1)
        start = round(places[0])
        made = line_of(
            [place - start for place in places], table.motor.decode, table.motor.name, refuse,
            fitted=False,
        )  # fmt: skip
        last = round(places[-1])
        yield MotorStroke(made.line.counts, made.line.negative)


@dataclass(frozen=True)
class _Refusal:
    """Makes the refusal of a pixel, from 0, of the line whose first pixel ends in a row."""

    table: _Positions
    row: int

    def __call__(self, pixel: int, message: str) -> UserError:
        read = self.table.read
        return read.table.error(self.row + pixel, read.column.number, message)


def _refuse_jump(table: _Positions, row: int, last: int | None, first: int) -> None:
    if last is not None and first != last:
        read = table.read
        raise read.table.error(
            row, read.column.number,
            f"the line begins {first - last} steps from where the one before ends",
        )  # fmt: skip
