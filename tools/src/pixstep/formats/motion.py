# SPDX-License-Identifier: MIT
"""CSV and CSB: counts of one or many lines, bare or in numbered blocks after a header.

Both formats hold the same rows of integers. Three readings of them: `bare`, without a header,
every row is a value; `blocks`, after a header, rows are line number, number of values, values, and
again for the next line; `raw`, after a header, every row is a value of one line.

A CSV has each row right-aligned in 6 columns, a minus sign legal. A CSB is its binary twin, by a
layout of our own, all numbers little-endian; n follows from the length of the file:

```
 offset    bytes  what
 0         4      "CSB1"
 4         4      h, uint32: length of the header text, 168 or 0
 8         h      the four lines of a CSV header, 40 characters and CR LF each
 8 + h     4 n    n rows of the data, int32 each: what the CSV has a record each for
 8 + h+4n  4      CRC-32 (as in zip) of all bytes before it, uint32
```
"""

import re
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from pixstep.errors import AskedText, UserError
from pixstep.formats.findings import Findings, counted, shown, shown_path
from pixstep.formats.header import (
    CSB_TEXT_AT,
    HEADER_LINES,
    HEADER_WIDTH,
    LINE_BYTES,
    ProfileHeader,
    check_header,
    parse_header,
    place_in_csb,
)
from pixstep.formats.records import (
    CSV_COLUMNS,
    REGULAR,
    LineEnds,
    check_line_ends,
    find_line_ends,
    join_records,
    number_texts,
    read_numbers,
    split_records,
)

CSV_KIND = "csv"
CSB_KIND = "csb"

BARE = "bare"
BLOCKS = "blocks"
RAW = "raw"

RowPlace = Callable[[int], tuple[int, int]]


@dataclass(frozen=True)
class FileBlock:
    """One line: its values (steps in each pixel), the number that the file announces."""

    values: tuple[int, ...]
    declared: int

    @property
    def truncated(self) -> bool:
        """True if the file ends before the announced number of values."""
        return len(self.values) < self.declared


@dataclass(frozen=True)
class MotionFile:
    """What a CSV or CSB holds, all that is needed to write the same bytes, what was tolerated."""

    blocks: tuple[FileBlock, ...]  # line 1, 2, ...
    header: ProfileHeader | None = None
    reading: str = BARE
    kind: str = CSV_KIND
    ends: LineEnds = REGULAR
    notes: tuple[str, ...] = ()
    path: str = "file"

    @property
    def values(self) -> tuple[int, ...]:
        """The values of the only line; UserError if the file holds several."""
        return self.line().values

    @property
    def rows(self) -> list[int]:
        """Every integer of the data in the order of the file."""
        if self.reading != BLOCKS:
            return list(self.blocks[0].values)
        rows: list[int] = []
        for number, block in enumerate(self.blocks, 1):
            rows += (number, block.declared, *block.values)
        return rows

    def line(self, number: int | None = None) -> FileBlock:
        """Return a line by its number from 1; None stands for the only one there is."""
        count = len(self.blocks)
        line, column = self.header.lines_place if self.header else (1, 1)
        if self.kind == CSB_KIND and self.header:
            line, column = place_in_csb(line, column)
        where = f"{shown_path(self.path)}:{line}:{column}"
        if number is None and count > 1:
            raise UserError(AskedText(
                "{where}: holds {count} lines: choose one by {line} 1..{count}",
                where=where, count=count,
            ))  # fmt: skip
        if not 1 <= (number or 1) <= count:
            raise UserError(f"{where}: holds {counted(count, 'line')}, there is no line {number}")
        return self.blocks[(number or 1) - 1]


def of_lines(lines: Sequence[Sequence[int]], header: ProfileHeader | None = None) -> MotionFile:
    """Return a file of lines, counts per pixel; more than one need a header."""
    if header is None and len(lines) != 1:
        raise UserError(f"{len(lines)} lines need a header: without one a file holds one line")
    blocks = tuple(FileBlock(tuple(values), len(values)) for values in lines)
    if header is None:
        return MotionFile(blocks)
    return MotionFile(blocks, replace(header, lines=len(lines)), BLOCKS)


def make_file(
    rows: list[int],
    header: ProfileHeader | None,
    *,
    raw: bool,
    place: RowPlace,
    findings: Findings,
) -> MotionFile | None:
    """Return the lines that rows stand for; None if they are refused. `place`: row to position."""
    if not rows:
        findings.error("no_values", *place(0), "no values")
        return None
    if header is None or raw:
        reading = RAW if header else BARE
        blocks: tuple[FileBlock, ...] = (FileBlock(tuple(rows), len(rows)),)
    else:
        reading = BLOCKS
        blocks = _blocks(rows, header, place, findings)
    if header and blocks:
        _check_haps(header, blocks, findings)
    return MotionFile(blocks, header, reading) if blocks else None


def could_be_blocks(rows: Sequence[int]) -> bool:
    """True if rows without a header begin as a numbered block of just their length would."""
    return len(rows) > 2 and rows[0] == 1 and rows[1] == len(rows) - 2


def _blocks(
    rows: list[int], header: ProfileHeader, place: RowPlace, findings: Findings
) -> tuple[FileBlock, ...]:
    """Split rows into numbered blocks; a refused one ends the reading and gives none."""
    blocks: list[FileBlock] = []
    start = 0
    while start < len(rows) and len(blocks) < header.lines:
        block = _block(rows, start, len(blocks) + 1, place, findings)
        if block is None:
            return ()
        blocks.append(block)
        start += 2 + len(block.values)
    if start < len(rows):
        _surplus(len(rows) - start, header, blocks[-1], place(start), findings)
    elif len(blocks) < header.lines:
        missing = f"truncated, {len(blocks)} of {header.lines} lines"
        tolerated = findings.rules.truncated
        findings.quirk("truncated", tolerated, header.lines_place, (missing, missing))
    return tuple(blocks)


def _or_raw(text: str) -> AskedText:
    return AskedText("{text} ({raw} takes every row as a value)", text=text)


def _block(
    rows: list[int], start: int, number: int, place: RowPlace, findings: Findings
) -> FileBlock | None:
    """Return the block that begins at a row, or None if it is refused."""
    if rows[start] != number:
        message: str = _or_raw(f"line number {rows[start]}, {number} expected")
        findings.error("line_number", *place(start), message)
        return None
    if start + 1 == len(rows):
        message = f"truncated: line number {number} without its number of values"
        findings.error("truncated", *place(start), message)
        return None
    declared = rows[start + 1]
    if declared < 1:
        message = f"number of values {declared}, at least 1 expected"
        findings.error("value_count", *place(start + 1), message)
        return None
    values = rows[start + 2 : start + 2 + declared]
    if len(values) < declared:
        text = f"truncated, {len(values)} of {declared} values"
        hint = _or_raw(f"{text} of line {number}")
        tolerated = findings.rules.truncated and bool(values)
        findings.quirk("truncated", tolerated, place(start + 1), (f"{text} of line {number}", hint))
        if not values:
            return None
    return FileBlock(tuple(values), declared)


def _surplus(
    rows_left: int,
    header: ProfileHeader,
    last: FileBlock,
    where: tuple[int, int],
    findings: Findings,
) -> None:
    """Refuse rows after the last announced line."""
    message = (
        f"{counted(rows_left, 'row')} more than the {counted(last.declared, 'value')} announced "
        f"for line {header.lines}, the last by the header"
    )
    findings.error("surplus", *where, message)


def _check_haps(header: ProfileHeader, blocks: tuple[FileBlock, ...], findings: Findings) -> None:
    """Warn if more entries are usable in homing than there are."""
    fewest = min(len(block.values) for block in blocks)
    if header.haps > fewest:
        message = f"HAPs {header.haps} are more than the {counted(fewest, 'value')} of a line"
        findings.warning("haps", *header.haps_place, message)


_WORD = re.compile(rb"[A-Za-z]{3}")


def has_header(data: bytes) -> bool:
    """True if the first record is a header line, whole or damaged: 40 columns, or words."""
    first = next(split_records(data), b"")
    return len(first) == HEADER_WIDTH or bool(_WORD.search(first))


def parse_csv(data: bytes, findings: Findings, *, raw: bool = False) -> MotionFile | None:
    """Read a CSV; the result is right only if nothing is refused."""
    check_line_ends(data, findings)
    rows = split_records(data)
    header, first, before = None, 1, len(findings.found)
    if has_header(data):
        header = parse_header(list(islice(rows, HEADER_LINES)), findings)
        first += HEADER_LINES
    values = read_numbers(rows, CSV_COLUMNS, findings, first)
    if findings.refused_since(before):
        return None

    def place(row: int) -> tuple[int, int]:
        if not values:
            return HEADER_LINES, HEADER_WIDTH + 1
        return first + row, CSV_COLUMNS.column(values[row])

    made = make_file(values, header, raw=raw, place=place, findings=findings)
    return made and replace(made, ends=find_line_ends(data))


def encode_csv(file: MotionFile, path: Path | str) -> bytes:
    """Return the bytes of a CSV. Raises UserError for a value or a header that does not fit."""
    rows = []
    if file.header:
        check_header(file.header, path)
        rows = file.header.rows
    texts = number_texts(file.rows, CSV_COLUMNS, path, len(rows) + 1)
    return join_records([*rows, *texts], file.ends)


MAGIC = b"CSB1"
_LENGTH_AT = 4
_CRC_BYTES = 4
_ROW_BYTES = 4
_TEXT_BYTES = HEADER_LINES * LINE_BYTES
_SMALLEST = -(2**31)
_LARGEST = 2**31 - 1


def parse_csb(data: bytes, findings: Findings, *, raw: bool = False) -> MotionFile | None:
    """Read a CSB; the result is right only if nothing is refused. Columns are bytes from 1."""
    length = _header_length(data, findings) if _check_frame(data, findings) else None
    if length is None:
        return None
    header, before = None, len(findings.found)
    if length:
        header = _parse_text(data[CSB_TEXT_AT : CSB_TEXT_AT + length], findings)
    if findings.refused_since(before):
        return None
    start = CSB_TEXT_AT + length
    rows = [row for (row,) in struct.iter_unpack("<i", data[start:-_CRC_BYTES])]
    return _make(rows, header, raw, start, findings)


def encode_csb(file: MotionFile, path: Path | str) -> bytes:
    """Return the bytes of a CSB. Raises UserError for a value or a header that does not fit."""
    text = b""
    if file.header:
        check_header(file.header, path)
        text = "".join(f"{row}\r\n" for row in file.header.rows).encode("ascii")
    rows = file.rows
    for number, value in enumerate(rows):
        if not _SMALLEST <= value <= _LARGEST:
            column = CSB_TEXT_AT + len(text) + _ROW_BYTES * number + 1
            raise UserError(f"{shown_path(path)}:1:{column}: value {value} does not fit 32 bits")
    body = MAGIC + struct.pack("<I", len(text)) + text + struct.pack(f"<{len(rows)}i", *rows)
    return body + struct.pack("<I", zlib.crc32(body))


def _check_frame(data: bytes, findings: Findings) -> bool:
    """Check magic, shortest length and CRC; True if they are right."""
    if not data.startswith(MAGIC):
        findings.error("magic", 1, 1, f"{shown(data[:4])} is not the magic {shown(MAGIC)}")
        return False
    if len(data) < CSB_TEXT_AT + _CRC_BYTES:
        message = f"truncated: {len(data)} bytes, a CSB has at least {CSB_TEXT_AT + _CRC_BYTES}"
        findings.error("truncated", 1, len(data) + 1, message)
        return False
    stored, crc = struct.unpack("<I", data[-_CRC_BYTES:])[0], zlib.crc32(data[:-_CRC_BYTES])
    if stored != crc:
        message = f"CRC-32 0x{stored:08X}, 0x{crc:08X} computed: the file is damaged or cut short"
        findings.error("crc", 1, len(data) - _CRC_BYTES + 1, message)
        return False
    return True


def _header_length(data: bytes, findings: Findings) -> int | None:
    """Return the length of the header text, None if it or the rest is refused."""
    length: int = struct.unpack_from("<I", data, _LENGTH_AT)[0]
    there = len(data) - CSB_TEXT_AT - _CRC_BYTES
    if length not in (0, _TEXT_BYTES):
        message = f"header text of {length} bytes, 0 or {_TEXT_BYTES} expected"
        findings.error("header_length", 1, _LENGTH_AT + 1, message)
    elif length > there:
        message = f"truncated: header text of {length} bytes announced, {there} are there"
        findings.error("truncated", 1, len(data) - _CRC_BYTES + 1, message)
    elif (there - length) % _ROW_BYTES:
        odd = there - length
        message = f"{odd} bytes of data are not a whole number of {_ROW_BYTES}-byte values"
        findings.error("truncated", 1, CSB_TEXT_AT + length + 1, message)
    else:
        return length
    return None


def _parse_text(text: bytes, findings: Findings) -> ProfileHeader | None:
    """Read the header text."""
    lines = [text[at : at + LINE_BYTES] for at in range(0, _TEXT_BYTES, LINE_BYTES)]
    placed = findings.placed(place_in_csb)
    for number, line in enumerate(lines, 1):
        if line[HEADER_WIDTH:] != b"\r\n":
            message = f"{shown(line[HEADER_WIDTH:])} after a header line, CR LF expected"
            placed.error("line_end", number, HEADER_WIDTH + 1, message)
    return parse_header([line[:HEADER_WIDTH] for line in lines], placed)


def _make(
    rows: list[int], header: ProfileHeader | None, raw: bool, start: int, findings: Findings
) -> MotionFile | None:
    """Return the lines of rows, every finding at its byte."""

    def place(line: int, column: int) -> tuple[int, int]:
        return place_in_csb(line, column) if line else (1, column)

    made = make_file(
        rows,
        header,
        raw=raw,
        place=lambda row: (0, start + _ROW_BYTES * row + 1),
        findings=findings.placed(place),
    )
    return made and replace(made, kind=CSB_KIND)
