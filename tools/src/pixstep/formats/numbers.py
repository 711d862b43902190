# SPDX-License-Identifier: MIT
"""Decimal integers right-aligned in a fixed number of columns: read exactly as they are written."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pixstep.errors import UserError
from pixstep.formats.findings import Findings, shown, shown_path


@dataclass(frozen=True)
class Columns:
    """The columns of one format's records: how many, and whether a minus sign is legal."""

    width: int
    signed: bool
    kind: str
    hints: tuple[tuple[int, str], ...] = ()  # what another width looks like

    @property
    def largest(self) -> int:
        """Largest value that fits."""
        return int(10**self.width) - 1

    @property
    def smallest(self) -> int:
        """Smallest value that fits."""
        return -(10 ** (self.width - 1) - 1) if self.signed else 0

    def fits(self, value: int) -> bool:
        """True if a value can be written."""
        return self.smallest <= value <= self.largest

    def text(self, value: int) -> str:
        """Return the record of a value that fits."""
        return f"{value:>{self.width}d}"

    def column(self, value: int) -> int:
        """Return the 1-based column where the text of a value that fits begins."""
        return self.width - len(str(value)) + 1


PRN_COLUMNS = Columns(8, False, "PRN", ((6, "CSV"),))
CSV_COLUMNS = Columns(6, True, "CSV", ((8, "PRN"),))

# What a writer would have written and nothing else, so that reading loses nothing.
_CANONICAL = {
    True: re.compile(rb" *(?:0|-?[1-9][0-9]*)"),
    False: re.compile(rb" *(?:0|[1-9][0-9]*)"),
}
_ODD_BYTE = re.compile(rb"[^ -~]")
_ODD_BYTES = {
    0x09: ("tab", "holds a tab, only blanks may pad a record"),
    0x0D: ("line_end", "holds a CR that no LF follows, CR LF expected"),
    0x1A: ("control", "holds byte 0x1A, the end-of-file mark of DOS"),
}


def read_numbers(
    rows: Iterable[bytes], columns: Columns, findings: Findings, first: int = 1
) -> list[int]:
    """Return the values of records, the first of them on line `first`; a bad one is a finding."""
    match, width, values = _CANONICAL[columns.signed].fullmatch, columns.width, []
    for number, text in enumerate(rows, first):
        if len(text) == width and match(text):
            values.append(int(text))
            continue
        name, column, message = _complaint(text, columns)
        findings.error(name, number, column, message)
        if findings.full:
            break
    return values


def odd_byte(text: bytes) -> tuple[str, int, str] | None:
    """Return name, column and message for the first byte that no record may hold, if any."""
    found = _ODD_BYTE.search(text)
    if not found:
        return None
    byte = text[found.start()]
    reason = "is not ASCII" if byte > 0x7F else "is a control character"
    name, message = _ODD_BYTES.get(byte, ("not_ascii", f"holds byte 0x{byte:02X}, which {reason}"))
    return name, found.start() + 1, f"{shown(text)} {message}"


def number_texts(
    values: Iterable[int], columns: Columns, path: Path | str, first: int = 1
) -> list[str]:
    """Return the records of values. Raises UserError for one that does not fit its columns."""
    rows = []
    for number, value in enumerate(values, first):
        if not columns.fits(value):
            raise UserError(
                f"{shown_path(path)}:{number}:1: value {value} does not fit {columns.width} "
                f"columns of a {columns.kind}: {columns.smallest}..{columns.largest}"
            )
        rows.append(columns.text(value))
    return rows


def _complaint(text: bytes, columns: Columns) -> tuple[str, int, str]:
    """Return name, column and message of what is wrong with a record."""
    odd = odd_byte(text)
    if odd:
        return odd
    if not text.strip():
        return "empty_record", 1, f"empty record {shown(text)}"
    return _too_large(text, columns) or _wrong_width(text, columns) or _not_number(text, columns)


def _too_large(text: bytes, columns: Columns) -> tuple[str, int, str] | None:
    digits = text.strip(b" ").lstrip(b"0")
    if not digits.isdigit() or len(digits) <= columns.width:
        return None
    column = len(text) - len(text.lstrip(b" ")) + 1
    most = f"is above {columns.largest}, the most that {columns.width} columns hold"
    hint = _hint(text, columns)
    return "too_large", column, f"{shown(digits)} {most}{hint}"


def _wrong_width(text: bytes, columns: Columns) -> tuple[str, int, str] | None:
    if len(text) == columns.width:
        return None
    column = min(len(text), columns.width) + 1
    message = f"{shown(text)} is {len(text)} columns wide, not {columns.width}"
    return "width", column, message + _hint(text, columns)


def _hint(text: bytes, columns: Columns) -> str:
    kind = dict(columns.hints).get(len(text))
    return f": looks like a {kind} profile" if kind else ""


def _not_number(text: bytes, columns: Columns) -> tuple[str, int, str]:
    """Say why a record of the right width and of printable characters is no number."""
    start = len(text) - len(text.lstrip(b" "))
    body = text[start:]
    what = "an integer" if columns.signed else "an unsigned decimal integer"
    if body[:1] in b"+-" and not (columns.signed and body[:1] == b"-"):
        reason = "only a minus sign is legal" if columns.signed else "values are unsigned"
        return "sign", start + 1, f"{shown(text)} has a sign, {reason}"
    bad = re.search(rb"[^0-9]", body[1:] if body[:1] == b"-" else body)
    if bad:
        column = start + 1 + bad.start() + (body[:1] == b"-")
        if not text[column - 1 :].strip(b" "):
            return "alignment", column, f"{shown(text)} is not right-aligned"
        message = f"{shown(text)} is not {what} right-aligned in {columns.width} columns"
        return "not_a_number", column, message
    if body == b"-":
        return "not_a_number", start + 1, f"{shown(text)} is a sign without a number"
    message = f"{shown(text)} has a leading zero, only blanks may pad a record"
    return "leading_zero", start + 1, message
