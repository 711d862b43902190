# SPDX-License-Identifier: MIT
"""The text of a table: its encoding, its lines, its fields by one separator, its header.

Lines are as a spreadsheet means them: a line break inside of quotes belongs to its field, so that a
line here may be several in the file.
"""

import codecs
import csv
import re
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.formats.records import MAX_BYTES
from pixstep.owndata.columns import is_name
from pixstep.owndata.table import (
    BLANK,
    NONE,
    SEPARATORS,
    STYLES,
    Row,
    TableFormat,
    TextTable,
    shown,
)

_MARKS = (  # UTF-32 first: its mark begins with that of UTF-16
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
    (codecs.BOM_UTF8, "utf-8"),
)
_NO_TEXTS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # a zip, as .xlsx and .ods are; an old .xls
_NAMES = {"utf-8": "UTF-8", "cp1252": "Windows-1252"}
LINE_END = re.compile(r"\r\n|\n|\r")
_OPENS = re.compile(r'(?:^|[,;|\t ])"')
_SEPARATOR_LINE = re.compile(r'"?sep=(.)"?[,;|\t]*', re.IGNORECASE)
# What a spreadsheet shows for a number that it has not: #N/A, #DIV/0!, #WERT!, ####.
_NO_NUMBER = re.compile(r"#(?:N/?[A-Z]|[\u00a1\u00bf]?\w[\w/]*[!?]|#+)\s*(?:$|[,;|\t])")
_MOST_LINES = 50  # of a field: more is a quote that nobody closes
# Blanks that are cut off; a tab divides fields.
_BLANKS = " \u00a0\u2009\u202f"


@dataclass(frozen=True)
class SourceText:
    """Lines and their numbers in the file, the separator that the file names, the encoding."""

    path: Path
    lines: tuple[tuple[int, str], ...]
    separator: str | None
    encoding: str

    @cached_property
    def data(self) -> list[tuple[int, str]]:
        """The lines with something in them that are no comments."""
        return [(number, text) for number, text in self.lines if text and not is_comment(text)]


def is_comment(text: str) -> bool:
    """True for a line that is a comment, and no row that begins with a spreadsheet's error."""
    return text.startswith("#") and not _NO_NUMBER.match(text)


def read_text(path: Path) -> SourceText:
    """Read the lines of a file. Raises UserError if that fails, or for what is no text."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise RefusedError(f"{path}: larger than {MAX_BYTES >> 20} MiB")
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    text, encoding = decoded(path, data)
    lines = _lines(path, text)
    separator = None
    if lines and (named := _SEPARATOR_LINE.fullmatch(lines[0][1].lstrip())):
        separator = named[1]
        del lines[0]
    return SourceText(path, tuple(lines), separator, _NAMES.get(encoding, encoding.upper()))


def decoded(path: Path, data: bytes) -> tuple[str, str]:
    """Return the text and its encoding: by the mark in front, by its zeros, by what it can be."""
    if data.startswith(_NO_TEXTS):
        raise RefusedError(
            f"{path}: a spreadsheet's own file (.xlsx, .ods, .xls) or an archive: export it as CSV"
        )
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return _text(path, data, encoding, len(mark)), encoding
    if 4 * data.count(0) > len(data):  # digits in UTF-16: every second byte
        encoding = "utf-16-le" if data[1::2].count(0) > data[::2].count(0) else "utf-16-be"
        return _text(path, data, encoding), encoding
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return _text(path, data, "cp1252"), "cp1252"
    return _text(path, data, "utf-8"), "utf-8"


def _text(path: Path, data: bytes, encoding: str, start: int = 0) -> str:
    try:
        text = data[start:].decode(encoding)
    except UnicodeDecodeError as error:
        name = _NAMES.get(encoding, encoding.upper())
        raise RefusedError(f"{path}: not {name} at byte {start + error.start}") from None
    if "\0" in text:
        raise RefusedError(f"{path}: no text: a zero at byte {data.find(0)}")
    return text


def _lines(path: Path, text: str) -> list[tuple[int, str]]:
    """Return the lines with their numbers, blanks at their ends cut off."""
    found: list[tuple[int, str]] = []
    begun: tuple[int, str] | None = None
    for number, line in enumerate(LINE_END.split(text), 1):
        first, whole = (begun[0], f"{begun[1]} {line}") if begun else (number, line)
        if whole.count('"') % 2 and _OPENS.search(whole) and not is_comment(whole):
            begun = first, whole
            if number < first + _MOST_LINES:
                continue
            break
        begun = None
        found.append((first, whole.strip(_BLANKS)))
    if begun:
        raise RefusedError(f"{path}:{begun[0]}: a quote in this line is never closed")
    return found


_WORD = re.compile(r'"[^"]*"|[^ \t]+')

_NOTHING = re.compile(r"nan|n/?a|[+-]?inf(?:inity)?|null|none|-+|err:\d+|#.*[!?]|#n/?[a-z]|##+")


class TableLayout:
    """Rows of fields; `refusal` says why they are no table, None if they are one.

    `ragged`: rows differ in their number of fields. `width` is that of most of them, without the
    columns behind that are empty; `most` is with these.
    """

    def __init__(self, text: SourceText, separator: str) -> None:
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

    def table(self, decimal: str, *, chosen: bool) -> TextTable:
        """Return the table as a style of numbers reads it."""
        way = TableFormat(self.separator, decimal)
        names = None if self.names is None else tuple(self.names)
        return TextTable(self.text.path, tuple(self.rows), names, way, self.text.encoding, chosen)

    def _nothing(self) -> RefusedError:
        if self.names is None:
            return RefusedError(f"{self.text.path}: no numbers in it")
        return RefusedError(
            f"{self.text.path}:{self.first_line}: a header, and no numbers after it"
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


def _divided(text: SourceText, separator: str) -> list[Row]:
    lines = text.data
    if separator == NONE:
        return [(line, [content.strip().strip('"')]) for line, content in lines]
    if separator == BLANK:
        return [
            (line, [word.strip('"') for word in _WORD.findall(content)] or [""])
            for line, content in lines
        ]
    return list(zip((line for line, _ in lines), _fields(text, separator), strict=True))


def _fields(text: SourceText, separator: str) -> list[list[str]]:
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


def _names_in_comment(text: SourceText, first: int, separator: str, width: int) -> list[str] | None:
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
    names = _divided(SourceText(text.path, lines, None, text.encoding), separator)[0][1]
    names = _with_units(names) if separator == BLANK else names
    return names if _filled(names) == width else None
