# SPDX-License-Identifier: MIT
"""CSB: the binary twin of a CSV, by a layout of our own.

```
 offset    bytes  what
 0         4      "CSB1"
 4         4      h, uint32: length of the header text, 168 or 0
 8         h      the four lines of a CSV header, 40 characters and CR LF each
 8 + h     4 n    n rows of the data, int32 each: what the CSV has a record each for
 8 + h+4n  4      CRC-32 (as in zip) of all bytes before it, uint32
```

All numbers are little-endian. n follows from the length of the file.
"""

import struct
import zlib
from dataclasses import replace
from pathlib import Path

from pixstep.errors import UserError
from pixstep.formats.findings import Findings, shown, shown_path
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
from pixstep.formats.motion import CSB_KIND, MotionFile, make_file

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
        message = f"{there - length} bytes of data are no whole number of {_ROW_BYTES}-byte values"
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
