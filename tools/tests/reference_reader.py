# SPDX-License-Identifier: MIT
"""A second, simple reader of every format: whole files by regular expressions, no messages.

It shares no code with pixstep.formats and says only what a file holds, or None.
"""

import re
from dataclasses import dataclass

_DAY = rb"(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun)"
_MONTH = rb"(?:Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)"
_CTIME = rb"%b %b (?: [1-9]|[123]\d) [012]\d:[0-5]\d:[0-6]\d \d{4}" % (_DAY, _MONTH)
_NAME = rb"(?: {20}|[ -~]{19}[!-~])"
_COUNT = rb" *(?:0|[1-9]\d*)"
_END = {False: rb"\r\n", True: rb"\r?\n"}
_LAST = {False: rb"\r\n", True: rb"(?:\r?\n|\r|\Z)"}


@dataclass(frozen=True)
class Content:
    """What a file holds: kind, the four header lines or none, (announced, values) of each line."""

    kind: str
    header: tuple[bytes, ...]
    lines: tuple[tuple[int, tuple[int, ...]], ...]


def read(data: bytes, *, lenient: bool = False, raw: bool = False) -> Content | None:
    """Return what a PRN, CSV or CSB holds; None if it must be refused."""
    if data.startswith(b"CSB1"):
        return _csb(data, lenient, raw)
    values = _rows(rb"(?=[ 0-9]{8}\r?(?:\n|\Z))" + _COUNT, data, lenient)
    if values:
        return Content("prn", (), ((len(values), tuple(values)),))
    text = re.match(_header(_END[lenient]), data)
    values = _csv_rows(data[text.end() if text else 0 :], lenient)
    return _lines("csv", text.groups() if text else (), values, lenient, raw)


def _header(end: bytes) -> bytes:
    """A pattern of the four lines; a group each."""
    third = rb"Lines:%b   HAPs:%b    LeadIn:%b" % tuple(map(_right_aligned, (5, 4, 6)))
    return end.join([
        rb"( {16}" + _CTIME + rb")",
        rb"(ACCELERATION PROFILE" + _NAME + rb")",
        rb"(" + third + rb")",
        rb"(Pixel Frequency(?=[ 0-9.]{25}\r?\n) *\d+(?:\.\d+)?)",
        b"",
    ])  # fmt: skip


def _right_aligned(width: int) -> bytes:
    """A pattern of unsigned numbers: so many blanks, then so many digits."""
    long = [rb" {%d}[1-9]\d{%d}" % (width - digits, digits - 1) for digits in range(2, width + 1)]
    return rb"(?: {%d}\d|%b)" % (width - 1, b"|".join(long))


def _csv_rows(data: bytes, lenient: bool) -> list[int] | None:
    return _rows(rb"(?=[- 0-9]{6}\r?(?:\n|\Z)) *(?:0|-?[1-9]\d*)", data, lenient)


def _rows(record: bytes, data: bytes, lenient: bool) -> list[int] | None:
    """Return the numbers if all of the data are such records."""
    whole = rb"(?:%b%b)*%b%b" % (record, _END[lenient], record, _LAST[lenient])
    if not re.fullmatch(whole, data):
        return None
    return [int(text) for text in re.findall(rb"-?\d+", data)]


def _lines(
    kind: str, header: tuple[bytes, ...], rows: list[int] | None, lenient: bool, raw: bool
) -> Content | None:
    """Give rows to lines: a queue of rows, taken from the front."""
    if not rows:
        return None
    if not header or raw:
        good = not header or (_announced_lines(header) > 0 and _above_zero(header))
        return Content(kind, header, ((len(rows), tuple(rows)),)) if good else None
    lines, rest = [], list(reversed(rows))
    while rest:
        if rest.pop() != len(lines) + 1 or not rest or rest[-1] < 1:
            return None
        announced = rest.pop()
        values = tuple(rest.pop() for _ in range(min(announced, len(rest))))
        if not values or (len(values) < announced and not lenient):
            return None
        lines.append((announced, values))
    wanted = _announced_lines(header)
    good = len(lines) == wanted or (lenient and len(lines) < wanted)
    return Content(kind, header, tuple(lines)) if good and _above_zero(header) else None


def _announced_lines(header: tuple[bytes, ...]) -> int:
    return int(header[2][6:11])


def _above_zero(header: tuple[bytes, ...]) -> bool:
    return bool(re.search(rb"[1-9]", header[3]))


def _csb(data: bytes, lenient: bool, raw: bool) -> Content | None:
    if len(data) < 12 or int.from_bytes(data[-4:], "little") != crc32(data[:-4]):
        return None
    length = int.from_bytes(data[4:8], "little")
    body = data[8 + length : -4]
    if length not in (0, 168) or len(data) < 12 + length or len(body) % 4:
        return None
    rows = [
        int.from_bytes(body[at : at + 4], "little", signed=True) for at in range(0, len(body), 4)
    ]
    text = re.fullmatch(_header(rb"\r\n"), data[8 : 8 + length]) if length else None
    if length and not text:
        return None
    return _lines("csb", text.groups() if text else (), rows, lenient, raw)


def crc32(data: bytes) -> int:
    """CRC-32 as in zip, bit by bit: polynomial 0xEDB88320, reflected."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ _CRC_OF_BYTE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def _crc_of_byte(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (0xEDB88320 if byte & 1 else 0)
    return byte


_CRC_OF_BYTE = [_crc_of_byte(byte) for byte in range(256)]
