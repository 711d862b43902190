# SPDX-License-Identifier: MIT
"""A line from a table: positions, speeds or steps of each pixel become counts.

Positions are rounded to whole steps. A smooth motor's line has one direction, and either what was
rounded or the nearest line to it that such a motor can make (`fitting`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise
from pathlib import Path

from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines import line_check
from pixstep.lines.line import SMOOTH, Line
from pixstep.lines.line_check import MAX_COUNT
from pixstep.lines.units import LENGTH_UNITS, SECOND_UNITS, Scale, parse_seconds
from pixstep.owndata.columns import (
    INDEX,
    POSITION,
    QUANTITIES,
    SPEED,
    STEPS,
    TIME,
    Column,
    KnownColumn,
    factor_of,
    refuse_twins,
)
from pixstep.owndata.fitting import fit, largest_error
from pixstep.owndata.readings import TableHints, read
from pixstep.owndata.table import TextTable

Refuse = Callable[[int, str], UserError]  # takes a pixel, from 0, and what is wrong with it


@dataclass(frozen=True)
class FittedLine:
    """A line, and how far it is from its positions at the worst pixel edge."""

    line: Line
    fitted: bool
    largest_error_steps: Fraction
    worst_pixel: int


def line_of(
    positions: Sequence[Fraction], decode: str, name: str, refuse: Refuse, *, fitted: bool
) -> FittedLine:
    """Return the line through positions in steps, from 0: rounded, so that errors never add up.

    `fitted` lets a smooth motor make the nearest line that it can; a plain one makes any counts.
    """
    counts = counts_of(positions, refuse)
    negative = decode == SMOOTH and _is_negative(counts, refuse)
    fitted = fitted and decode == SMOOTH
    sign = -1 if negative else 1
    if fitted:
        counts = fit([sign * place for place in positions])
    elif negative:
        counts = [-count for count in counts]
    line = Line(tuple(counts), decode, negative=negative, name=name)
    error, worst = largest_error([sign * count for count in counts], positions)
    return FittedLine(line, fitted, error, worst)


def counts_of(positions: Sequence[Fraction], refuse: Refuse) -> list[int]:
    """Return the steps of each pixel by rounded positions. Raises UserError for too many."""
    counts = [after - before for before, after in pairwise(map(round, positions))]
    for pixel, count in enumerate(counts):
        if abs(count) > MAX_COUNT:
            raise refuse(pixel, f"{count} steps in a pixel, the most are {MAX_COUNT}")
    return counts


def _is_negative(counts: Sequence[int], refuse: Refuse) -> bool:
    """Return whether a smooth line runs backwards; raise UserError if it goes both ways."""
    signs = {1 if count > 0 else -1 for count in counts if count}
    if len(signs) > 1:
        first = next(1 if count > 0 else -1 for count in counts if count)
        pixel = next(k for k, count in enumerate(counts) if count * first < 0)
        text = "a smooth line has one direction: this pixel turns back; a line of a plain motor may"
        raise refuse(pixel, text)
    return signs == {-1}


_CLOCK_TOLERANCE = Fraction(1, 1000)
_LENGTHS = "|".join(unit for unit in LENGTH_UNITS if unit != "step")
_UNITS = f"{{unit}} {_LENGTHS}, of speeds also those per px|{'|'.join(SECOND_UNITS)}"


@dataclass(frozen=True)
class ImportRequest:
    """What is known beside the file; None where the file has to say.

    `quantity` is position, speed or steps; `unit` that of a distance, of speeds also mm/s or um/px;
    `column` a name or a number from 1. `negative`: the load's positive direction is the motor's
    negative one. `fit`: let a smooth motor make the nearest line that it can. `separator` (comma,
    semicolon, tab, bar, blank, none) and `decimal` (point, comma) say how the text is written.
    """

    decode: str
    pixel_hz: Fraction | None = None
    quantity: str | None = None
    unit: str | None = None
    column: str | None = None
    scale: Scale | None = None
    negative: bool = False
    fit: bool = False
    separator: str | None = None
    decimal: str | None = None


@dataclass(frozen=True)
class Imported:
    """A line, what was assumed on the way, and how far it is from the file's numbers."""

    line: Line
    assumed: tuple[str, ...]
    largest_error_steps: Fraction
    findings: tuple[line_check.Finding, ...] = ()


@dataclass(frozen=True)
class _Motion:
    """Exact positions at the pixel edges in steps, from 0 at the start; where each came from."""

    table: TextTable
    column: KnownColumn
    positions: tuple[Fraction, ...]
    first_row: int  # of the first pixel

    def error(self, pixel: int, message: str) -> UserError:
        """Return the refusal of a pixel, from 0."""
        return self.table.error(pixel + self.first_row, self.column.number, message)


def import_line(path: str | Path, request: ImportRequest) -> Imported:
    """Make a line of a user's own table.

    Raises UserError naming file, line, column and value of what cannot be a line of this motor, and
    for a file that does not say what its numbers are where the request does not either.
    """
    found = read(Path(path), TableHints(request.column, request.separator, request.decimal))
    column, assumed = _meaning(found.table, found.column, request)
    assumed += _check_others(found.table, found.columns, column, request.pixel_hz)
    motion = _motion(found.table, column, request)
    for pixel, place in enumerate(motion.positions[1:] if column.quantity == STEPS else ()):
        if place.denominator != 1:
            raise motion.error(pixel, "not a whole number of steps")
    name = str(motion.table.path)
    made = line_of(motion.positions, request.decode, name, motion.error, fitted=request.fit)
    findings = tuple(line_check.without_idle_pixel(line_check.check(made.line)))
    said = (found.table.note, *assumed, *_said(made, request))
    return Imported(made.line, said, made.largest_error_steps, findings)


def _meaning(
    read: TextTable, column: Column, request: ImportRequest
) -> tuple[KnownColumn, list[str]]:
    """Return the column with its quantity and unit, and what was assumed of them."""
    quantity = request.quantity or column.quantity
    unit = request.unit or column.unit
    place = f"{read.path}:{read.rows[0][0]}: {read.title(column.number)}"
    if request.unit is None and column.unclear is not None:
        raise RefusedError(AskedText(
            "{place}: {unclear!r} is not a unit: " + _UNITS, place=place, unclear=column.unclear
        ))  # fmt: skip
    whole = unit is None and _are_steps(read, column)
    if quantity not in QUANTITIES and whole:
        quantity, unit = STEPS, "steps"
    if quantity not in QUANTITIES or (unit is None and not (quantity == STEPS or whole)):
        what = f"say what it holds: {{quantity}} {'|'.join(QUANTITIES)} and {_UNITS}"
        raise RefusedError(AskedText("{place}: " + what, place=place))
    unit = unit or "steps"
    words = {
        POSITION: f"the position at each pixel edge in {unit}, the first one that of line zero",
        SPEED: f"the mean speed in each pixel in {unit if '/' in unit else f'{unit}/px'}",
        STEPS: "the steps of each pixel",
    }
    if quantity == STEPS and not unit.startswith("step"):
        raise RefusedError(AskedText(
            "{path}: {title}: steps in {given}: {quantity}?",
            path=read.path, title=read.title(column.number), given=unit,
        ))  # fmt: skip
    text = f"{read.title(column.number)} is {words[quantity]}"
    return KnownColumn(column.number, quantity, unit), [text]


def _are_steps(read: TextTable, column: Column) -> bool:
    """True for whole numbers whose column has no name, or one with a quantity and no unit."""
    plain = not read.names or column.quantity is not None
    return plain and all(value.denominator == 1 for value in read.values(column.number))


def _check_others(
    read: TextTable, columns: Sequence[Column], chosen: Column, hz: Fraction | None
) -> list[str]:
    """Compare the pixel numbers and the times that are beside a column with its rows."""
    others = [column for column in columns if column.number != chosen.number]
    for column in others:
        if column.quantity == INDEX:
            _check_numbers(read, column)
    times = next((column for column in others if column.quantity == TIME), None)
    if times is None:
        return []
    refuse_twins(read, times.number)
    return _check_clock(read, times, hz)


def _check_numbers(read: TextTable, numbers: Column) -> None:
    """Refuse a gap, a repeat or disorder in the numbers of the rows."""
    values = read.values(numbers.number)
    if values[0].denominator != 1:
        raise read.error(0, numbers.number, "not the whole number of a row")
    for row, (before, after) in enumerate(pairwise(values), 1):
        if after != before + 1:
            raise read.error(
                row, numbers.number,
                f"rows must be numbered one by one: expected {before + 1}",
            )  # fmt: skip


def _check_clock(read: TextTable, times: Column, hz: Fraction | None) -> list[str]:
    """Compare a column of times with the pixel clock. Raises UserError where they differ."""
    if times.unclear is not None:
        raise RefusedError(
            f"{read.path}:{read.rows[0][0]}: {read.title(times.number)}: {times.unclear!r} is not "
            f"a unit of time: expected {', '.join(SECOND_UNITS)}"
        )
    per = parse_seconds(f"1 {times.unit or 's'}")
    values = [value * per for value in read.values(times.number)]
    if len(values) < 2 or values[-1] <= values[0]:
        raise read.error(len(values) - 1, times.number, "times must rise")
    period = (values[-1] - values[0]) / (len(values) - 1)
    for row, (before, after) in enumerate(pairwise(values), 1):
        if abs(after - before - period) > period / 10:
            raise read.error(
                row, times.number, f"times are not even: {float(period):.6g} s a pixel on average"
            )
    if hz is None:
        raise read.error(0, times.number, f"needs the pixel clock: {float(1 / period):.6g} Hz?")
    if abs(period * hz - 1) > _CLOCK_TOLERANCE:
        raise read.error(
            0, times.number,
            f"the times are those of {float(1 / period):.6g} Hz, the pixel clock has "
            f"{float(hz):.10g} Hz",
        )  # fmt: skip
    return [f"{read.title(times.number)} agrees with {float(hz):.10g} Hz"]


def _motion(read: TextTable, column: KnownColumn, request: ImportRequest) -> _Motion:
    """Return the motion in steps of the motor, as exact as the numbers are."""
    try:
        factor = factor_of(column.unit, column.quantity, request.scale, request.pixel_hz)
    except UserError as error:
        raise UserError(AskedText(
            "{path}: {title}: {error}", path=read.path, title=read.title(column.number), error=error
        )) from None  # fmt: skip
    factor = -factor if request.negative else factor
    values = [value * factor for value in read.values(column.number)]
    if column.quantity != POSITION:
        return _Motion(read, column, tuple(accumulate(values, initial=Fraction(0))), 0)
    if len(values) < 2:
        raise read.error(0, column.number, "one position is not a motion: give two at least")
    start = values[0]
    return _Motion(read, column, tuple(value - start for value in values), 1)


def _said(made: FittedLine, request: ImportRequest) -> list[str]:
    """Return what is to be said of a line."""
    said: list[str] = []
    if made.line.decode == SMOOTH and (made.line.negative or request.negative):
        word, option = (
            ("backwards", "{negative}") if made.line.negative else ("forwards", "{no_negative}")
        )
        said.append(AskedText(f"the motor runs {word}: {option} for `sim` and `board upload`"))
    if made.fitted:
        said.append(
            AskedText(
                "{fit}: the nearest line with even speeds at the pixel edges, from rest to rest"
            )
        )
    if error := made.largest_error_steps:
        said.append(
            f"rounded to whole steps: at most {float(error):.3g} steps from the file's motion, "
            f"after pixel {made.worst_pixel}"
        )
    return said
