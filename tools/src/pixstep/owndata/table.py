# SPDX-License-Identifier: MIT
"""A text table of numbers, read in one way: rows of fields, a header or none.

Every refusal names file, line, column and value. Which ways there are: `readings`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.errors import RefusedError
from pixstep.owndata.numerals import COMMA, DECIMALS, Style

BLANK, NONE = "blank", "none"
SEPARATORS = {"semicolon": ";", "tab": "\t", "bar": "|", "comma": ","}
_IN_WORDS = {"semicolon": "semicolons", "tab": "tabs", "bar": "bars", "comma": "commas"}
_MOST_SHOWN = 40  # characters of a value in a message
Row = tuple[int, list[str]]  # line in the file, fields


def shown(text: str) -> str:
    """Return a value of a message, quoted and not too long."""
    return repr(text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}...")


@dataclass(frozen=True)
class Way:
    """A way to read a table: what divides fields (a key of SEPARATORS, BLANK, NONE), decimals."""

    separator: str
    decimal: str


@dataclass(frozen=True)
class Table:
    """Rows of fields; `names` are those of the header, None without one."""

    path: Path
    rows: tuple[Row, ...]
    names: tuple[str, ...] | None
    way: Way
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
