# SPDX-License-Identifier: MIT
"""Modbus RTU frames as bytes: checksum, sealing, and what a request would do to a board.

Written for generators of bad frames, which a client library does not make.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass

from pixstep.board import registers as regs

FRAME_MAX = 256  # bytes, address and checksum included
FRAME_MIN = 4
READS = frozenset({1, 2, 3, 4, 7, 11, 12, 17, 20, 24, 43})
# Of function 08: loopback, register, clear counters, counters. 1 restarts, 4 silences the board.
_DIAGNOSTICS = frozenset({0, 2, 10, *range(11, 21)})
_COMMAND_LAST = max(regs.COMMANDS.values())
_MARK = regs.COMMANDS["mark"]  # the board notes the time: nothing moves
_COMMAND_END = regs.register_map().holding("edge").address + 1
SETTINGS_END = regs.settings()[-1].address + regs.settings()[-1].words
_WRITE_FORMS = {5: 8, 6: 8, 22: 10}


def _crc_table() -> list[int]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
        table.append(value)
    return table


_TABLE = _crc_table()


def crc16(data: bytes, crc: int = 0xFFFF) -> int:
    """Return the checksum of Modbus RTU; 0 for bytes that end with their own."""
    for byte in data:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc


def seal(body: bytes) -> bytes:
    """Return address and PDU with their checksum, low byte first."""
    return body + struct.pack("<H", crc16(body))


def frames_in(data: bytes) -> list[bytes]:
    """Return every beginning of `data` that has a frame's length and a right checksum."""
    found, crc = [], 0xFFFF
    for length, byte in enumerate(data[:FRAME_MAX], 1):
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
        if crc == 0 and length >= FRAME_MIN:
            found.append(data[:length])
    return found


@dataclass(frozen=True)
class Safety:
    """Tells requests that cannot touch the motion of a board with lines queued from others.

    `next_block(axis)` is the block number that the board takes next.
    """

    axes: int
    next_block: Callable[[int], int]

    def harmless(self, frame: bytes) -> bool:
        """True if a whole frame is a read, or a write that the board must refuse or ignore."""
        function = frame[1]
        if function in READS:
            return True
        if function == 8:
            return len(frame) < 6 or struct.unpack(">H", frame[2:4])[0] in _DIAGNOSTICS
        if function in (5, 15):
            return not _bits_formed(frame) or _word(frame, 2) >= 16
        if function in (6, 16, 22, 23):
            return self._write_harmless(function, frame)
        return True  # nobody serves it

    def _write_harmless(self, function: int, frame: bytes) -> bool:
        """True if a register write is malformed, or its range or value is refused."""
        if not _words_formed(function, frame):
            return True
        address, words = _written(function, frame)
        if address == regs.QUEUE_WINDOW:
            return function == 16 and self._block_harmless(words)
        if not mapped(address, len(words)):
            return True
        if address + len(words) <= regs.COMMAND_BASE:
            return True  # a setting: refused while lines are queued
        if function in (22, 23):
            return False  # depends on what is there
        command = regs.COMMAND_BASE + 1 - address
        if not 0 <= command < len(words):
            return False
        return words[command] > _COMMAND_LAST or words[command] == _MARK

    def _block_harmless(self, words: list[int]) -> bool:
        """True if the queue window refuses or drops the block."""
        if len(words) < 4 or len(words) % 2 or words[1] >= self.axes:
            return True
        return words[0] != self.next_block(words[1])


def mapped(address: int, count: int) -> bool:
    """True if all of these holding registers are there, the queue window apart."""
    end = address + count
    commands = address >= regs.COMMAND_BASE and end <= _COMMAND_END
    return end <= SETTINGS_END or commands


def _word(frame: bytes, at: int) -> int:
    return int.from_bytes(frame[at : at + 2], "big")


def _bits_formed(frame: bytes) -> bool:
    """True if a write of coils has the length that its function wants."""
    if frame[1] == 5:
        return len(frame) == _WRITE_FORMS[5]
    return len(frame) >= 10 and len(frame) == 9 + frame[6]


def _words_formed(function: int, frame: bytes) -> bool:
    """True if a write of registers has lengths and counts that agree."""
    if function in _WRITE_FORMS:
        return len(frame) == _WRITE_FORMS[function]
    head = 9 if function == 16 else 13
    if len(frame) <= head:
        return False
    count, size = _word(frame, head - 5), frame[head - 3]
    return count > 0 and size == 2 * count and len(frame) == head + size


def _written(function: int, frame: bytes) -> tuple[int, list[int]]:
    """Return address and words of a well-formed register write (of 22: its two masks)."""
    if function == 6:
        return _word(frame, 2), [_word(frame, 4)]
    if function == 22:
        return _word(frame, 2), [0]
    head = 7 if function == 16 else 11
    words = [_word(frame, at) for at in range(head, len(frame) - 2, 2)]
    return _word(frame, 2 if function == 16 else 6), words
