# SPDX-License-Identifier: MIT
"""What a server and its clients say to each other: one JSON object a line, docs/SERVER.md.

A client begins with HELLO, the server answers with what bus it is. Then each request has a number,
and its answer the same number; answers may come in another order.
"""

import json
from typing import Any

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
