# SPDX-License-Identifier: MIT
"""Modbus RTU frames: checksums, requests, and which bytes are the reply to a request."""

from __future__ import annotations

import struct
from dataclasses import dataclass

READ_COILS, READ_DISCRETES, READ_HOLDINGS, READ_INPUTS = 1, 2, 3, 4
WRITE_COIL, WRITE_ONE, DIAGNOSE, WRITE_COILS, WRITE = 5, 6, 8, 15, 16
SERVER_ID, MASK_WRITE, WRITE_AND_READ, IDENTIFY = 17, 22, 23, 43
EXCEPTION = 0x80  # bit of the function code of a reply that is an exception
_EXCEPTION_BYTES, _DIAGNOSIS_BYTES = 5, 8  # of frames
_SUB_FUNCTION_END = 3  # of a PDU of function 8
_OBJECTS_AT = 8  # of a frame of function 43: the first object
_ECHOES = {WRITE_COIL: 5, WRITE_ONE: 5, WRITE_COILS: 5, WRITE: 5, MASK_WRITE: 7}  # bytes of a PDU


def _crc_table() -> tuple[int, ...]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
        table.append(value)
    return tuple(table)


_TABLE = _crc_table()


def crc16(data: bytes) -> int:
    """Return the checksum of Modbus RTU; 0 for bytes that end with their own."""
    crc = 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc


def seal(body: bytes) -> bytes:
    """Return address and PDU with their checksum, low byte first."""
    return body + struct.pack("<H", crc16(body))


@dataclass(frozen=True)
class Reply:
    """The PDU of a reply, and where its frame ends in the bytes that were heard."""

    pdu: bytes
    end: int

    @property
    def exception(self) -> int | None:
        """The code of an exception; None of any other reply."""
        return self.pdu[1] if self.pdu[0] & EXCEPTION else None


@dataclass(frozen=True)
class RtuRequest:
    """A request to one unit: the PDU is the function code and its data."""

    unit: int
    pdu: bytes

    @property
    def function(self) -> int:
        """The function code."""
        return self.pdu[0]

    @property
    def frame(self) -> bytes:
        """The bytes on the line."""
        return seal(bytes([self.unit]) + self.pdu)

    @property
    def shape(self) -> bytes:
        """What every reply to this request begins with: others may have the same."""
        if self.function in _ECHOES:
            return self.pdu[: _ECHOES[self.function]]
        if self.function == DIAGNOSE:
            return self.pdu[:_SUB_FUNCTION_END]
        size = _bytes_read(self.pdu)
        return self.pdu[:1] if size is None else bytes([self.function, size])

    def reply(self, heard: bytes) -> Reply | None:
        """Return the first whole reply in the bytes heard, whatever comes before it.

        A frame counts if unit, function and what it says of itself fit this request, and if its
        checksum is right.
        """
        for at in range(len(heard) - _EXCEPTION_BYTES + 1):
            size = self._size(heard, at) if heard[at] == self.unit else 0
            end = at + size
            if size and end <= len(heard) and crc16(heard[at:end]) == 0:
                return Reply(heard[at + 1 : end - 2], end)
        return None

    def _size(self, heard: bytes, at: int) -> int:
        """Return the bytes of the reply that may begin at a place; 0 if none does."""
        if heard[at + 1] == self.function | EXCEPTION:
            return _EXCEPTION_BYTES
        if not heard.startswith(self.shape, at + 1):
            return 0
        match self.function:
            case 8:
                return _DIAGNOSIS_BYTES
            case 43:
                return _identification_size(heard, at)
            case function:
                return _ECHOES[function] + 3 if function in _ECHOES else heard[at + 2] + 5


def frame_in(heard: bytes) -> bool:
    """True if there is a reply of any unit among bytes that nobody waits for."""
    for at in range(len(heard) - _EXCEPTION_BYTES + 1):
        end = at + _reply_size(heard, at)
        if end <= len(heard) and crc16(heard[at:end]) == 0:
            return True
    return False


def _reply_size(heard: bytes, at: int) -> int:
    """Return the bytes of the reply, of whatever unit, that may begin at a place."""
    function = heard[at + 1]
    if function & EXCEPTION:
        return _EXCEPTION_BYTES
    if function in _ECHOES:
        return _ECHOES[function] + 3
    if function == DIAGNOSE:
        return _DIAGNOSIS_BYTES
    if function == IDENTIFY:
        return _identification_size(heard, at)
    return heard[at + 2] + 5


def _bytes_read(pdu: bytes) -> int | None:
    """Return the bytes that a reply carries, as its byte count says; None if it may be any."""
    if pdu[0] not in (READ_COILS, READ_DISCRETES, READ_HOLDINGS, READ_INPUTS, WRITE_AND_READ):
        return None
    (count,) = struct.unpack_from(">H", pdu, 3)
    size: int = (count + 7) // 8 if pdu[0] in (READ_COILS, READ_DISCRETES) else 2 * count
    return size & 0xFF


def _identification_size(heard: bytes, at: int) -> int:
    """Return the bytes of a frame of function 43 as far as it is there; else more than there are.

    Its objects each say how long they are.
    """
    more = len(heard) - at + 1
    if len(heard) < at + _OBJECTS_AT:
        return more
    place = at + _OBJECTS_AT
    for _ in range(heard[place - 1]):
        if len(heard) < place + 2:
            return more
        place += 2 + heard[place + 1]
    return place + 2 - at
