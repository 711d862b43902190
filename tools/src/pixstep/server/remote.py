# SPDX-License-Identifier: MIT
"""A bus that another process owns: a client like that of a serial port, over a socket.

`open_bus` is what commands and programs open a port with. Where a server of the port runs, they go
through it without being told to; PIXSTEP_DIRECT=1 goes past it.
"""

import itertools
import os
import select
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path

from pixstep.board import link
from pixstep.board.errors import BusTakenError, OvertakenError
from pixstep.board.link import Link, Say, SerialLink
from pixstep.board.modbus import MOST_WORDS, Client
from pixstep.board.port import BAUD, RETRIES, TIMEOUT_S, Port, PortBusyError
from pixstep.board.rtu import Reply
from pixstep.errors import AskedText, UserError, one_line
from pixstep.server import messages, places
from pixstep.server.local import raise_error
from pixstep.server.messages import Message, MessageError

DIRECT, TOKEN = "PIXSTEP_DIRECT", "PIXSTEP_TOKEN"
TCP, UNIX = "tcp://", "unix:"
_ANSWER_S = 30.0  # beside a request's own time: others' requests may come first
_HELLO_S = 3.0
# Registers in one read, so that a stop need not wait for more than some 20 ms of the wire.
_SHORT_WORDS, _FAST_BAUD = 76, 200_000
_PIECE = 65_536


class ServerGoneError(PortBusyError):
    """The server has ended, or does not answer: it still has the port, and a stop goes beside."""


class RemoteModbus(Client):
    """What requests of this process go through to the server of a port."""

    def __init__(self, port: Port, address: str | tuple[str, int]) -> None:
        super().__init__(port.timeout_s or TIMEOUT_S, RETRIES)
        self._port, self._address = port, address
        self._numbers = itertools.count(1)
        self._heard = b""
        self.server_pid = 0
        self._link: socket.socket | None = None
        self._connect()

    def ask(self, unit: int, pdu: bytes, *, urgent: bool = False) -> Reply:
        """Send a request, again if need be, and return its reply; a stop goes first by itself."""
        del urgent
        timeout_s, retries = self.patience
        answer = self._transact({
            "do": messages.ASK, "unit": unit, "pdu": pdu.hex(), "timeout_s": timeout_s,
            "retries": retries, **({"more": True} if self.more_follows else {}),
        }, timeout_s * (retries + 1))  # fmt: skip
        return Reply(bytes.fromhex(answer["pdu"]), 0)

    def tell(self, pdu: bytes, unit: int = 0) -> None:
        """Send a request to which nobody replies."""
        self._transact({"do": messages.TELL, "unit": unit, "pdu": pdu.hex()})

    def follow(self, baud: int, parity: str) -> None:
        """Let the server go on as a board's new settings say."""
        self._transact({"do": messages.FOLLOW, "baud": baud, "parity": parity})

    def reconfigure(self, baud: int, parity: str) -> None:
        """Let the server go on at another rate: while no other client is there."""
        self._transact({"do": messages.RECONFIGURE, "baud": baud, "parity": parity})

    def status(self) -> Message:
        """Return how the server is."""
        return self._transact({"do": messages.STATUS})

    def close(self) -> None:
        """Say goodbye: lines that run go on."""
        if self._link:
            try:
                self._send({"do": messages.BYE})
            except ServerGoneError:
                return
            self._link.close()
            self._link = None

    def _connect(self) -> None:
        """Greet the server. Raises UserError if it does not take this client."""
        try:
            self._link = _connected(self._address)
        except OSError as error:
            raise ServerGoneError(f"{self._port.name}: no server: {_reason(error)}") from None
        self._heard = b""
        self._send({
            "pixstep": messages.VERSION, "pid": os.getpid(), "command": _command(),
            "token": os.environ.get(TOKEN, ""),
        })  # fmt: skip
        hello = self._receive(time.monotonic() + _HELLO_S)
        if "error" in hello:
            self._link.close()
            self._link = None
            raise UserError(f"{self._port.name}: its server: {hello.get('text')}")
        self._greet(hello)

    def _greet(self, hello: Message) -> None:
        """Take over what the server says of the bus; raises UserError if that is not wanted."""
        baud, parity = int(hello["baud"]), str(hello["parity"])
        port = self._port
        if port.baud not in (BAUD, baud) or port.parity not in (None, parity):
            self.close()
            raise UserError(AskedText(
                "{name}: its server (pid {pid}) talks at {place}: leave {baud} and {parity} out, "
                "or end the server",
                name=port.name, pid=hello["pid"], place=hello["place"],
            ))  # fmt: skip
        self.server_pid = int(hello["pid"])
        self.place = str(hello["place"])
        self.most_words = MOST_WORDS if baud >= _FAST_BAUD else _SHORT_WORDS
        if port.timeout_s is None:
            self.patience = (float(hello["timeout_s"]), self.patience[1])

    def _transact(self, message: Message, lasts_s: float = 0.0) -> Message:
        """Send a request and return its answer; raises what is wrong in it."""
        if self._link is None:
            self._connect()
        number = next(self._numbers)
        self._send({"id": number, **message})
        end_s = time.monotonic() + lasts_s + _ANSWER_S
        while (answer := self._receive(end_s)).get("id") != number:
            if "id" not in answer:
                raise self._lost("it does not keep to its protocol")
        self.heard = int(answer.get("heard", 0))
        match answer.get("error"):
            case messages.TAKEN:
                raise BusTakenError(f"{self._port.name}: not sent: {answer['text']}")
            case messages.OVERTAKEN:
                raise OvertakenError(f"{self._port.name}: not sent: stopped by {answer['text']}")
            case _:
                raise_error(answer)
        return answer

    def _send(self, message: Message) -> None:
        if self._link is None:
            raise self._lost("it has ended")
        try:
            self._link.sendall(messages.encode(message))
        except OSError:
            raise self._lost("it has ended") from None

    def _receive(self, end_s: float) -> Message:
        """Return the next message of the server."""
        while b"\n" not in self._heard:
            assert self._link is not None
            try:
                left_s = max(0.0, end_s - time.monotonic())
                if not select.select([self._link], [], [], left_s)[0]:
                    raise self._lost("it does not answer")
                data = self._link.recv(_PIECE)
            except OSError:
                data = b""
            if not data:
                raise self._lost("it has ended")
            self._heard += data
        line, _, self._heard = self._heard.partition(b"\n")
        try:
            return messages.decode(line)
        except MessageError:
            raise self._lost("it does not keep to its protocol") from None

    def _lost(self, why: str) -> ServerGoneError:
        """Return what is to be raised when the server is lost; a later request looks again."""
        if self._link:
            self._link.close()
        self._link = None
        pid = f" (pid {self.server_pid})" if self.server_pid else ""
        return ServerGoneError(f"the server of {self._port.name}{pid} is gone: {why}")


def open_bus(
    port: Port, say: Say = lambda _: None, first: Callable[[Link], None] = lambda _: None
) -> SerialLink:
    """Open a port, through its server if one runs; else as `link.open_port` does."""
    client = None if os.environ.get(DIRECT) else find(port)
    if client is None:
        return link.open_port(port, say, first)
    found = SerialLink(client, port.name)
    try:
        first(found)
    except BaseException:
        found.close()
        raise
    return found


def find(port: Port) -> RemoteModbus | None:
    """Return a client of a port's server; None if none runs. Raises UserError if it refuses."""
    if port.name.startswith(TCP):
        return RemoteModbus(port, _network(port.name))
    if port.name.startswith(UNIX):
        return RemoteModbus(port, port.name.removeprefix(UNIX))
    if not hasattr(socket, "AF_UNIX"):
        return None
    for path in places.known(port.name):
        try:
            return RemoteModbus(port, str(path))
        except ServerGoneError:  # a socket that was left behind
            if _listens(path):
                raise
    return None


def _connected(address: str | tuple[str, int]) -> socket.socket:
    """Return a socket that is connected to a server."""
    if isinstance(address, tuple):
        found = socket.create_connection(address, _HELLO_S)
        found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    else:
        found = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        found.settimeout(_HELLO_S)
        try:
            found.connect(address)
        except OSError:
            found.close()
            raise
    found.settimeout(None)
    return found


def _listens(path: Path) -> bool:
    """Whether anybody accepts connections at a socket."""
    try:
        _connected(str(path)).close()
    except OSError:
        return False
    return True


def _network(name: str) -> tuple[str, int]:
    """Return host and number of tcp://HOST:NUMBER."""
    host, _, number = name.removeprefix(TCP).rpartition(":")
    if not host or not number.isdecimal() or not 0 < int(number) < 1 << 16:
        raise UserError(f"{name}: expected tcp://HOST:NUMBER, as in tcp://127.0.0.1:7420")
    return host, int(number)


def _reason(error: OSError) -> str:
    return os.strerror(error.errno) if error.errno else str(error)


def _command() -> str:
    """Return the command of this process, as others are told who writes."""
    first, *others = sys.argv or [""]
    place = Path(first)
    name = place.parent.name if place.name == "__main__.py" else place.name
    if name in ("", "-", "-c"):
        name = "python"
    return one_line(" ".join([name, *others]), 100)
