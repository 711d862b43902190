# SPDX-License-Identifier: MIT
"""Queue entries packed into 1 to 4 bytes each, as firmware/core/motion/segment_pack.h has them.

A single pixel whose count is near that of the entry before takes one byte.
"""

from collections.abc import Iterable

MOST = 4  # bytes of the longest entry
_NEAR = 56  # one byte: differences of -56..56, the byte of 0
_NEAR_LAST = 0x70
_SHORT_RUN, _SHORT_MOST = 0x6F, 7  # two bytes: repeat 2..7
_RUN = 0x77  # three bytes: repeat 0..255
_WIDE, _WIDE_ZERO = 0x400, 0x7C00  # two bytes: differences of -1024..1023
_FULL = 0x80
_FURTHEST = 0x4000  # 15 bits, signed: -16384..16383
_BYTE, _SHORT, _WORD = 0xFF, 0x80, 0xFFFF


def pack(entry: tuple[int, int], last: int | None = None) -> tuple[bytes, int]:
    """Return an entry's bytes, and the count that the next entry's difference goes from.

    `last` is that count of the entry before; without it the entry is in full, as the first ones of
    a line have to be. A pixel's count that 15 bits do not hold becomes the lowest that they do,
    which every board refuses as out of range too.
    """
    count, repeat = signed(entry[0], 15), entry[1]
    if last is not None:
        count = entry[0] if -_FURTHEST <= entry[0] < _FURTHEST else -_FURTHEST
        change = signed(count - last, 16)
        if repeat == 1 and -_NEAR <= change <= _NEAR:
            return bytes([change + _NEAR]), count
        if repeat == 1 and -_WIDE <= change < _WIDE:
            return (_WIDE_ZERO + change).to_bytes(2), count
        if 2 <= repeat <= _BYTE and -_SHORT <= change < _SHORT:
            return _packed_run(change & _BYTE, repeat), count
    return (count & _WORD | _FULL << 8).to_bytes(2) + repeat.to_bytes(2), count


def unpack(data: bytes, last: int = 0) -> list[tuple[int, int]]:
    """Return the entries of packed bytes; raises ValueError if they end inside one."""
    entries = []
    at = 0
    while at < len(data):
        first = data[at]
        more = data[at + 1 : at + size(first)]
        if len(more) != size(first) - 1:
            raise ValueError("the bytes end inside an entry")
        last, repeat = _entry(first, more, last)
        entries.append((last, repeat))
        at += size(first)
    return entries


def size(first: int) -> int:
    """Return how many bytes the entry with this first byte has."""
    if first <= _NEAR_LAST:
        return 1
    if first >= _FULL:
        return MOST
    return 3 if first == _RUN else 2


def packed_size(entries: Iterable[tuple[int, int]]) -> int:
    """Return how many bytes entries take behind each other, the first two in full."""
    total, last = 0, None
    for index, entry in enumerate(entries):
        data, last = pack(entry, last if index >= 2 else None)
        total += len(data)
    return total


def signed(value: int, bits: int) -> int:
    """Return the lowest bits of a number, the highest of them as its sign."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half


def _packed_run(change: int, repeat: int) -> bytes:
    if repeat <= _SHORT_MOST:
        return bytes([_SHORT_RUN + repeat, change])
    return bytes([_RUN, change, repeat])


def _entry(first: int, more: bytes, last: int) -> tuple[int, int]:
    """Return count and repeat of the entry with these bytes."""
    if first <= _NEAR_LAST:
        return signed(last + first - _NEAR, 16), 1
    word = first << 8 | more[0]
    if first >= _FULL:
        return signed(word, 15), int.from_bytes(more[1:])
    if first > _RUN:
        return signed(last + word - _WIDE_ZERO, 16), 1
    repeat = more[1] if first == _RUN else first - _SHORT_RUN
    return signed(last + signed(more[0], 8), 16), repeat
