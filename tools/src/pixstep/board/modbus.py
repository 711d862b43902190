# SPDX-License-Identifier: MIT
"""The Modbus library's client for a bus with boards: on a serial port, or the simulator's pipe.

The library takes long to load: other modules have this one by `lazy`.
"""

import contextlib
import logging
import time
from typing import Any, Protocol

from pymodbus.client import ModbusSerialClient
from pymodbus.exceptions import ConnectionException, ModbusException, ModbusIOException
from pymodbus.pdu import ModbusPDU
from pymodbus.pdu.diag_message import DiagnosticBase as DiagnosticReply
from pymodbus.pdu.mei_message import ReadDeviceInformationResponse as IdentificationReply
from pymodbus.pdu.other_message import ReportDeviceIdResponse

from pixstep.board.port import (
    BAUD,
    NO_PARITY,
    PARITY,
    RETRIES,
    TIMEOUT_S,
    TROUBLE,
    Port,
    is_pty,
)

REPLY_S = 0.025  # how long a simulated master waits for the first byte
__all__ = [
    "Client",
    "ConnectionException",
    "DiagnosticReply",
    "IdentificationReply",
    "ModbusPDU",
    "Pipe",
    "RequestError",
    "SerialClient",
    "ServerIdReply",
    "SimClient",
    "WriteTimeoutError",
]
RequestError = ModbusException  # a request has failed, whatever the reason
_QUIET_S = 0.03  # without a byte: the reply on its way has ended
_QUIET_LIMIT_S = 0.3


class Client(ModbusSerialClient):
    """pymodbus' client that takes a reply only if it can be the reply to its request.

    The library takes any frame of the unit: a late reply to an earlier request too. `heard` is how
    many bytes came back since the last request, `place` the bus's name for messages.
    """

    heard = 0
    place = ""

    def __init__(self, port: str, **options: Any) -> None:
        super().__init__(port, **options)
        self.register(ServerIdReply)
        _quieten(logging.getLogger("pymodbus"))

    @property
    def patience(self) -> tuple[float, int]:
        """How long a reply may take, seconds, and how often a request without one is repeated."""
        return self.comm_params.timeout_connect, self.transaction.retries

    @patience.setter
    def patience(self, wanted: tuple[float, int]) -> None:
        self.comm_params.timeout_connect, self.transaction.retries = wanted

    def close(self) -> None:
        """Give the port back."""
        if self.socket:
            self.socket.close()
        self.socket = None

    def settle(self) -> None:
        """Wait until a request that was broken off is over: nothing to wait for here."""

    def reconfigure(self, baud: int, parity: str) -> None:
        """Go on at another rate and parity: nothing to change here."""

    def follow(self, baud: int, parity: str) -> None:
        """Go on as a board's new settings say."""
        self.reconfigure(baud, parity)

    def execute(self, no_response_expected: bool, request: ModbusPDU) -> ModbusPDU:
        """Do a request; raises ModbusIOException for a reply that does not fit it."""
        reply = super().execute(no_response_expected, request)
        if reply is not None and not _fits(request, reply):
            raise ModbusIOException("the reply does not fit the request")
        return reply


class SerialClient(Client):
    """pymodbus' client on a port that says why it cannot be opened."""

    def __init__(self, port: Port, *, retries: int = RETRIES) -> None:
        super().__init__(
            port.name, baudrate=port.baud, parity=port.real_parity, stopbits=port.stop_bits,
            timeout=port.timeout_s or TIMEOUT_S, retries=retries,
        )  # fmt: skip
        self.port = port
        self.place = port.text

    @property
    def patience(self) -> tuple[float, int]:
        """How long a reply may take, seconds, and how often a request without one is repeated."""
        return super().patience

    @patience.setter
    def patience(self, wanted: tuple[float, int]) -> None:
        self.comm_params.timeout_connect, self.transaction.retries = wanted
        if self.socket:
            self.socket.timeout = self.socket.write_timeout = wanted[0]

    def connect(self) -> bool:
        """Open the port unless it is open; raises UserError saying why it cannot be."""
        self.connect_reset()
        return True

    def connect_reset(self) -> bool:
        """Open the port unless it is open; return whether that has reset a board."""
        if self.socket is not None:
            return False
        self.socket, has_reset = self.port.open(self.comm_params.timeout_connect)
        return has_reset

    def settle(self) -> None:
        """Let the bytes on their way in both directions pass, and drop those that came.

        A request that was broken off leaves them; the next one would run into them.
        """
        if self.socket is None:
            return
        with contextlib.suppress(*TROUBLE):
            self.socket.flush()
            end = time.monotonic() + _QUIET_LIMIT_S
            waiting = -1
            while self.socket.in_waiting != waiting and time.monotonic() < end:
                waiting = self.socket.in_waiting
                time.sleep(_QUIET_S)
            self.socket.reset_input_buffer()

    def reconfigure(self, baud: int, parity: str) -> None:
        """Go on at another rate and parity."""
        self.port = self.port.at(baud, parity)
        self.place = self.port.text
        self.close()
        self.connect()

    def follow(self, baud: int, parity: str) -> None:
        """Go on as a board's new settings say; a pseudo terminal has no parity to change."""
        self.reconfigure(baud, NO_PARITY if is_pty(self.port.name) else parity)

    def send(self, request: bytes, addr: tuple[str, int] | None = None) -> int:
        """Send a frame."""
        self.heard = 0
        try:
            return super().send(request, addr)
        except ConnectionException:
            if self.socket is None:  # the library has closed it: it went away
                raise
            raise WriteTimeoutError(str(self)) from None

    def recv(self, size: int | None) -> bytes:
        """Return what has come."""
        data = super().recv(size)
        self.heard += len(data)
        return data


class ServerIdReply(ReportDeviceIdResponse):
    """The reply to function 17 by the standard: the library takes its last byte for a status."""

    def decode(self, data: bytes) -> None:
        """Keep everything behind the byte count."""
        super().decode(data)
        self.identifier = data[1 : 1 + data[0]]


class WriteTimeoutError(ConnectionException):
    """The port is there and takes no bytes."""


class Pipe(Protocol):
    """What a simulated bus can do."""

    def transmit(self, data: bytes, timeout_cycles: int | None = None) -> bytes:
        """Send a frame and return the reply, empty for none."""

    def cycles(self, seconds: float) -> int:
        """Return a time in cycles."""

    def command(self, text: str) -> str:
        """Give a command and return its answer."""


class SimClient(Client):
    """A Modbus RTU client whose bytes go through the simulator's control pipe.

    Framing, checksums and PDUs are those of pymodbus. A request and its reply are one `tx`
    command, so simulated time advances by exactly what they take and a run is deterministic.
    """

    def __init__(self, simulator: Pipe, *, retries: int = RETRIES) -> None:
        super().__init__("simulator", baudrate=BAUD, parity=PARITY, timeout=60, retries=retries)
        self._simulator = simulator
        self._reply = b""
        self.requests = 0
        self.lost = 0

    @property
    def connected(self) -> bool:
        """The pipe is open as long as the simulator runs."""
        return True

    def connect(self) -> bool:
        """Nothing to connect: the simulator is running."""
        return True

    def follow(self, baud: int, parity: str) -> None:
        """Let the simulated bus go on as a board's new settings say."""
        self._simulator.command(f"baud {baud} {parity}")

    def close(self) -> None:
        """Nothing to close: the simulator is ended by who started it."""

    def is_socket_open(self) -> bool:
        """See `connected`."""
        return True

    def send(self, request: bytes, addr: tuple[str, int] | None = None) -> int:
        """Send a frame and keep its reply for `recv`."""
        del addr
        self.requests += 1
        self._reply = self._simulator.transmit(request, self._simulator.cycles(REPLY_S))
        self.heard = len(self._reply)
        self.lost += not self._reply
        return len(request)

    def recv(self, size: int | None) -> bytes:
        """Return the kept reply once; nothing means that none came."""
        del size
        reply, self._reply = self._reply, b""
        return reply


def _quieten(library: logging.Logger) -> None:
    """Keep the library's lines from the error stream unless the program wants to have them.

    It logs every lost reply, and so does whoever asked: without a handler both would be printed.
    """
    if not library.hasHandlers():
        library.addHandler(logging.NullHandler())


def _fits(request: ModbusPDU, reply: ModbusPDU) -> bool:
    """Whether a reply can be that to a request: its function, and how much or which it names."""
    if reply.isError():
        return reply.function_code & 0x7F == request.function_code
    if reply.function_code != request.function_code:
        return False
    match request.function_code:
        case 1 | 2:
            return len(reply.bits) == (request.count + 7) // 8 * 8
        case 3 | 4:
            return len(reply.registers) == request.count
        case 5 | 6 | 15 | 16 | 22:
            return reply.address == request.address
        case 8:
            return reply.sub_function_code == request.sub_function_code
        case 23:
            return len(reply.registers) == getattr(request, "read_count", None)
        case _:
            return True
