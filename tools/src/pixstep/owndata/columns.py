# SPDX-License-Identifier: MIT
"""What the columns of a table hold: by their names, by their numbers, or as the user says."""

import re
from dataclasses import dataclass
from fractions import Fraction

from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.owndata.table import Table

POSITION, SPEED, STEPS = "position", "speed", "steps"
QUANTITIES = (POSITION, SPEED, STEPS)
TIME, INDEX = "time", "index"
_UNIT = re.compile(
    r"(?:^|[\s_\[(/])(steps?|nm|um|\u00b5m|\u03bcm|mm|cm|m|deg|us|ms|s)"
    r"(?:(?:/|_per_|_)(px|pixel|ms|s))?[\])]?$"
)
_WORDS = {
    POSITION: re.compile(r"pos|coord|place|^[xyz]($|[^a-z])"),
    SPEED: re.compile(r"speed|vel|^v($|[^a-z])"),
    STEPS: re.compile(r"steps|count"),
    TIME: re.compile(r"time|^t($|[^a-z])"),
    INDEX: re.compile(r"pixel|index|^(n|i|k|px|nr|no|edges?)$"),
}
_TIMES = ("us", "ms", "s")


@dataclass(frozen=True)
class Column:
    """A column: what it holds, in which unit; None where its name does not say."""

    number: int
    quantity: str | None
    unit: str | None


@dataclass(frozen=True)
class KnownColumn(Column):
    """A column of which both are known."""

    quantity: str
    unit: str


def of_name(number: int, name: str) -> Column:
    """Return what a name says: pos_mm, v [mm/s], steps, time_s, pixel."""
    text = name.strip().lower()
    found = _UNIT.search(text)
    unit = None
    if found:
        unit = found[1] + (f"/{found[2]}" if found[2] else "")
    stem = text[: found.start()] if found else text
    quantity = next((key for key, words in _WORDS.items() if words.search(stem)), None)
    if quantity in (None, INDEX) and unit is not None:  # pixel_mm is no number of a row
        quantity = _by_unit(unit)
    return Column(number, quantity, unit)


def _by_unit(unit: str) -> str | None:
    """Return what a unit alone says: a time, a speed, steps; a length may be either."""
    if unit in _TIMES:
        return TIME
    if "/" in unit:
        return SPEED
    return STEPS if unit.startswith("step") else None


def choose(table: Table, wanted: str | None) -> tuple[Column, Column | None]:
    """Return the column to import, and that of the times if there is one.

    `wanted` is a name or a number from 1. Raises UserError if several columns could be meant.
    """
    known = [of_name(k, table.names[k] if table.names else "") for k in range(table.width)]
    times = next((column for column in known if column.quantity == TIME), None)
    if wanted is not None:
        return known[_wanted(table, wanted)], times
    left = [item for item in known if item.quantity not in (TIME, INDEX)]
    if len(left) > 1 and not table.names and _counts_up(table, 0):
        left = left[1:]
    if len(left) != 1:
        names = table.names or [str(k + 1) for k in range(table.width)]
        raise UserError(
            f"{table.path}:{table.rows[0][0]}: {table.width} columns ({', '.join(names)}): choose "
            f"one by --column"
        )
    return left[0], times


def _wanted(table: Table, wanted: str) -> int:
    """Return a column by its name or its number from 1."""
    if table.names and wanted in table.names:
        return table.names.index(wanted)
    if wanted.isascii() and wanted.isdigit() and 1 <= int(wanted) <= table.width:
        return int(wanted) - 1
    has = ", ".join(table.names) if table.names else f"1 to {table.width}"
    raise UserError(f"{table.path}: there is no column {wanted!r}: {has}")


def _counts_up(table: Table, column: int) -> bool:
    """True for 0 1 2 ... or 1 2 3 ..."""
    values = table.values(column)
    return values[0] in (0, 1) and values == [values[0] + k for k in range(len(values))]


def factor_of(unit: str, quantity: str, scale: units.Scale | None, hz: Fraction | None) -> Fraction:
    """Return steps (a pixel, for speeds) for 1 of a unit: steps, mm, um/px, mm/s."""
    order = units.SPEED if quantity == SPEED and "/" in unit else units.DISTANCE
    given = units.parse(f"1 {unit}", order).in_steps(scale)
    return given.per_pixel(hz) if order == units.SPEED else given.value
