# SPDX-License-Identifier: MIT
"""What a server and its clients say to each other: one JSON object a line, docs/SERVER.md.

A client begins with HELLO, the server answers with what bus it is. Then each request has a number,
and its answer the same number; answers may come in another order.

What a request does to a board, as far as a server must know: who may send it, and when.
"""

import json
import struct
from dataclasses import dataclass
from typing import Any

from pixstep.board import registers as regs
from pixstep.board import rtu

_READS = (
    rtu.READ_COILS, rtu.READ_DISCRETES, rtu.READ_HOLDINGS, rtu.READ_INPUTS, rtu.SERVER_ID, 20,
    rtu.IDENTIFY,
)  # fmt: skip
_DIAGNOSES_THAT_READ = (0, 2, *range(11, 19))
_COIL_ON = 0xFF00
_AXES = 4  # that have coils, and queues
_COMMAND_AT, _BLOCK_AT = (
    6,
    8,
)  # meaning_of a PDU: the words meaning_of a command; the axis meaning_of a block
_ARM, _STOP, _MARK = (regs.COMMANDS[name] for name in ("arm", "stop", "mark"))


ALL_AXES = (1 << _AXES) - 1


@dataclass(frozen=True)
class RequestMeaning:
    """What a request does; axes are masks, bit n meaning_of axis n."""

    writes: bool = True  # anything; a server gives one client at a time the right to
    stops: int = 0  # axes: it goes before all others
    drives: int = 0  # axes that it arms, or queues a part meaning_of a line for
    void_after: int = (
        ALL_AXES  # axes: a stop meaning_of one meaning_of them that comes later makes it void
    )
    marks: bool = False  # boards note its end: nothing may follow for a little


_NOTHING, _WRITES = RequestMeaning(writes=False), RequestMeaning()


def meaning_of(pdu: bytes) -> RequestMeaning:
    """Return what a request does; one that is not known counts as one that writes."""
    match pdu[0]:
        case function if function in _READS:
            return _NOTHING
        case rtu.DIAGNOSE:
            return _NOTHING if int.from_bytes(pdu[1:3]) in _DIAGNOSES_THAT_READ else _WRITES
        case rtu.WRITE:
            return _of_write(pdu)
        case rtu.WRITE_COIL if len(pdu) == struct.calcsize(">BHH"):
            coil, value = struct.unpack(">HH", pdu[1:])
            return _of_coil(coil) if value == _COIL_ON else _WRITES
        case _:
            return _WRITES


def _of_write(pdu: bytes) -> RequestMeaning:
    """Return what a write meaning_of holding registers does."""
    address = int.from_bytes(pdu[1:3])
    if address == regs.COMMAND_BASE and len(pdu) >= _COMMAND_AT + 4:
        mask, command = struct.unpack_from(">HH", pdu, _COMMAND_AT)
        if command == _STOP:
            return RequestMeaning(stops=mask)
        if command == _ARM:
            return _driving(mask)
        return RequestMeaning(marks=command == _MARK)
    if address == regs.QUEUE_WINDOW and len(pdu) >= _BLOCK_AT + 2:
        axis = int.from_bytes(pdu[_BLOCK_AT : _BLOCK_AT + 2]) & 0xFF
        return _driving(1 << axis & ALL_AXES)
    return RequestMeaning(void_after=0) if address < regs.COMMAND_BASE else _WRITES


def _driving(axes: int) -> RequestMeaning:
    return RequestMeaning(drives=axes, void_after=axes)


def _of_coil(coil: int) -> RequestMeaning:
    """Return what it does to switch a coil on."""
    if regs.COIL_ARMED <= coil < regs.COIL_ARMED + _AXES:
        return _driving(1 << coil - regs.COIL_ARMED)
    if regs.COIL_STOP <= coil < regs.COIL_STOP + _AXES:
        return RequestMeaning(stops=1 << coil - regs.COIL_STOP)
    return _WRITES


VERSION = 1
MOST_BYTES = 4096  # of a line

# What a request may do.
ASK, TELL, FOLLOW, RECONFIGURE, STATUS, BYE = (
    "ask", "tell", "follow", "reconfigure", "status", "bye",
)  # fmt: skip

# What may be wrong with it.
NO_REPLY = "no_reply"  # of the board; `heard` bytes came
LINE_GONE, WRITE_TIMEOUT, PORT = "line_gone", "write_timeout", "port"  # of the serial port
TAKEN = "taken"  # somebody else writes
OVERTAKEN = "overtaken"  # a stop went first, and the request was not sent
MISTAKE = "mistake"  # of the client: the request is not of this protocol

Message = dict[str, Any]


class MessageError(Exception):
    """A line is no message, or a message has not what it should have; the text says what."""


def encode(message: Message) -> bytes:
    """Return a message as its line."""
    return json.dumps(message, separators=(",", ":")).encode() + b"\n"


def decode(line: bytes) -> Message:
    """Return the message of a line; raises MessageError."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        raise MessageError("not a line of JSON") from None
    if not isinstance(found, dict):
        raise MessageError("not a JSON object")
    return found


def whole(message: Message, key: str, low: int, high: int) -> int:
    """Return a whole number of a message; raises MessageError if it is not within its range."""
    value = message.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise MessageError(f"{key}: a whole number from {low} to {high} is wanted")
    return value


def seconds(message: Message, key: str, low: float, high: float) -> float:
    """Return a time of a message; raises MessageError if it is not within its range."""
    value = message.get(key)
    if not isinstance(value, (int, float)) or not low <= value <= high:
        raise MessageError(f"{key}: a number of seconds from {low} to {high} is wanted")
    return float(value)


def text(message: Message, key: str) -> str:
    """Return a text of a message; raises MessageError if there is none."""
    value = message.get(key)
    if not isinstance(value, str):
        raise MessageError(f"{key}: a text is wanted")
    return value


def pdu(message: Message) -> bytes:
    """Return the bytes of a request; raises MessageError for none, and for more than Modbus has."""
    try:
        found = bytes.fromhex(text(message, "pdu"))
    except ValueError:
        found = b""
    if not 1 <= len(found) <= _MOST_PDU:
        raise MessageError(f"pdu: 1 to {_MOST_PDU} bytes in hexadecimal digits are wanted")
    return found


_MOST_PDU = 253
