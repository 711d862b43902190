# SPDX-License-Identifier: MIT
"""Two ways to a board for the same Modbus client: a serial port, or the simulator's pipe."""

import logging
from typing import Protocol

from pymodbus.client import ModbusSerialClient

from pixstep.board.port import NO_PARITY, Port, is_pty
from pixstep.lines.rational import TIMER_HZ

BAUD = 115_200
PARITY = "E"
REPLY_CYCLES = TIMER_HZ // 40  # 25 ms: how long a simulated master waits for the first byte
TIMEOUT_S = 0.5
RETRIES = 3

# The client tells of every lost reply itself; the library's own lines would only repeat it.
logging.getLogger("pymodbus").setLevel(logging.CRITICAL)


def serial_client(
    port: str,
    *,
    baud: int = BAUD,
    parity: str = PARITY,
    timeout_s: float = TIMEOUT_S,
    retries: int = RETRIES,
) -> "SerialClient":
    """Return a client on a serial port (or a pty: give it parity N)."""
    return SerialClient(Port(port, baud, parity), timeout_s=timeout_s, retries=retries)


class SerialClient(ModbusSerialClient):
    """pymodbus' client on a port that says why it cannot be opened, and what was heard on it.

    `heard` is how many bytes came back since the last request.
    """

    def __init__(self, port: Port, *, timeout_s: float, retries: int) -> None:
        super().__init__(
            port.name, baudrate=port.baud, parity=port.parity, stopbits=port.stop_bits,
            timeout=timeout_s, retries=retries,
        )  # fmt: skip
        self.port = port
        self.heard = 0

    @property
    def place(self) -> str:
        """Port, rate and frame, for messages."""
        return self.port.text

    @property
    def patience(self) -> tuple[float, int]:
        """How long a reply may take, seconds, and how often a request without one is repeated."""
        return self.comm_params.timeout_connect, self.transaction.retries

    @patience.setter
    def patience(self, wanted: tuple[float, int]) -> None:
        self.comm_params.timeout_connect, self.transaction.retries = wanted
        if self.socket:
            self.socket.timeout = self.socket.write_timeout = wanted[0]

    def connect(self) -> bool:
        """Open the port unless it is open; raises UserError saying why it cannot be."""
        if self.socket is None:
            self.socket = self.port.open(self.comm_params.timeout_connect)
        return True

    def reconfigure(self, baud: int, parity: str) -> None:
        """Go on at another rate and parity."""
        self.port = self.port.at(baud, parity)
        self.close()
        self.connect()

    def follow(self, baud: int, parity: str) -> None:
        """Go on as a board's new settings say; a pseudo terminal has no parity to change."""
        self.reconfigure(baud, NO_PARITY if is_pty(self.port.name) else parity)

    def send(self, request: bytes, addr: tuple | None = None) -> int:
        """Send a frame."""
        self.heard = 0
        return super().send(request, addr)

    def recv(self, size: int | None) -> bytes:
        """Return what has come."""
        data = super().recv(size)
        self.heard += len(data)
        return data


class Pipe(Protocol):
    """What a simulated line can do."""

    def transmit(self, data: bytes, timeout_cycles: int | None = None) -> bytes:
        """Send a frame and return the reply, empty for none."""


class SimClient(ModbusSerialClient):
    """A Modbus RTU client whose bytes go through the simulator's control pipe.

    Framing, checksums and PDUs are those of pymodbus. A request and its reply are one `tx`
    command, so simulated time advances by exactly what they take and a run is deterministic.
    """

    def __init__(self, simulator: Pipe, *, retries: int = RETRIES) -> None:
        super().__init__("simulator", baudrate=BAUD, parity=PARITY, timeout=60, retries=retries)
        self._simulator = simulator
        self._reply = b""
        self.heard = 0
        self.requests = 0
        self.lost = 0

    @property
    def connected(self) -> bool:
        """The pipe is open as long as the simulator runs."""
        return True

    def connect(self) -> bool:
        """Nothing to connect: the simulator is running."""
        return True

    def close(self) -> None:
        """Nothing to close: the simulator is ended by who started it."""

    def is_socket_open(self) -> bool:
        """See `connected`."""
        return True

    def send(self, request: bytes, addr: tuple | None = None) -> int:
        """Send a frame and keep its reply for `recv`."""
        del addr
        self.requests += 1
        self._reply = self._simulator.transmit(request, REPLY_CYCLES)
        self.heard = len(self._reply)
        self.lost += not self._reply
        return len(request)

    def recv(self, size: int | None) -> bytes:
        """Return the kept reply once; nothing means that none came."""
        del size
        reply, self._reply = self._reply, b""
        return reply
