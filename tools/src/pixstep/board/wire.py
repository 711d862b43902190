# SPDX-License-Identifier: MIT
"""One unit on the bus: the Modbus functions by what they do, errors by name."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from pixstep.board import features
from pixstep.board.errors import (
    ILLEGAL_FUNCTION,
    ExceptionReplyError,
    LineLostError,
    NoReplyError,
)
from pixstep.errors import UserError
from pixstep.lazy import lazy

if TYPE_CHECKING:
    from pixstep.board import modbus
    from pixstep.board.modbus import Client, ModbusPDU

    Request = Callable[..., ModbusPDU]  # one of the library's many
    Reply = TypeVar("Reply", bound=ModbusPDU)
else:
    modbus = lazy("pixstep.board.modbus")

BROADCAST = 0
_ID_BYTES = 2  # of the answer to function 17 before its text
COUNTERS = {  # function 08, by sub-function 11 to 18
    "bus_messages": "diag_read_bus_message_count",
    "crc_errors": "diag_read_bus_comm_error_count",
    "exceptions": "diag_read_bus_exception_error_count",
    "requests": "diag_read_device_message_count",
    "no_replies": "diag_read_device_no_response_count",
    "naks": "diag_read_device_nak_count",
    "busy_replies": "diag_read_device_busy_count",
    "rx_overruns": "diag_read_bus_char_overrun_count",
}
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
        reply = self._ask("read", self.modbus.read_input_registers, address, count=count)
        return list(reply.registers)

    def read_holdings(self, address: int, count: int) -> list[int]:
        """Return `count` (1..125) holding registers (function 03)."""
        reply = self._ask("read", self.modbus.read_holding_registers, address, count=count)
        return list(reply.registers)

    def write(self, address: int, words: list[int]) -> None:
        """Write holding registers in one all-or-nothing request (function 16)."""
        self._ask("write", self.modbus.write_registers, address, words)

    def write_one(self, address: int, word: int) -> None:
        """Write one holding register (function 06)."""
        self._ask("write", self.modbus.write_register, address, word)

    def mask_write(self, address: int, keep: int, put: int) -> None:
        """Make a holding register (old AND keep) OR (put AND NOT keep) (function 22)."""
        with self._needs("diagnosis"):
            self._ask(
                "mask write", self.modbus.mask_write_register, address=address, and_mask=keep,
                or_mask=put,
            )  # fmt: skip

    def write_and_read(
        self, write_address: int, words: list[int], address: int, count: int
    ) -> list[int]:
        """Write holding registers, then read some, in one request (function 23)."""
        with self._needs("diagnosis"):
            reply = self._ask(
                "write and read", self.modbus.readwrite_registers, read_address=address,
                read_count=count, write_address=write_address, values=words,
            )  # fmt: skip
            return list(reply.registers)

    def read_coils(self, address: int, count: int) -> list[bool]:
        """Return `count` coils (function 01)."""
        with self._needs("bits"):
            reply = self._ask("read of coils", self.modbus.read_coils, address, count=count)
            return list(reply.bits[:count])

    def read_discretes(self, address: int, count: int) -> list[bool]:
        """Return `count` discrete inputs (function 02)."""
        with self._needs("bits"):
            reply = self._ask(
                "read of inputs", self.modbus.read_discrete_inputs, address, count=count
            )
            return list(reply.bits[:count])

    def write_coil(self, address: int, value: bool) -> None:
        """Write one coil (function 05)."""
        with self._needs("bits"):
            self._ask("write of a coil", self.modbus.write_coil, address, value)

    def write_coils(self, address: int, values: list[bool]) -> None:
        """Write coils in one all-or-nothing request (function 15)."""
        with self._needs("bits"):
            self._ask("write of coils", self.modbus.write_coils, address, values)

    def identify(self) -> ServerId:
        """Return the answer to function 17, report server id."""
        with self._needs("diagnosis"):
            reply = self._ask("identify", self.modbus.report_device_id)
            data = self._of_kind(modbus.ServerIdReply, reply, "identify").identifier
            if len(data) < _ID_BYTES:
                raise NoReplyError(self.unit, "identify", heard=len(data))
            return ServerId(data[0], data[1] != 0, data[2:].decode("ascii", errors="replace"))

    def identification(self, code: int = 2) -> dict[str, str]:
        """Return the objects of function 43/14 by name; code 1 basic, 2 regular, 3 extended."""
        found: dict[int, bytes] = {}
        first = 0
        while True:
            with self._needs("diagnosis"):
                reply = self._ask(
                    "identification", self.modbus.read_device_information, read_code=code,
                    object_id=first,
                )  # fmt: skip
            part = self._of_kind(modbus.IdentificationReply, reply, "identification")
            found |= part.information
            if not part.more_follows or part.next_object_id <= first:
                break
            first = part.next_object_id
        return {_object_name(number): _text(value) for number, value in sorted(found.items())}

    def echo(self, word: int) -> int:
        """Return what comes back of a word sent by function 08, sub-function 0."""
        return self._diagnosis("echo", self.modbus.diag_query_data, word.to_bytes(2, "big"))

    def counters(self) -> dict[str, int]:
        """Return the bus's counters by name (function 08, sub-functions 11 to 18)."""
        return {
            name: self._diagnosis(f"counter {name}", getattr(self.modbus, method))
            for name, method in COUNTERS.items()
        }

    def clear_counters(self) -> None:
        """Set the bus's counters to 0 (function 08, sub-function 10)."""
        with self._needs("diagnosis"):
            self._ask("clear counters", self.modbus.diag_clear_counters)

    def listen_only(self) -> None:
        """Make the unit silent until it is restarted (function 08, sub-function 4); no reply."""
        self._send(self.modbus.diag_force_listen_only)

    def restart(self) -> None:
        """End listen-only (function 08, sub-function 1); a silent unit does not reply."""
        self._send(self.modbus.diag_restart_communication, False)

    @contextlib.contextmanager
    def once(self) -> Iterator[None]:
        """Send no request a second time, as long as this lasts."""
        transaction = self.modbus.transaction
        before, transaction.retries = transaction.retries, 0
        try:
            yield
        finally:
            transaction.retries = before

    def settle(self) -> None:
        """Wait until a request that was broken off is over on the bus."""
        self.modbus.settle()

    def broadcast(self, address: int, words: list[int]) -> None:
        """Write holding registers of every unit on the bus; nobody replies."""
        self._send(self.modbus.write_registers, address, words, unit=BROADCAST)

    def _diagnosis(self, what: str, method: Request, *arguments: object) -> int:
        """Return the data word of a diagnostic answer; the library has several shapes for it."""
        with self._needs("diagnosis"):
            reply = self._ask(what, method, *arguments)
            message = self._of_kind(modbus.DiagnosticReply, reply, what).message
            if isinstance(message, (list, tuple)):
                message = message[0] if message else None
            if isinstance(message, bytes):
                return int.from_bytes(message[:2], "big")
            if not isinstance(message, int):
                raise NoReplyError(self.unit, what, heard=self.modbus.heard)
            return message

    def _send(self, method: Request, *arguments: object, unit: int | None = None) -> None:
        """Send one request to which no reply comes, to this unit if no other is given."""
        unit = self.unit if unit is None else unit
        with self._line_kept():
            method(*arguments, device_id=unit, no_response_expected=True)

    def _ask(self, what: str, method: Request, *arguments: object, **options: object) -> ModbusPDU:
        """Do one request; raise BoardError for no reply or an exception answer."""
        try:
            with self._line_kept():
                reply = method(*arguments, device_id=self.unit, **options)
        except modbus.RequestError:
            place, heard = self.modbus.place, self.modbus.heard
            raise NoReplyError(self.unit, what, place, heard) from None
        if reply.isError():
            address = options.get("address", arguments[0] if arguments else None)
            where = f" at 0x{address:04X}" if isinstance(address, int) else ""
            raise ExceptionReplyError(
                self.unit, f"{what}{where}", getattr(reply, "exception_code", 0)
            )
        return reply

    def _of_kind(self, kind: type[Reply], reply: ModbusPDU, what: str) -> Reply:
        """Return a reply as the kind that its function has."""
        if not isinstance(reply, kind):
            raise NoReplyError(self.unit, what, heard=self.modbus.heard)
        return reply

    @contextlib.contextmanager
    def _needs(self, feature: str) -> Iterator[None]:
        """Raise MissingFeatureError for a function that the board does not serve."""
        try:
            yield
        except ExceptionReplyError as error:
            if error.code != ILLEGAL_FUNCTION:
                raise
            raise features.missing(self.unit, feature) from None

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
        except modbus.ConnectionException:
            place = self.modbus.place or "the line"
            raise LineLostError(f"board {self.unit}: {place} is gone: was it unplugged?") from None
        except UserError as error:
            raise LineLostError(f"board {self.unit}: {error}") from None


def _object_name(number: int) -> str:
    return IDENTITY_OBJECTS[number] if number < len(IDENTITY_OBJECTS) else f"object_{number}"


def _text(value: bytes | list[bytes]) -> str:
    """Return an object's text; the library gives one that was sent twice as a list."""
    data = value if isinstance(value, bytes) else b"".join(value)
    return data.decode("ascii", errors="replace")
