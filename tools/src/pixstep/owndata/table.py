# SPDX-License-Identifier: MIT
"""A text table of numbers: CSV, tabs, blanks; comments; a header or none.

What the separator is, whether there is a header and how decimals are written follows from the text
and is told. Every refusal names file, line, column and value.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.formats.records import MAX_BYTES
from pixstep.owndata.naming import is_name

_SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas"}
_BLANKS = "blanks"
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2})?")
_MOST_SHOWN = 40  # characters of a value in a message
_MOST_DIGITS = 60
_SAMPLE_LINES = 100
Row = tuple[int, list[str]]  # line in the file, fields


@dataclass(frozen=True)
class Table:
    """Rows of fields; `names` are those of the header, None without one."""

    path: Path
    rows: tuple[Row, ...]
    names: tuple[str, ...] | None
    separator: str
    decimal_comma: bool = False
    notes: tuple[str, ...] = field(default=())

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.rows[0][1])

    def title(self, column: int) -> str:
        """Return a column, from 0, in words."""
        name = f" {self.names[column]!r}" if self.names else ""
        return f"column {column + 1}{name}"

    def error(self, row: int, column: int, message: str) -> UserError:
        """Return the refusal of a field, with its place and value."""
        line, fields = self.rows[row]
        value = fields[column]
        shown = value if len(value) <= _MOST_SHOWN else f"{value[:_MOST_SHOWN]}..."
        return RefusedError(f"{self.path}:{line}: {self.title(column)}: {shown!r}: {message}")

    def values(self, column: int) -> list[Fraction]:
        """Return the numbers of a column, exactly as they are written."""
        return [self._number(row, column) for row in range(len(self.rows))]

    def _number(self, row: int, column: int) -> Fraction:
        text = self.rows[row][1][column]
        if self.decimal_comma:
            text = text.replace(",", ".")
        if not _is_number(text):
            raise self.error(row, column, "not a number")
        return Fraction(text)


def read_table(path: Path) -> Table:
    """Read a table. Raises UserError naming the place of what is no table of numbers."""
    lines = _lines(path)
    data = [(number, text) for number, text in lines if text and not text.startswith("#")]
    if not data:
        raise RefusedError(f"{path}: no numbers in it")
    separator = _separator([text for _, text in data])
    rows = _without_empty_ends([(number, _fields(text, separator)) for number, text in data])
    comma = separator == ";" and any("," in text for _, row in rows[1:] for text in row)
    names = None
    if not _all_numbers(rows[0][1], comma):
        names = tuple(rows.pop(0)[1])
        if rows and len(rows[0][1]) == 1 and not separator:  # a name may have blanks in it
            names = (data[0][1].strip('"'),)
    else:
        names = _names_in_comment(lines, data[0][0], separator, len(rows[0][1]))
    if not rows:
        raise RefusedError(f"{path}:{data[0][0]}: a header, and no numbers behind it")
    table = Table(path, tuple(rows), names, separator, comma, _notes(separator, names, comma))
    _check_width(table)
    if table.width == 1:
        _check_empty_lines(table, lines)
    return table


def _lines(path: Path) -> list[tuple[int, str]]:
    """Return the lines with their numbers, blanks at their ends cut off."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise RefusedError(f"{path}: larger than {MAX_BYTES >> 20} MiB")
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RefusedError(f"{path}: not UTF-8 at byte {error.start}") from None
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    return [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1)]


def _separator(texts: Sequence[str]) -> str:
    """Return what divides the fields of most lines; blanks: ""."""
    sample = texts[-_SAMPLE_LINES:]

    def divides(mark: str) -> bool:
        return 2 * sum(mark in text for text in sample) > len(sample)

    return next((mark for mark in _SEPARATORS if divides(mark)), "")


def _fields(text: str, separator: str) -> list[str]:
    if not separator:
        return [word.strip('"') for word in text.split()]
    fields = next(csv.reader([text], delimiter=separator, skipinitialspace=True), [])
    return [field.strip() for field in fields]


def _without_empty_ends(rows: list[Row]) -> list[Row]:
    """Return rows without the fields behind a separator that ends every one of them."""
    while all(len(fields) > 1 and not fields[-1] for _, fields in rows):
        rows = [(number, fields[:-1]) for number, fields in rows]
    return rows


def _is_number(text: str) -> bool:
    return len(text) <= _MOST_DIGITS and bool(_NUMBER.fullmatch(text))


def _all_numbers(fields: list[str], comma: bool) -> bool:
    """True if no field is a word: a row of data, be its numbers right or not."""
    texts = [text.replace(",", ".") if comma else text for text in fields]
    return any(_is_number(text) for text in texts) or not any(texts)


def _names_in_comment(
    lines: list[tuple[int, str]], first: int, separator: str, width: int
) -> tuple[str, ...] | None:
    """Return names from the comment above the data, as numpy's savetxt writes a header."""
    above = lines[first - 2][1] if first > 1 else ""
    if not above.startswith("#"):
        return None
    text = above.lstrip("# ")
    if width == 1:
        text = text.rstrip(f"{separator} ")
        return (text,) if is_name(text) else None
    names = _without_empty_ends([(first, _fields(text, separator))])[0][1]
    return tuple(names) if len(names) == width else None


def _notes(separator: str, names: tuple[str, ...] | None, comma: bool) -> tuple[str, ...]:
    """Return how the text was understood."""
    header = f"header {', '.join(names)}" if names else "no header"
    decimals = ["decimal commas"] if comma else []
    return (
        ", ".join([f"fields divided by {_SEPARATORS.get(separator, _BLANKS)}", header, *decimals]),
    )


def _check_width(table: Table) -> None:
    """Refuse a row with more or fewer fields than the first; the header included."""
    if table.names and len(table.names) != table.width:
        raise RefusedError(
            f"{table.path}:{table.rows[0][0]}: {table.width} fields, the header has "
            f"{len(table.names)}"
        )
    for line, fields in _others(table):
        raise RefusedError(
            f"{table.path}:{line}: {len(fields)} fields, {table.width} in the rows before: "
            f"{' '.join(fields)[:_MOST_SHOWN]!r}"
        )


def _check_empty_lines(table: Table, lines: list[tuple[int, str]]) -> None:
    """Refuse an empty line between the numbers of a single column: a number may be missing."""
    first, last = table.rows[0][0], table.rows[-1][0]
    for line, text in lines[first:last]:
        if not text:
            raise RefusedError(
                f"{table.path}:{line}: {table.title(0)}: an empty line between numbers: expected "
                f"the number of this row, or no line"
            )


def _others(table: Table) -> Iterator[Row]:
    return (row for row in table.rows if len(row[1]) != table.width)
