# SPDX-License-Identifier: MIT
"""What the columns of a table hold: by their names, by their numbers, or as the user says."""

from dataclasses import dataclass
from fractions import Fraction

from pixstep.errors import RefusedError, UserError
from pixstep.formats.findings import counted
from pixstep.lines import units
from pixstep.owndata.naming import INDEX, SPEED, TIME, meaning_of
from pixstep.owndata.table import Table


class ChoiceError(RefusedError):
    """Several columns could be meant, and nothing says which."""


@dataclass(frozen=True)
class Column:
    """A column: what it holds, in which unit; None where its name does not say.

    `unclear` is what its name has in the place of a unit, if that is none.
    """

    number: int
    quantity: str | None
    unit: str | None
    unclear: str | None = None


@dataclass(frozen=True)
class KnownColumn(Column):
    """A column of which both are known."""

    quantity: str
    unit: str


def of_table(table: Table) -> list[Column]:
    """Return what the names of all columns say."""
    named = [meaning_of(name) for name in table.names or [""] * table.width]
    return [
        Column(number, said.quantity, said.unit, said.unclear) for number, said in enumerate(named)
    ]


def choose(table: Table, known: list[Column], wanted: str | None) -> Column:
    """Return the column to import.

    `wanted` is a name or a number from 1. Raises ChoiceError if several columns could be meant.
    """
    if wanted is not None:
        return known[_wanted(table, wanted)]
    left = [
        item
        for item in known
        if item.quantity not in (TIME, INDEX)
        and (item.quantity is not None or table.has_number(item.number))
    ]
    if len(left) > 1 and not (table.names and table.names[left[0].number]):
        left = left[1:] if _counts_up(table, left[0].number) else left
    if len(left) != 1:
        names = table.names or [str(k + 1) for k in range(table.width)]
        held = f"{counted(table.width, 'column')} ({', '.join(names)})"
        said = "choose one by --column" if left else "no numbers to import"
        raise ChoiceError(f"{table.path}:{table.rows[0][0]}: {held}: {said}")
    return left[0]


def _wanted(table: Table, wanted: str) -> int:
    """Return a column by its name or its number from 1."""
    if table.names and wanted in table.names:
        refuse_twins(table, table.names.index(wanted))
        return table.names.index(wanted)
    if wanted.isascii() and wanted.isdigit() and 1 <= int(wanted) <= table.width:
        return int(wanted) - 1
    has = ", ".join(table.names) if table.names else f"1 to {table.width}"
    raise UserError(f"{table.path}: there is no column {wanted!r}: {has}")


def refuse_twins(table: Table, column: int) -> None:
    """Refuse a column that was found by its name if others have the same name."""
    names = table.names or ()
    twins = [str(k) for k, name in enumerate(names, 1) if name == names[column]]
    if len(twins) > 1:
        raise ChoiceError(
            f"{table.path}:{table.rows[0][0]}: columns {', '.join(twins)} are all named "
            f"{names[column]!r}: rename them, or choose by --column N"
        )


def _counts_up(table: Table, column: int) -> bool:
    """True for 0 1 2 ... or 1 2 3 ..."""
    values = table.numbers(column)
    return (
        values is not None
        and values[0] in (0, 1)
        and values == [values[0] + k for k in range(len(values))]
    )


def factor_of(unit: str, quantity: str, scale: units.Scale | None, hz: Fraction | None) -> Fraction:
    """Return steps (a pixel, for speeds) for 1 of a unit: steps, mm, um/px, mm/s."""
    order = units.SPEED if quantity == SPEED and "/" in unit else units.DISTANCE
    given = units.parse(f"1 {unit}", order).in_steps(scale)
    return given.per_pixel(hz) if order == units.SPEED else given.value
