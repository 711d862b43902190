# SPDX-License-Identifier: MIT
"""Requests as bytes and replies as facts, without a client between the cycle and the wire."""

import struct
from dataclasses import dataclass

from pixstep.board import registers as regs
from pixstep_trials.wire import crc16, seal

UNIT, BROADCAST = 1, 0
_EXCEPTION = 0x80


@dataclass(frozen=True)
class FrameReply:
    """The reply to a request: nothing came, an exception, or the words read."""

    came: bool
    exception: int = 0
    words: tuple[int, ...] = ()

    @property
    def taken(self) -> bool:
        """True if the board did as asked."""
        return self.came and not self.exception


def read_inputs(address: int, count: int, unit: int = UNIT) -> bytes:
    """Return a request for input registers."""
    return seal(struct.pack(">BBHH", unit, 4, address, count))


def read_holdings(address: int, count: int, unit: int = UNIT) -> bytes:
    """Return a request for holding registers."""
    return seal(struct.pack(">BBHH", unit, 3, address, count))


def write(address: int, words: list[int], unit: int = UNIT) -> bytes:
    """Return a write of holding registers (function 16)."""
    data = struct.pack(f">{len(words)}H", *(word & 0xFFFF for word in words))
    return seal(struct.pack(">BBHHB", unit, 16, address, len(words), len(data)) + data)


def order(
    name: str, mask: int, argument: int | None = None, unit: int = UNIT, edge: int = 0
) -> bytes:
    """Return a command for a mask of axes; an argument or edge that is none is left out."""
    words = [mask, regs.COMMANDS[name]]
    if edge:
        words += [argument or 0, edge]
    elif argument is not None:
        words.append(argument)
    return write(regs.COMMAND_BASE, words, unit)


def block(number: int, axis: int, entries: list[tuple[int, int]], unit: int = UNIT) -> bytes:
    """Return a block of queue entries."""
    words = [number, axis]
    for entry in entries:
        words += entry
    return write(regs.QUEUE_WINDOW, words, unit)


def coils(first: int, values: list[int], unit: int = UNIT) -> bytes:
    """Return a write of one coil (function 05) or of several (function 15)."""
    if len(values) == 1:
        return seal(struct.pack(">BBHH", unit, 5, first, 0xFF00 if values[0] else 0))
    bits = sum(value << place for place, value in enumerate(values))
    size = (len(values) + 7) // 8
    head = struct.pack(">BBHHB", unit, 15, first, len(values), size)
    return seal(head + bits.to_bytes(size, "little"))


def parse(data: bytes) -> FrameReply:
    """Return the facts of a reply; what cannot be read has not come."""
    if len(data) < 5 or crc16(data):
        return FrameReply(False)
    if data[1] & _EXCEPTION:
        return FrameReply(True, exception=data[2])
    if data[1] in (3, 4):
        return FrameReply(True, words=struct.unpack(f">{data[2] // 2}H", data[3 : 3 + data[2]]))
    return FrameReply(True)
