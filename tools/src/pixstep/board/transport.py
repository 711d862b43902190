# SPDX-License-Identifier: MIT
"""Two ways to a board for the same Modbus client: a serial port, or the simulator's pipe."""

import logging

from pymodbus.client import ModbusSerialClient

from pixstep.lines.rational import TIMER_HZ
from pixstep.simulation.simctl import Simulator

BAUD = 115_200
PARITY = "E"
REPLY_CYCLES = TIMER_HZ // 40  # 25 ms: how long a simulated master waits for the first byte

# The client tells of every lost reply itself; the library's own lines would only repeat it.
logging.getLogger("pymodbus").setLevel(logging.CRITICAL)


def serial_client(port: str, *, baud: int = BAUD, parity: str = PARITY) -> ModbusSerialClient:
    """Return a client on a serial port (or a pty: give it parity N)."""
    return ModbusSerialClient(port, baudrate=baud, parity=parity, timeout=0.5, retries=3)


class SimClient(ModbusSerialClient):
    """A Modbus RTU client whose bytes go through the simulator's control pipe.

    Framing, checksums and PDUs are those of pymodbus. A request and its reply are one `tx`
    command, so simulated time advances by exactly what they take and a run is deterministic.
    """

    def __init__(self, simulator: Simulator, *, retries: int = 3) -> None:
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
        self.lost += not self._reply
        return len(request)

    def recv(self, size: int | None) -> bytes:
        """Return the kept reply once; nothing means that none came."""
        del size
        reply, self._reply = self._reply, b""
        return reply
