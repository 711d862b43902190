# SPDX-License-Identifier: MIT
"""One unit on the bus: the Modbus functions by what they do, errors by name."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pixstep.board import boards, modbus, rtu
from pixstep.board.errors import (
    ILLEGAL_FUNCTION,
    BusTakenError,
    ExceptionReplyError,
    LineLostError,
    NoReplyError,
)
from pixstep.errors import UserError

if TYPE_CHECKING:
    from pixstep.board.modbus import Client

BROADCAST = 0
_ID_BYTES = 2  # of the answer to function 17 before its text
COUNTERS = {  # function 08: name and sub-function
    "bus_messages": 11,
    "crc_errors": 12,
    "exceptions": 13,
    "requests": 14,
    "no_replies": 15,
    "naks": 16,
    "busy_replies": 17,
    "rx_overruns": 18,
}
_RESTART, _LISTEN_ONLY, _CLEAR_COUNTERS = 1, 4, 10  # sub-functions
_READ_ID = 14  # of function 43
_FIRST_OBJECT = 6  # where the objects begin in an answer to function 43
_COIL_ON = 0xFF00
_ADDRESSED = frozenset({
    rtu.READ_COILS, rtu.READ_DISCRETES, rtu.READ_HOLDINGS, rtu.READ_INPUTS, rtu.WRITE_COIL,
    rtu.WRITE_ONE, rtu.WRITE_COILS, rtu.WRITE, rtu.MASK_WRITE, rtu.WRITE_AND_READ,
})  # fmt: skip
IDENTITY_OBJECTS = (
    "vendor",
    "product_code",
    "revision",
    "vendor_url",
    "product_name",
    "model_name",
    "application",
)


@dataclass(frozen=True)
class ServerId:
    """The answer to function 17: board id, whether any axis runs, "pixstep BOARD VERSION"."""

    id: int
    running: bool
    text: str


class Wire:
    """The requests that one unit answers; every method raises BoardError if it does not."""

    def __init__(self, modbus: Client, unit: int = 1) -> None:
        self.modbus = modbus
        self.unit = unit

    def read_inputs(self, address: int, count: int) -> list[int]:
        """Return `count` (1..125) input registers (function 04)."""
        return _words(self._ask("read", rtu.READ_INPUTS, ">HH", address, count))

    def read_holdings(self, address: int, count: int) -> list[int]:
        """Return `count` (1..125) holding registers (function 03)."""
        return _words(self._ask("read", rtu.READ_HOLDINGS, ">HH", address, count))

    def write(self, address: int, words: list[int], *, urgent: bool = False) -> None:
        """Write holding registers in one all-or-nothing request (function 16)."""
        form = f">HHB{len(words)}H"
        head = (address, len(words), 2 * len(words))
        self._ask("write", rtu.WRITE, form, *head, *words, urgent=urgent)

    def write_one(self, address: int, word: int) -> None:
        """Write one holding register (function 06)."""
        self._ask("write", rtu.WRITE_ONE, ">HH", address, word)

    def mask_write(self, address: int, keep: int, put: int) -> None:
        """Make a holding register (old AND keep) OR (put AND NOT keep) (function 22)."""
        with self._needs("diagnosis"):
            self._ask("mask write", rtu.MASK_WRITE, ">HHH", address, keep, put)

    def write_and_read(
        self, write_address: int, words: list[int], address: int, count: int
    ) -> list[int]:
        """Write holding registers, then read some, in one request (function 23)."""
        form = f">HHHHB{len(words)}H"
        head = (address, count, write_address, len(words), 2 * len(words))
        with self._needs("diagnosis"):
            return _words(self._ask("write and read", rtu.WRITE_AND_READ, form, *head, *words))

    def read_coils(self, address: int, count: int) -> list[bool]:
        """Return `count` coils (function 01)."""
        with self._needs("bits"):
            data = self._ask("read of coils", rtu.READ_COILS, ">HH", address, count)
            return _bits(data, count)

    def read_discretes(self, address: int, count: int) -> list[bool]:
        """Return `count` discrete inputs (function 02)."""
        with self._needs("bits"):
            data = self._ask("read of inputs", rtu.READ_DISCRETES, ">HH", address, count)
            return _bits(data, count)

    def write_coil(self, address: int, value: bool) -> None:
        """Write one coil (function 05)."""
        with self._needs("bits"):
            word = _COIL_ON if value else 0
            self._ask("write of a coil", rtu.WRITE_COIL, ">HH", address, word)

    def write_coils(self, address: int, values: list[bool]) -> None:
        """Write coils in one all-or-nothing request (function 15)."""
        size = (len(values) + 7) // 8
        packed = sum(value << index for index, value in enumerate(values)).to_bytes(size, "little")
        with self._needs("bits"):
            form = f">HHB{size}s"
            self._ask("write of coils", rtu.WRITE_COILS, form, address, len(values), size, packed)

    def identify(self) -> ServerId:
        """Return the answer to function 17, report server id."""
        with self._needs("diagnosis"):
            data = self._ask("identify", rtu.SERVER_ID, "")[1:]
            if len(data) < _ID_BYTES:
                raise NoReplyError(self.unit, "identify", heard=len(data))
            return ServerId(data[0], data[1] != 0, data[2:].decode("ascii", errors="replace"))

    def identification(self, code: int = 2) -> dict[str, str]:
        """Return the objects of function 43/14 by name; code 1 basic, 2 regular, 3 extended."""
        found: dict[int, bytes] = {}
        first = 0
        while True:
            with self._needs("diagnosis"):
                data = self._ask("identification", rtu.IDENTIFY, ">BBB", _READ_ID, code, first)
            more, following = data[3], data[4]
            found |= _objects(data)
            if not more or following <= first:
                break
            first = following
        return {
            _object_name(number): value.decode("ascii", errors="replace")
            for number, value in sorted(found.items())
        }

    def echo(self, word: int) -> int:
        """Return what comes back of a word sent by function 08, sub-function 0."""
        return self._diagnosis("echo", 0, word)

    def counters(self) -> dict[str, int]:
        """Return the bus's counters by name (function 08, sub-functions 11 to 18)."""
        return {
            name: self._diagnosis(f"counter {name}", number) for name, number in COUNTERS.items()
        }

    def clear_counters(self) -> None:
        """Set the bus's counters to 0 (function 08, sub-function 10)."""
        self._diagnosis("clear counters", _CLEAR_COUNTERS)

    def listen_only(self) -> None:
        """Make the unit silent until it is restarted (function 08, sub-function 4); no reply."""
        self._tell(self.unit, rtu.DIAGNOSE, ">HH", _LISTEN_ONLY, 0)

    def restart(self) -> None:
        """End listen-only (function 08, sub-function 1); a silent unit does not reply."""
        self._tell(self.unit, rtu.DIAGNOSE, ">HH", _RESTART, 0)

    @contextlib.contextmanager
    def once(self, *, urgent: bool = False) -> Iterator[None]:
        """Send no request a second time, as long as this lasts; other threads wait meanwhile.

        An urgent one has its turn before all that wait.
        """
        with self.modbus.turns.taken(urgent=urgent), self.modbus.patient(retries=0):
            yield

    def settle(self) -> None:
        """Wait until a request that was broken off is over on the bus."""
        with self.modbus.turns.taken(urgent=True):
            self.modbus.settle()

    def broadcast(self, address: int, words: list[int]) -> None:
        """Write holding registers of every unit on the bus; nobody replies."""
        head = (address, len(words), 2 * len(words))
        self._tell(BROADCAST, rtu.WRITE, f">HHB{len(words)}H", *head, *words)

    def _diagnosis(self, what: str, sub: int, word: int = 0) -> int:
        """Return the data word of a diagnostic answer (function 08)."""
        with self._needs("diagnosis"):
            data = self._ask(what, rtu.DIAGNOSE, ">HH", sub, word)
            return int.from_bytes(data[2:4])

    def _tell(self, unit: int, function: int, form: str, *data: int) -> None:
        """Send one request to which no reply comes."""
        with self.modbus.turns, self._line_kept():
            self.modbus.tell(bytes([function]) + struct.pack(form, *data), unit)

    def _ask(
        self, what: str, function: int, form: str, *data: int | bytes, urgent: bool = False
    ) -> bytes:
        """Do one request and return what its reply carries.

        Raises BoardError for no reply or an exception answer.
        """
        pdu = bytes([function]) + struct.pack(form, *data)
        with self.modbus.turns.taken(urgent=urgent):
            try:
                with self._line_kept():
                    reply = self.modbus.ask(self.unit, pdu, urgent=urgent)
            except modbus.RequestError:
                place, heard = self.modbus.place, self.modbus.heard
                raise NoReplyError(self.unit, what, place, heard) from None
        if reply.exception is not None:
            where = f" at 0x{pdu[1:3].hex().upper()}" if function in _ADDRESSED else ""
            raise ExceptionReplyError(self.unit, f"{what}{where}", reply.exception)
        return reply.pdu[1:]

    @contextlib.contextmanager
    def _needs(self, feature: str) -> Iterator[None]:
        """Raise MissingFeatureError for a function that the board does not serve."""
        try:
            yield
        except ExceptionReplyError as error:
            if error.code != ILLEGAL_FUNCTION:
                raise
            raise boards.missing_feature(self.unit, feature) from None

    @contextlib.contextmanager
    def _line_kept(self) -> Iterator[None]:
        """Raise LineLostError if the port goes away in a request, or did before and still is."""
        try:
            yield
        except modbus.WriteTimeoutError:
            place = self.modbus.place or "the line"
            raise LineLostError(
                f"board {self.unit}: {place} takes no bytes: nobody reads at its other end, or "
                f"this program was stopped for a while"
            ) from None
        except modbus.LineGoneError:
            place = self.modbus.place or "the line"
            raise LineLostError(f"board {self.unit}: {place} is gone: was it unplugged?") from None
        except BusTakenError:
            raise
        except UserError as error:
            raise LineLostError(f"board {self.unit}: {error}") from None


def _object_name(number: int) -> str:
    return IDENTITY_OBJECTS[number] if number < len(IDENTITY_OBJECTS) else f"object_{number}"


def _objects(data: bytes) -> dict[int, bytes]:
    """Return the objects that an answer to function 43 carries, by number."""
    found, at = {}, _FIRST_OBJECT
    for _ in range(data[_FIRST_OBJECT - 1]):
        number, size = data[at : at + 2]
        found[number] = data[at + 2 : at + 2 + size]
        at += 2 + size
    return found


def _words(data: bytes) -> list[int]:
    """Return the registers behind a byte count."""
    return list(struct.unpack(f">{len(data) // 2}H", data[1:]))


def _bits(data: bytes, count: int) -> list[bool]:
    """Return the bits behind a byte count."""
    return [bool(data[1 + index // 8] >> index % 8 & 1) for index in range(count)]
