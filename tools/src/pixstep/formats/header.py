# SPDX-License-Identifier: MIT
"""The four 40-column lines at the head of a CSV or CSB profile."""

import datetime
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.formats.findings import Findings, shown, shown_path
from pixstep.formats.records import odd_byte

HEADER_WIDTH = 40
HEADER_LINES = 4
NAME_WIDTH = 20
MOST_LINES = 99_999
MOST_HAPS, MOST_LEAD_IN = 9999, 999_999

_WEEK = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
_DAYS = tuple(day[:3] for day in _WEEK)
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_CTIME = re.compile(
    rf"({'|'.join(_DAYS)}) ({'|'.join(_MONTHS)}) "
    r"( [1-9]|[1-3][0-9]) ([0-2][0-9]):([0-5][0-9]):([0-6][0-9]) ([0-9]{4})"
)
_HZ = re.compile(r"[0-9]+(\.[0-9]+)?")
_NUMBER = re.compile(r" *(?:0|[1-9][0-9]*)")


LINE_BYTES = HEADER_WIDTH + 2  # with CR LF
CSB_TEXT_AT = 8  # where a CSB holds the four lines


def place_in_csb(line: int, column: int) -> tuple[int, int]:
    """Map a place in the header to the byte of a CSB: line 1, the byte's number from 1."""
    return 1, CSB_TEXT_AT + (line - 1) * LINE_BYTES + column


@dataclass(frozen=True)
class HeaderColumns:
    """Columns of a header line, `start` counted from 0: a label, a number, or blanks."""

    line: int
    start: int
    end: int
    label: str = ""

    def of(self, rows: Sequence[str]) -> str:
        """Return the text of the field."""
        return rows[self.line - 1][self.start : self.end]


_LABELS = (
    HeaderColumns(2, 0, 20, "ACCELERATION PROFILE"),
    HeaderColumns(3, 0, 6, "Lines:"),
    HeaderColumns(3, 14, 19, "HAPs:"),
    HeaderColumns(3, 27, 34, "LeadIn:"),
    HeaderColumns(4, 0, 15, "Pixel Frequency"),
)
_BLANKS = (HeaderColumns(3, 11, 14), HeaderColumns(3, 23, 27))
_NUMBERS = (
    HeaderColumns(3, 6, 11, "Lines"),
    HeaderColumns(3, 19, 23, "HAPs"),
    HeaderColumns(3, 34, 40, "LeadIn"),
)
_LINES, _HAPS, _LEAD_IN = _NUMBERS
_BEFORE_DATE = HeaderColumns(1, 0, 16)  # blank, or the backlash
_PLAY_LABEL, _PLAY = "Backlash:", HeaderColumns(1, 9, 15, "Backlash")
_TIMESTAMP = HeaderColumns(1, 16, 40)
_NAME = HeaderColumns(2, 20, 40)
_FREQUENCY = HeaderColumns(4, 15, 40)


@dataclass(frozen=True)
class ProfileHeader:
    """The four 40-column lines before the data of a CSV profile."""

    timestamp: str  # 24-character ctime text
    name: str  # at most 20 characters
    lines: int  # lines in the file, 1..99999
    haps: int  # homing acceleration pixels: leading entries usable in homing, 0..9999
    lead_in_px: int  # constant pixels before the first image pixel, 0..999999; 0: configured
    pixel_hz: str  # as written, a decimal number above 0
    backlash: int | None = None  # steps that smooth lines were made for; None: it does not say

    @property
    def frequency(self) -> Fraction:
        """The pixel frequency in Hz, exactly as written."""
        return Fraction(self.pixel_hz)

    @property
    def lines_place(self) -> tuple[int, int]:
        """Line and column where the number of lines is written."""
        return 3, _LINES.end - len(str(self.lines)) + 1

    @property
    def haps_place(self) -> tuple[int, int]:
        """Line and column where HAPs is written."""
        return 3, _HAPS.end - len(str(self.haps)) + 1

    @property
    def _play_text(self) -> str:
        return "" if self.backlash is None else f"{_PLAY_LABEL}{self.backlash:>6}"

    @property
    def rows(self) -> list[str]:
        """The four lines; right only for a header that passes `check_header`."""
        return [
            f"{self._play_text:16}{self.timestamp:>24}",
            f"ACCELERATION PROFILE{self.name:>20}",
            f"Lines:{self.lines:>5}   HAPs:{self.haps:>4}    LeadIn:{self.lead_in_px:>6}",
            f"Pixel Frequency{self.pixel_hz:>25}",
        ]


def parse_header(lines: Sequence[bytes], findings: Findings) -> ProfileHeader | None:
    """Read the four lines column by column; None if any of them is refused."""
    before = len(findings.found)
    rows = [_row(number, line, findings) for number, line in enumerate(lines, 1)]
    if len(lines) < HEADER_LINES:
        text = f"the header has {HEADER_LINES} lines, only {len(lines)} here: {shown(lines[-1])}"
        findings.error("header_cut", len(lines), 1, text)
    if len(findings.found) > before:
        return None
    _check_fields(rows, findings)
    if len(findings.found) > before:
        return None
    lines_count, haps, lead_in = (int(field.of(rows)) for field in _NUMBERS)
    made = ProfileHeader(
        timestamp=_TIMESTAMP.of(rows),
        name=_NAME.of(rows).lstrip(" "),
        lines=lines_count,
        haps=haps,
        lead_in_px=lead_in,
        pixel_hz=_FREQUENCY.of(rows).lstrip(" "),
        backlash=int(_PLAY.of(rows)) if _BEFORE_DATE.of(rows).strip(" ") else None,
    )
    _check_date(made, findings)
    return made


def check_header(header: ProfileHeader, path: Path | str) -> None:
    """Raise UserError for a header that cannot be written so that it is read back the same."""
    fields = (
        (_TIMESTAMP, header.timestamp, "timestamp"),
        (_NAME, header.name, "profile name"),
        (_FREQUENCY, header.pixel_hz, "pixel frequency"),
        *zip(_NUMBERS, map(str, (header.lines, header.haps, header.lead_in_px)),
             ("Lines", "HAPs", "LeadIn"), strict=True),
        (_PLAY, "" if header.backlash is None else str(header.backlash), "Backlash"),
    )  # fmt: skip
    for field, text, what in fields:
        width = field.end - field.start
        if len(text) > width:
            raise UserError(
                f"{shown_path(path)}:{field.line}:{field.start + 1}: {what} {shown(text)} is "
                f"longer than {width} characters"
            )
    findings = Findings()
    lines = [row.encode("ascii", "replace") for row in header.rows]
    read = parse_header(lines, findings)
    try:
        findings.raise_first(path)
    except RefusedError as error:  # no file holds this: it was asked for
        raise UserError(str(error)) from None
    if read != header:
        raise UserError(f"{shown_path(path)}:2:21: {shown(header.name)}: only printable ASCII")


def hz_text(frequency: Fraction) -> str:
    """Return a frequency as the header holds it: exact if it has a short decimal, else rounded."""
    text = f"{float(frequency):.10f}".rstrip("0").rstrip(".")
    return text or "0"


def _row(number: int, line: bytes, findings: Findings) -> str:
    """Return a header line as text; its width and its bytes are checked."""
    odd = odd_byte(line)
    if odd:
        name, column, message = odd
        findings.error(name, number, column, message)
    elif len(line) != HEADER_WIDTH:
        message = f"header line {shown(line)} is {len(line)} columns wide, not {HEADER_WIDTH}"
        findings.error("width", number, min(len(line), HEADER_WIDTH) + 1, message)
    return line.decode("latin-1")


def _check_fields(rows: Sequence[str], findings: Findings) -> None:
    """Check every column of the four lines."""
    for field in _LABELS:
        if field.of(rows) != field.label:
            message = f"expected {field.label!r} at column {field.start + 1}"
            _complain(field, "header_label", message, rows, findings)
    for field in _BLANKS:
        if field.of(rows).strip(" "):
            message = f"columns {field.start + 1} to {field.end} must be blank"
            _complain(field, "header_blanks", message, rows, findings)
    for field in _NUMBERS:
        if not _NUMBER.fullmatch(field.of(rows)):
            message = f"{field.label} is not a right-aligned unsigned integer"
            _complain(field, "header_number", message, rows, findings)
    _check_play(rows, findings)
    if _NAME.of(rows).strip(" ") and _NAME.of(rows).endswith(" "):
        _complain(_NAME, "alignment", "the profile name is not right-aligned", rows, findings)
    _check_frequency(rows, findings)
    if not _CTIME.fullmatch(_TIMESTAMP.of(rows)):
        message = "expected a ctime text in columns 17 to 40"
        _complain(_TIMESTAMP, "timestamp", message, rows, findings)
    if _LINES.of(rows).strip(" ") == "0":
        _complain(_LINES, "lines", "at least 1 line is expected", rows, findings)


def _check_play(rows: Sequence[str], findings: Findings) -> None:
    """Require a backlash where the columns before the date are not blank."""
    text = _BEFORE_DATE.of(rows)
    right = (
        text.startswith(_PLAY_LABEL) and text.endswith(" ") and _NUMBER.fullmatch(_PLAY.of(rows))
    )
    if text.strip(" ") and not right:
        message = f"columns 1 to 16 must be blank, or have {_PLAY_LABEL!r} and a number in 10 to 15"
        _complain(_BEFORE_DATE, "header_blanks", message, rows, findings)


def _check_frequency(rows: Sequence[str], findings: Findings) -> None:
    """Require a decimal number above 0, right-aligned."""
    text = _FREQUENCY.of(rows).lstrip(" ")
    if not _HZ.fullmatch(text):
        _complain(_FREQUENCY, "frequency", "pixel frequency is not a number of Hz", rows, findings)
    elif Fraction(text) == 0:
        _complain(_FREQUENCY, "frequency", "pixel frequency must be above 0 Hz", rows, findings)


def _check_date(header: ProfileHeader, findings: Findings) -> None:
    """Warn of a date that no calendar has, or of the wrong day of the week."""
    found = _CTIME.fullmatch(header.timestamp)
    if found is None:  # refused before
        return
    day_name, month, day, hour, *_, year = found.groups()
    try:
        date = datetime.datetime(int(year), _MONTHS.index(month) + 1, int(day), int(hour))
        right = _DAYS[date.weekday()] == day_name
        message = "" if right else f"that day was a {_WEEK[date.weekday()]}"
    except ValueError:
        message = "no calendar has this date"
    if message:
        text = f"{shown(header.timestamp)}: {message}"
        findings.warning("timestamp", 1, _TIMESTAMP.start + 1, text)


def _complain(
    field: HeaderColumns, name: str, message: str, rows: Sequence[str], findings: Findings
) -> None:
    """Add an error at the first character of a field that is not blank, with its text."""
    text = field.of(rows)
    blanks = len(text) - len(text.lstrip(" ")) if text.strip(" ") else 0
    findings.error(name, field.line, field.start + blanks + 1, f"{shown(text)}: {message}")
