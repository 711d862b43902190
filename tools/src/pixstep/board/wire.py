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
_READ_ID = 14  # of function 43
_FIRST_OBJECT = 6  # where the objects begin in an answer to function 43
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
