# SPDX-License-Identifier: MIT
"""A client of Channel Access on one connection, which notes all that arrives in its order."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Callable
from typing import Any, TypeVar

import caproto as ca

TIMEOUT_S = 10.0
HOST = "127.0.0.1"
Found = TypeVar("Found")


class CaWire:
    """One connection: `get`, `put`, `monitor`.

    `seen` is what came, (name, value) each, and ("end", name) for the end of a write; `stamps_s`
    are the server's times of the values that have one.
    """

    def __init__(self, port: int, host: str = "test") -> None:
        self._socket = socket.create_connection((HOST, port), TIMEOUT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.circuit: Any = ca.VirtualCircuit(ca.CLIENT, (HOST, port), 0)
        self._channels: dict[str, Any] = {}
        self._names: dict[int, str] = {}
        self._puts: dict[int, str] = {}
        self._answers: list[Any] = []
        self.seen: list[tuple[str, Any]] = []
        self.stamps_s: list[float] = []
        self._send(ca.VersionRequest(0, 13), ca.HostNameRequest(host))
        self._send(ca.ClientNameRequest("test"))

    def close(self) -> None:
        """Leave."""
        self._socket.close()

    def channel(self, name: str) -> Any:
        """Return a channel, connected."""
        if name not in self._channels:
            found = self._channels[name] = ca.ClientChannel(name, self.circuit)
            self._send(found.create())
            self.until(lambda: found.states[ca.CLIENT] is ca.CONNECTED)
        return self._channels[name]

    def get(self, name: str, data_type: Any = None) -> Any:
        """Return the answer of a read."""
        request = self.channel(name).read(data_type=data_type)
        self._send(request)
        return self.until(lambda: self._answer(ca.ReadNotifyResponse, request.ioid))

    def value(self, name: str) -> Any:
        """Return the value of a PV."""
        return _plain(self.get(name).data[0])

    def put(self, name: str, value: Any, data_type: Any = None) -> str:
        """Write, and return the error of the write's end, "" if it is fine."""
        return self.ended(self.begin(name, value, data_type))

    def begin(self, name: str, value: Any, data_type: Any = None, *, wait: bool = True) -> int:
        """Write, and return what `ended` takes."""
        values = value if isinstance(value, list) else [value]
        request = self.channel(name).write(values, data_type, len(values), notify=wait)
        ioid: int = request.ioid
        self._puts[ioid] = name
        self._send(request)
        return ioid

    def ended(self, ioid: int) -> str:
        """Wait for the end of a write; return its error, "" if it is fine."""
        found = self.until(
            lambda: self._answer(ca.WriteNotifyResponse, ioid) or self._failure(ioid)
        )
        return str(found.error_message) if isinstance(found, ca.ErrorResponse) else ""

    def monitor(self, *names: str, data_type: Any = None) -> None:
        """Be told of changes; the first values have come when this returns."""
        for name in names:
            request = self.channel(name).subscribe(data_type=data_type)
            self._names[request.subscriptionid] = name
            before = len(self.seen)
            self._send(request)
            while len(self.seen) == before:
                self._receive()

    def until(self, found: Callable[[], Found]) -> Found:
        """Receive until something is found, and return it."""
        end_s = time.monotonic() + TIMEOUT_S
        while not (result := found()):
            left_s = end_s - time.monotonic()
            if left_s <= 0:
                raise AssertionError(f"nothing came: {self.seen[-10:]}")
            self._socket.settimeout(left_s)
            self._receive()
        return result

    def listen(self, seconds: float) -> None:
        """Receive for some time."""
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0:
            self._socket.settimeout(left_s)
            with contextlib.suppress(TimeoutError):
                self._receive()
        self._socket.settimeout(TIMEOUT_S)

    def saw(self, name: str) -> list[Any]:
        """Return the values of a PV in their order."""
        return [value for one, value in self.seen if one == name]

    def _answer(self, kind: type[Any], ioid: int) -> Any:
        fits = (one for one in self._answers if isinstance(one, kind) and one.ioid == ioid)
        return next(fits, None)

    def _failure(self, ioid: int) -> Any:
        errors = (one for one in self._answers if isinstance(one, ca.ErrorResponse))
        return next((one for one in errors if one.original_request.parameter2 == ioid), None)

    def _send(self, *commands: Any) -> None:
        self._socket.sendall(b"".join(self.circuit.send(*commands)))

    def _receive(self) -> None:
        data = self._socket.recv(65536)
        if not data:
            raise AssertionError("the server closed the connection")
        commands, _ = self.circuit.recv(data)
        for command in commands:
            self.circuit.process_command(command)
            self._note(command)

    def _note(self, command: Any) -> None:
        if isinstance(command, ca.EventAddResponse):
            stamp = getattr(command.metadata, "stamp", None)
            self.seen.append((self._names[command.subscriptionid], _plain(command.data[0])))
            self.stamps_s.append(stamp.as_datetime().timestamp() if stamp else 0.0)
            return
        self._answers = [*self._answers[-100:], command]
        if isinstance(command, ca.WriteNotifyResponse):
            self.seen.append(("end", self._puts[command.ioid]))
            self.stamps_s.append(0.0)


def _plain(value: Any) -> Any:
    """Return a value as Python has it."""
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if hasattr(value, "item") else value
