# SPDX-License-Identifier: MIT
"""A text table of numbers, read in one way: rows of fields, a header or none.

Every refusal names file, line, column and value. Which ways there are: `readings`. Numbers are as
spreadsheets write them: 0.5, 0,5, 1.234,5, 1 234.5, 1'234.5, a minus of U+2212. Which mark divides
the decimals is said from outside: 1.000 is 1 or 1000, and nothing in it tells.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.errors import RefusedError

POINT, COMMA = "point", "comma"
DECIMALS = {POINT: ".", COMMA: ","}

_MOST_DIGITS = 60
# What else is written for a minus.
MINUS = str.maketrans(dict.fromkeys("\u2212\u2010\u2011\u2013\ufe63\uff0d", "-"))
_GROUPS = " '\u2019\u00a0\u2009\u202f"  # marks of thousands that divide nothing else
_PLAIN = r"[+-]?(?:[0-9]+{0}?[0-9]*|{0}[0-9]+)(?:[eE][+-]?[0-9]{{1,2}})?"
_GROUPED = r"[+-]?[1-9][0-9]{{0,2}}([{1}{2}])[0-9]{{3}}(?:\1[0-9]{{3}})*({0}[0-9]*)?"


class Style:
    """How the numbers of a table are written."""

    def __init__(self, decimal: str) -> None:
        """`decimal` is a key of DECIMALS; the other mark may divide thousands."""
        self.decimal = decimal
        self.mark = DECIMALS[decimal]
        self.other = "," if self.mark == "." else "."
        mark, other = re.escape(self.mark), re.escape(self.other)
        self._plain = re.compile(_PLAIN.format(mark))
        self._grouped = re.compile(_GROUPED.format(mark, other, _GROUPS))

    def is_number(self, text: str) -> bool:
        """True for a number."""
        text = text.translate(MINUS)
        fits = len(text) <= _MOST_DIGITS
        return fits and bool(self._plain.fullmatch(text) or self._grouped.fullmatch(text))

    def number(self, text: str) -> Fraction | None:
        """Return the number, exactly as it is written; None if it is none."""
        if len(text) > _MOST_DIGITS:
            return None
        text = text.translate(MINUS)
        if self._plain.fullmatch(text):
            return Fraction(text.replace(",", ".") if self.mark == "," else text)
        found = self._grouped.fullmatch(text)
        if found is None:
            return None
        return Fraction(text.replace(found[1], "").replace(",", "."))

    def grouped(self, text: str) -> bool:
        """True for a number with marks of thousands."""
        return bool(self._grouped.fullmatch(text.translate(MINUS)))

    def doubtful(self, texts: Sequence[str]) -> int | None:
        """Return the index of a number that looks out of place beside the others of its column.

        With marks of thousands every number from 1000 on has them; and one whose only mark would
        mean decimals in the other style has decimals too where others have.
        """
        grouped = [self.grouped(text) for text in texts]
        if not any(grouped):
            return None
        decimals = any(self.mark in text for text in texts)
        both = any(self.mark in text and self.other in text for text in texts)
        for index, text in enumerate(texts):
            number = self.number(text)
            if number is not None and abs(number) >= 1000 and not grouped[index]:
                return index
            bare = grouped[index] and self.other in text and self.mark not in text
            if bare and decimals and not both:
                return index
        return None


BLANK, NONE = "blank", "none"
SEPARATORS = {"semicolon": ";", "tab": "\t", "bar": "|", "comma": ","}
_IN_WORDS = {"semicolon": "semicolons", "tab": "tabs", "bar": "bars", "comma": "commas"}
_MOST_SHOWN = 40  # characters of a value in a message
Row = tuple[int, list[str]]  # line in the file, fields


def shown(text: str) -> str:
    """Return a value of a message, quoted and not too long."""
    return repr(text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}...")


@dataclass(frozen=True)
class TableFormat:
    """A way to read a table: what divides fields (a key of SEPARATORS, BLANK, NONE), decimals."""

    separator: str
    decimal: str


@dataclass(frozen=True)
class TextTable:
    """Rows of fields; `names` are those of the header, None without one."""

    path: Path
    rows: tuple[Row, ...]
    names: tuple[str, ...] | None
    way: TableFormat
    encoding: str
    chosen_decimal: bool = False  # by the user: nothing is doubtful
    kept: dict[int, list[Fraction]] = field(default_factory=dict, compare=False)

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.rows[0][1])

    @property
    def style(self) -> Style:
        """How numbers are written."""
        return STYLES[self.way.decimal]

    @property
    def note(self) -> str:
        """How the text was understood."""
        separator = self.way.separator
        divided = f"fields divided by {_IN_WORDS.get(separator, 'blanks')}"
        words = [divided if self.width > 1 else "one column"]
        words.append(f"header {', '.join(self.names)}" if self.names else "no header")
        style = self.style
        if style.decimal == COMMA and self._any(lambda text: "," in text):
            words.append("decimal commas")
        if self._any(style.grouped):
            words.append("marks of thousands")
        if self.encoding != "UTF-8":
            words.append(self.encoding)
        return ", ".join(words)

    def title(self, column: int) -> str:
        """Return a column, from 0, in words."""
        name = f" {self.names[column]!r}" if self.names else ""
        return f"column {column + 1}{name}"

    def error(self, row: int, column: int, message: str) -> RefusedError:
        """Return the refusal of a field, with its place and value."""
        line, fields = self.rows[row]
        text = shown(fields[column])
        return RefusedError(f"{self.path}:{line}: {self.title(column)}: {text}: {message}")

    def values(self, column: int) -> list[Fraction]:
        """Return the numbers of a column, exactly as they are written."""
        if column not in self.kept:
            self.kept[column] = self._values(column)
        return self.kept[column]

    def numbers(self, column: int) -> list[Fraction] | None:
        """Return the numbers of a column, None if it has anything else."""
        try:
            return self.values(column)
        except RefusedError:
            return None

    def _values(self, column: int) -> list[Fraction]:
        texts = [fields[column] for _, fields in self.rows]
        found = []
        for row, text in enumerate(texts):
            number = self.style.number(text)
            if number is None:
                raise self.error(row, column, "not a number")
            found.append(number)
        doubtful = None if self.chosen_decimal else self.style.doubtful(texts)
        if doubtful is not None:
            raise self.error(
                doubtful, column, "thousands or decimals, beside the others? --decimal says which"
            )
        return found

    def _any(self, has: Callable[[str], bool]) -> bool:
        return any(has(text) for _, fields in self.rows for text in fields)

    def has_number(self, column: int) -> bool:
        """True if a field of a column is a number: it is no column of remarks, and not empty."""
        return any(self.style.is_number(fields[column]) for _, fields in self.rows)

    def words(self) -> frozenset[tuple[int, int]]:
        """Return the places (row, column) of fields that are no numbers, empty ones left out."""
        is_number = self.style.is_number
        return frozenset(
            (row, column)
            for row, (_, fields) in enumerate(self.rows)
            for column, text in enumerate(fields)
            if text and not is_number(text)
        )


STYLES = {decimal: Style(decimal) for decimal in DECIMALS}
