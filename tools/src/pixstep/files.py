# SPDX-License-Identifier: MIT
"""Profile and line files: 8-column PRN and 6-column CSV, read strictly, written exactly.

Every error names the file, the line and the offending value. Readers return what they tolerated
as notes, one sentence each, so that the caller can say so.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from pixstep import atomic
from pixstep.errors import UserError

PRN_WIDTH = 8
PRN_MAX = 99_999_999
CSV_WIDTH = 6
HEADER_WIDTH = 40
_HEADER_LINES = 4
_CTIME = re.compile(
    r"(Mon|Tue|Wed|Thu|Fri|Sat|Sun) (Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec) "
    r"[ 0-3]\d [0-2]\d:[0-5]\d:[0-6]\d \d{4}"
)


@dataclass(frozen=True)
class ProfileHeader:
    """The four 40-column lines before the data of a CSV profile."""

    timestamp: str  # 24-character ctime text
    name: str  # at most 20 characters
    lines: int
    haps: int  # leading entries usable in homing
    lead_in_px: int  # constant pixels before the first image pixel
    pixel_hz: str  # as written


@dataclass(frozen=True)
class CsvFile:
    """What a CSV file holds: its values, its header if it has one, and what was tolerated."""

    values: tuple[int, ...]
    header: ProfileHeader | None
    notes: tuple[str, ...] = ()


def read_prn(path: Path, *, lenient: bool = False) -> tuple[list[int], list[str]]:
    """Read an acceleration profile: unsigned, right-aligned in 8 columns, CR LF.

    `lenient` accepts LF and a missing final newline and says so in the returned notes.
    Raises UserError naming file, line and value for anything else.
    """
    records, notes = _records(path, lenient=True)
    if len(records[0]) in (CSV_WIDTH, HEADER_WIDTH):
        raise UserError(
            f"{path}:1: {records[0]!r} is {len(records[0])} columns wide: looks like a CSV "
            f"profile, a PRN profile has {PRN_WIDTH}"
        )
    if not lenient:
        _records(path, lenient=False)
    values = [_prn_value(path, number, text) for number, text in enumerate(records, 1)]
    return values, notes


def write_prn(path: Path, speeds: list[int]) -> None:
    """Write one speed per record, right-aligned in 8 columns, CR LF."""
    for number, value in enumerate(speeds, 1):
        if not 0 <= value <= PRN_MAX:
            raise UserError(f"{path}:{number}: value {value} is outside 0..{PRN_MAX}")
    rows = "".join(f"{value:>{PRN_WIDTH}d}\r\n" for value in speeds)
    atomic.write_bytes(path, rows.encode("ascii"))


def read_csv(path: Path, *, raw: bool = False) -> CsvFile:
    """Read a 6-column CSV of values, bare or after the 40-column header.

    After a header the data are blocks of line number, number of values, values; a block that
    ends early is refused as truncated. `raw` takes every row of the data as a value. Line ends
    may be CR LF, or LF with a note.
    """
    records, notes = _records(path, lenient=True)
    header = None
    if len(records[0]) == HEADER_WIDTH or any(char.isalpha() for char in records[0]):
        header = _parse_header(path, records[:_HEADER_LINES])
        records = records[_HEADER_LINES:]
    first = 1 + (_HEADER_LINES if header else 0)
    values = [_csv_value(path, number, text) for number, text in enumerate(records, first)]
    if not values:
        raise UserError(f"{path}:{first}: no values")
    if header and not raw:
        values = _single_block(path, values, header, first)
    return CsvFile(tuple(values), header, tuple(notes))


def write_csv(path: Path, counts: list[int], header: ProfileHeader | None = None) -> None:
    """Write one count per record, right-aligned in 6 columns, CR LF; after `header` if given."""
    rows = [] if header is None else _header_text(header)
    values = list(counts) if header is None else [1, len(counts), *counts]
    for value in values:
        if not -99_999 <= value <= 999_999:
            raise UserError(f"{path}: value {value} does not fit {CSV_WIDTH} columns")
        rows.append(f"{value:>{CSV_WIDTH}d}")
    atomic.write_bytes(path, "".join(f"{row}\r\n" for row in rows).encode("ascii"))


def _records(path: Path, *, lenient: bool) -> tuple[list[str], list[str]]:
    """Split a file into records without their line ends; return them and the notes."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    if not data:
        raise UserError(f"{path}: the file is empty")
    try:
        text = data.decode("ascii")
    except UnicodeDecodeError as error:
        number = data[: error.start].count(b"\n") + 1
        raise UserError(f"{path}:{number}: byte 0x{data[error.start]:02X} is not ASCII") from None
    rows = text.split("\n")
    notes = []
    if rows[-1] == "":
        rows.pop()
    elif lenient:
        notes.append(f"{path}: no newline after the last record: accepted")
    else:
        raise UserError(f"{path}:{len(rows)}: {rows[-1]!r} has no CR LF after it")
    bare = [number for number, row in enumerate(rows, 1) if not row.endswith("\r")]
    if rows and not text.endswith("\n") and bare and bare[-1] == len(rows):
        bare.pop()
    if bare and not lenient:
        raise UserError(f"{path}:{bare[0]}: {rows[bare[0] - 1]!r} ends with LF, CR LF expected")
    if bare:
        notes.append(f"{path}: {len(bare)} records end with LF instead of CR LF: accepted")
    return [row.removesuffix("\r") for row in rows], notes


def _refuse_blank(path: Path, number: int, text: str) -> None:
    """Refuse what no record of either format may be: empty, or holding a tab."""
    if not text.strip():
        raise UserError(f"{path}:{number}: empty record {text!r}")
    if "\t" in text:
        raise UserError(f"{path}:{number}: {text!r} holds a tab, only blanks may pad a record")


def _prn_value(path: Path, number: int, text: str) -> int:
    """Return the value of one PRN record."""
    _refuse_blank(path, number, text)
    digits = text.strip(" ")
    if digits[0] in "+-":
        raise UserError(f"{path}:{number}: {text!r} has a sign, values are unsigned")
    if not digits.isdigit():
        raise UserError(f"{path}:{number}: {text!r} is not an unsigned decimal integer")
    if int(digits) > PRN_MAX:
        raise UserError(f"{path}:{number}: {digits} is above {PRN_MAX}")
    if len(text) != PRN_WIDTH:
        raise UserError(f"{path}:{number}: {text!r} is {len(text)} columns wide, not {PRN_WIDTH}")
    if text.endswith(" "):
        raise UserError(f"{path}:{number}: {text!r} is not right-aligned")
    return int(digits)


def _csv_value(path: Path, number: int, text: str) -> int:
    """Return the value of one CSV record; a minus sign is legal (plain motors reverse)."""
    _refuse_blank(path, number, text)
    if len(text) != CSV_WIDTH:
        hint = ": looks like a PRN profile" if len(text) == PRN_WIDTH else ""
        raise UserError(
            f"{path}:{number}: {text!r} is {len(text)} columns wide, not {CSV_WIDTH}{hint}"
        )
    if not re.fullmatch(r" *-?\d+", text):
        raise UserError(f"{path}:{number}: {text!r} is not an integer right-aligned in 6 columns")
    return int(text)


def _parse_header(path: Path, rows: list[str]) -> ProfileHeader:
    """Parse the four header lines column by column."""
    for number, row in enumerate(rows, 1):
        if len(row) != HEADER_WIDTH:
            raise UserError(
                f"{path}:{number}: header line {row!r} is {len(row)} columns wide, "
                f"not {HEADER_WIDTH}"
            )
    if len(rows) < _HEADER_LINES:
        raise UserError(f"{path}:{len(rows)}: the header has 4 lines, only {len(rows)} here")
    timestamp = rows[0][16:]
    if rows[0][:16].strip() or not _CTIME.fullmatch(timestamp):
        raise UserError(f"{path}:1: {rows[0]!r}: expected a ctime text in columns 17 to 40")
    _expect_label(path, 2, rows[1], 0, "ACCELERATION PROFILE")
    for start, label in ((0, "Lines:"), (14, "HAPs:"), (27, "LeadIn:")):
        _expect_label(path, 3, rows[2], start, label)
    _expect_label(path, 4, rows[3], 0, "Pixel Frequency")
    for start, end in ((11, 14), (23, 27)):
        if rows[2][start:end].strip():
            raise UserError(f"{path}:3: columns {start + 1} to {end} of {rows[2]!r} must be blank")
    frequency = rows[3][15:].strip()
    if not re.fullmatch(r"\d+(\.\d+)?", frequency):
        raise UserError(f"{path}:4: pixel frequency {frequency!r} is not a number of Hz")
    return ProfileHeader(
        timestamp=timestamp,
        name=rows[1][20:].strip(),
        lines=_header_number(path, rows[2][6:11], "Lines"),
        haps=_header_number(path, rows[2][19:23], "HAPs"),
        lead_in_px=_header_number(path, rows[2][34:40], "LeadIn"),
        pixel_hz=frequency,
    )


def _expect_label(path: Path, number: int, row: str, start: int, label: str) -> None:
    """Require `label` at its columns of a header line."""
    if row[start : start + len(label)] != label:
        raise UserError(f"{path}:{number}: expected {label!r} at column {start + 1} of {row!r}")


def _header_number(path: Path, field: str, label: str) -> int:
    """Return an unsigned right-aligned header number."""
    if not re.fullmatch(r" *\d+", field):
        raise UserError(f"{path}:3: {label} {field!r} is not a right-aligned unsigned integer")
    return int(field)


def _header_text(header: ProfileHeader) -> list[str]:
    """Return the four 40-column header lines."""
    return [
        f"{header.timestamp:>40}",
        f"ACCELERATION PROFILE{header.name:>20}",
        f"Lines:{header.lines:>5}   HAPs:{header.haps:>4}    LeadIn:{header.lead_in_px:>6}",
        f"Pixel Frequency{header.pixel_hz:>25}",
    ]


def _single_block(path: Path, values: list[int], header: ProfileHeader, first: int) -> list[int]:
    """Return the values of the one block of a file with a header."""
    if header.lines != 1:
        raise UserError(f"{path}:3: holds {header.lines} lines; a file of one line is expected")
    if len(values) < 2:
        raise UserError(f"{path}:{first}: truncated: line number and number of values expected")
    number, expected = values[0], values[1]
    found = len(values) - 2
    if number != 1:
        raise UserError(f"{path}:{first}: line number {number}, 1 expected")
    if found < expected:
        raise UserError(
            f"{path}:{first + 1}: truncated, {found} of {expected} values "
            f"(--raw takes every row as a value)"
        )
    if found > expected:
        raise UserError(
            f"{path}:{first + 2 + expected}: {found - expected} rows more than the {expected} "
            f"values announced"
        )
    return values[2:]
