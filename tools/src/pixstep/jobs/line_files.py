# SPDX-License-Identifier: MIT
"""Files of lines as a job: one a motor, with the backlash and lead-in of its header.

A table of positions as lines: a column a motor, a row a pixel edge, a column `line` for many.

    line,M39_mm,M40
    1,0,0
    1,0.01,2
    ...

The first row of a line is where the motors are at line zero: one row more than pixels. A line
begins where the one before ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby
from pathlib import Path
from typing import Any

from pixstep import formats
from pixstep.errors import RefusedError, UserError
from pixstep.formats import MotionFile
from pixstep.jobs.assembly import ImagePlace, MotorStroke
from pixstep.jobs.header import SourceTable
from pixstep.jobs.making import JobOptions, NewJob, of_lines, source_files
from pixstep.lines.line import PLAIN, Line
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable
from pixstep.owndata import readings
from pixstep.owndata.columns import POSITION, factor_of, meaning_of
from pixstep.owndata.importing import line_of
from pixstep.owndata.readings import TableReading
from pixstep.profiles import origin
from pixstep.profiles.origin import AskedBacklash

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
    strokes = {name: [*_strokes_of_table(table, lines)] for name, table in tables.items()}
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
        raise RefusedError(f"{path}: {read.table.title(number)}: {said.unclear!r} is not a unit")
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


def _strokes_of_table(table: _Positions, lines: Sequence[range]) -> Iterator[MotorStroke]:
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


def of_files(
    machine: MachineFile, paths: Mapping[str, Path], asked: JobOptions, *, alternate: bool = True,
    refuse_faster: bool = True,
) -> NewJob:  # fmt: skip
    """Return the job of files of lines, one a motor; a file of one line is that line each time.

    The counts of a smooth motor have no sign: they run forth and back if they `alternate`. The
    image begins as the header of a file says that has a lead-in. A file for another motor or
    another pixel frequency gets a note; one for a lower frequency is refused, if wanted.
    """
    read = {machine[name].name: formats.read_motion(path) for name, path in paths.items()}
    count = max(len(file.blocks) for file in read.values())
    strokes = {name: _strokes(machine[name], read[name], count, alternate) for name in read}
    own, notes = _own_backlash(machine, read, asked)
    images = [_image_pixels(machine[name], file, own) for name, file in read.items()]
    places = [ImagePlace(max(one[k % len(one)] for one in images)) for k in range(count)]
    source = SourceTable(kind="lines", files=source_files(paths.values()))
    for name, file in read.items():
        notes += [*file.notes, *_for_another(machine, name, file, refuse_faster)]
    files = {name: _said_of(file) for name, file in read.items()}
    return replace(of_lines(machine, strokes, places, source, own, files), notes=tuple(notes))


def _for_another(
    machine: MachineFile, name: str, file: MotionFile, refuse_faster: bool
) -> Iterator[str]:
    """Yield that a file is for another motor, or for another frequency of pixels."""
    path = Path(file.path)
    yield from origin.other_motor(path, file.header.name if file.header else None, name)
    yield from origin.frequency_notes(path, file.header, machine.pixel_hz, refuse=refuse_faster)


def _said_of(file: MotionFile) -> dict[str, Any]:
    """Return the name of a file, and what it was made for, as job.toml has it."""
    path, header = Path(file.path), file.header
    return {
        "file": path.name, "file_hz": str(origin.frequency_of(path, header) or ""),
        "file_motor": origin.motor_of(path, header.name if header else None) or "",
    }  # fmt: skip


def _strokes(motor: MotorTable, file: MotionFile, count: int, alternate: bool) -> list[MotorStroke]:
    if len(file.blocks) not in (1, count):
        raise UserError(
            f"{file.path}: holds {len(file.blocks)} lines, others have {count}: equally many are "
            f"wanted, or one that is used for all"
        )
    blocks = file.blocks * count if len(file.blocks) == 1 else file.blocks
    back = [alternate and number % 2 == 1 for number in range(count)]
    return [
        MotorStroke(tuple(block.values), motor.smooth and motor.negative != turned)
        for block, turned in zip(blocks, back, strict=True)
    ]


def _own_backlash(
    machine: MachineFile, read: Mapping[str, MotionFile], asked: JobOptions
) -> tuple[JobOptions, list[str]]:
    """Return the play that each motor's lines take up: what is asked, the file's, the machine's."""
    plays, notes = dict(asked.backlash), []
    for name, file in read.items():
        wanted = AskedBacklash(asked.play(machine[name]), name in asked.backlash, str(machine.path))
        counts, kind = file.blocks[0].values, machine[name].decode
        plays[name], said = origin.taken(file.path, file.header, counts, kind, wanted)
        notes += said
    return replace(asked, backlash=plays), notes


def _image_pixels(motor: MotorTable, file: MotionFile, asked: JobOptions) -> list[int]:
    """Return the first pixel of the image in each line of a file; 0 where nothing says it."""
    lead_in = file.header.lead_in_px if file.header else 0
    if not lead_in or motor.decode == PLAIN:
        return [0] * len(file.blocks)
    found = []
    for block in file.blocks:
        line = Line(tuple(block.values), motor.decode, asked.play(motor))
        first = line.speeds.index(line.line_speed) + 1 if line.line_speed else 0
        found.append(first + lead_in if first else 0)
    return found
