# SPDX-License-Identifier: MIT
"""The text of a table: its encoding, and its lines as a spreadsheet means them.

A line break inside of quotes belongs to its field, so that a line here may be several in the file.
"""

import codecs
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.formats.records import MAX_BYTES

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
class Text:
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


def read_text(path: Path) -> Text:
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
    return Text(path, tuple(lines), separator, _NAMES.get(encoding, encoding.upper()))


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
