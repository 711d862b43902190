# SPDX-License-Identifier: MIT
"""The lines of a text divided into fields by one separator, and the header taken off."""

import csv
import re
from collections import Counter

from pixstep.errors import RefusedError
from pixstep.owndata.naming import is_name
from pixstep.owndata.table import BLANK, NONE, SEPARATORS, STYLES, Row, Table, Way, shown
from pixstep.owndata.text import Text, is_comment

_WORD = re.compile(r'"[^"]*"|[^ \t]+')

_NOTHING = re.compile(r"nan|n/?a|[+-]?inf(?:inity)?|null|none|-+|err:\d+|#.*[!?]|#n/?[a-z]|##+")


class Layout:
    """Rows of fields; `refusal` says why they are no table, None if they are one.

    `ragged`: rows differ in their number of fields. `width` is that of most of them, without the
    columns behind that are empty; `most` is with these.
    """

    def __init__(self, text: Text, separator: str) -> None:
        """Divide the lines of a text that has some."""
        self.text, self.separator = text, separator
        self.refusal: RefusedError | None = None
        self.ragged = False
        rows = _divided(text, separator)
        self.first_line = rows[0][0]
        self.names = _take_header(rows)
        if self.names and separator == BLANK:
            self.names = _with_units(self.names)
        rows = _without_empty_ends(rows)
        self.most, self.width = _widths(rows)
        self.rows = rows
        self.refusal = self._fit() if rows else self._nothing()

    @property
    def splits_header(self) -> bool:
        """True if the header has as many names as the rows have fields, several."""
        return self.names is not None and self.width > 1 and _filled([*self.names]) == self.width

    def table(self, decimal: str, *, chosen: bool) -> Table:
        """Return the table as a style of numbers reads it."""
        way = Way(self.separator, decimal)
        names = None if self.names is None else tuple(self.names)
        return Table(self.text.path, tuple(self.rows), names, way, self.text.encoding, chosen)

    def _nothing(self) -> RefusedError:
        if self.names is None:
            return RefusedError(f"{self.text.path}: no numbers in it")
        return RefusedError(
            f"{self.text.path}:{self.first_line}: a header, and no numbers behind it"
        )

    def _fit(self) -> RefusedError | None:
        """Make all rows and the header as wide as the table; return the refusal of what is not."""
        path = self.text.path
        if self.names is not None and (missing := _missing(self.names)):
            return RefusedError(f"{path}:{self.first_line}: {shown(missing)}: not a number")
        if self.names is None:
            self.names = _names_in_comment(self.text, self.first_line, self.separator, self.width)
        if self.names is not None:
            filled = _filled(self.names)
            least = min(len(fields) for _, fields in self.rows)
            if filled > self.width and least >= filled:  # columns that have a name only
                self.width = filled
                self.most = max(self.most, filled)
            if filled > self.width or len(self.names) < self.width:
                return RefusedError(
                    f"{path}:{self.rows[0][0]}: {self.width} fields, the header has {filled}"
                )
            self.names = (self.names + [""] * self.width)[: self.width]
        for index, (line, fields) in enumerate(self.rows):
            if not any(fields):
                return RefusedError(
                    f"{path}:{line}: an empty row between numbers: expected the numbers of this "
                    f"row, or no row"
                )
            if len(fields) < self.width or _filled(fields) > self.most:
                self.ragged = True
                return RefusedError(
                    f"{path}:{line}: {_filled(fields)} fields, {self.width} in "
                    f"{'the rows before' if index else 'most rows'}: {shown(' '.join(fields))}"
                )
        self.rows = [(line, fields[: self.width]) for line, fields in self.rows]
        return self._empty_line() if self.width == 1 else None

    def _empty_line(self) -> RefusedError | None:
        """Return the refusal of an empty line in a single column: a number may be missing."""
        first, last = self.rows[0][0], self.rows[-1][0]
        name = f" {self.names[0]!r}" if self.names else ""
        for line, text in self.text.lines:
            if first < line < last and not text.strip():
                return RefusedError(
                    f"{self.text.path}:{line}: column 1{name}: an empty line between numbers: "
                    f"expected the number of this row, or no line"
                )
        return None


def _divided(text: Text, separator: str) -> list[Row]:
    lines = text.data
    if separator == NONE:
        return [(line, [content.strip().strip('"')]) for line, content in lines]
    if separator == BLANK:
        return [
            (line, [word.strip('"') for word in _WORD.findall(content)] or [""])
            for line, content in lines
        ]
    return list(zip((line for line, _ in lines), _fields(text, separator), strict=True))


def _fields(text: Text, separator: str) -> list[list[str]]:
    """Return the fields of all lines, quotes taken off."""
    reader = csv.reader(
        (content for _, content in text.data),
        delimiter=SEPARATORS[separator],
        skipinitialspace=True,
    )
    try:
        found = [[field.strip() for field in fields] for fields in reader]
    except csv.Error as error:
        raise RefusedError(f"{text.path}: line {reader.line_num}: {error}") from None
    if len(found) != len(text.data):
        raise RefusedError(f"{text.path}: a quote is never closed")
    return found


def _widths(rows: list[Row]) -> tuple[int, int]:
    """Return the number of fields that most rows have, and without columns that are empty."""
    if not rows:
        return 0, 0
    most = Counter(len(fields) for _, fields in rows).most_common(1)[0][0]
    filled = (_filled(fields) for _, fields in rows)
    return most, max((count for count in filled if count <= most), default=0) or 1


def _filled(fields: list[str]) -> int:
    """Return the number of fields without the empty ones at the end."""
    count = len(fields)
    while count and not fields[count - 1]:
        count -= 1
    return count


def _take_header(rows: list[Row]) -> list[str] | None:
    """Take the first row that is not empty off, if none of its fields is a number."""
    first = next((k for k, (_, fields) in enumerate(rows) if any(fields)), 0)
    fields = rows[first][1]
    if not any(fields) or any(
        style.is_number(text) for text in fields for style in STYLES.values()
    ):
        return None
    del rows[: first + 1]
    return fields


def _missing(names: list[str]) -> str | None:
    """Return what stands for a number that is not there, and so is no name of a column."""
    return next((name for name in names if _NOTHING.fullmatch(name.lower())), None)


def _with_units(words: list[str]) -> list[str]:
    """Return names that blanks divide: (mm) is no name, it belongs to the one before."""
    names: list[str] = []
    for word in words:
        if names and word[:1] in ("(", "["):
            names[-1] = f"{names[-1]} {word}"
        else:
            names.append(word)
    return names


def _without_empty_ends(rows: list[Row]) -> list[Row]:
    """Return rows without those at both ends that have separators only."""
    full = [k for k, (_, fields) in enumerate(rows) if any(fields)]
    return rows[full[0] : full[-1] + 1] if full else []


def _names_in_comment(text: Text, first: int, separator: str, width: int) -> list[str] | None:
    """Return names from the comment above the data, as numpy's savetxt writes a header."""
    above = ""
    for line, content in text.lines:
        if line == first:
            break
        above = content
    if not is_comment(above):
        return None
    words = above.lstrip("# ")
    if width == 1:
        name = words.rstrip(f"{SEPARATORS.get(separator, '')} ")
        return [name] if is_name(name) else None
    lines = ((first, words),)
    names = _divided(Text(text.path, lines, None, text.encoding), separator)[0][1]
    names = _with_units(names) if separator == BLANK else names
    return names if _filled(names) == width else None
