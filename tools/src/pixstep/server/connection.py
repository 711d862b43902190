# SPDX-License-Identifier: MIT
"""One client of a server on its socket: what it asks goes to the bus, answers come back."""

import contextlib
import hmac
import socket
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import BinaryIO

from pixstep.board.port import LAST_UNIT, LEAST_BAUD, MOST_BAUD, PARITIES, TIMEOUTS_S
from pixstep.errors import one_line
from pixstep.server import bus, messages
from pixstep.server.bus import BusRequest, BusThread
from pixstep.server.line import SharedLine
from pixstep.server.messages import Message, MessageError
from pixstep.server.sessions import ClientSession, Sessions

HELLO_S = 10.0  # for a client to say who it is
_MOST_PENDING = 64  # requests of a client: pixstep's have one, or two when they are ended
_MOST_RETRIES = 100
_MOST_COMMAND = 120  # characters
_CREDENTIALS = "3i"  # process, user, group
_NO_SIGNAL = getattr(socket, "MSG_NOSIGNAL", 0)


@dataclass(frozen=True)
class House:
    """What all connections share."""

    bus: BusThread
    sessions: Sessions
    status: Callable[[], Message]
    hello: Callable[[], Message]


class Connection:
    """A client's socket. `token` is what it has to say first, if that is asked for."""

    def __init__(self, house: House, link: socket.socket, token: str | None) -> None:
        self._house, self._link, self._token = house, link, token
        self._door = "socket" if token is None else "tcp"
        self._sending = threading.Lock()
        self._orderly = self._strays = False
        self.session = ClientSession("", self._door)

    def serve(self, left: Callable[[ClientSession, bool], None]) -> None:
        """Serve the client to its end; `left` gets its session, and whether it has said goodbye."""
        with self._link, self._link.makefile("rb") as lines:
            try:
                if not self._greet(lines.readline(messages.MOST_BYTES)):
                    return
            except (OSError, MessageError) as error:
                self._send({"error": messages.MISTAKE, "text": str(error)})
                return
            self._house.sessions.enter(self.session)
            try:
                self._send(self._house.hello())
                self._serve(lines)
            finally:
                left(self.session, self._orderly)
                if self._strays:
                    home = BusRequest(
                        "the server", 0, b"\0", messages.RequestMeaning(), lambda _: None, bus.FIRST
                    )
                    home.act = SharedLine.go_home
                    self._house.bus.submit(home)

    def close(self) -> None:
        """End the connection."""
        with contextlib.suppress(OSError):
            self._link.shutdown(socket.SHUT_RDWR)

    def _greet(self, line: bytes) -> bool:
        """Read a client's first line; False if it has gone. Raises MessageError to keep it out."""
        if not line:
            return False
        hello = messages.decode(line)
        if hello.get("pixstep") != messages.VERSION:
            raise MessageError(
                f"version {hello.get('pixstep')!r} of the protocol: this server speaks version "
                f"{messages.VERSION}"
            )
        if self._token is not None:
            given = hello.get("token")
            if not isinstance(given, str) or not hmac.compare_digest(
                given.encode(), self._token.encode()
            ):
                raise MessageError("the token is not this server's")
        command = one_line(str(hello.get("command", "a client")), _MOST_COMMAND)
        self.session.name = f"{command} (pid {self._pid(hello)})"
        self._link.settimeout(None)
        return True

    def _pid(self, hello: Message) -> int:
        """Return a client's process: the system knows it of a local socket."""
        if self._link.family == getattr(socket, "AF_UNIX", None) and hasattr(socket, "SO_PEERCRED"):
            size = struct.calcsize(_CREDENTIALS)
            found = self._link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
            pid: int = struct.unpack(_CREDENTIALS, found)[0]
            return pid
        return messages.whole(hello, "pid", 0, 1 << 32)

    def _serve(self, lines: BinaryIO) -> None:
        """Take requests until the client goes."""
        with contextlib.suppress(OSError):
            while line := lines.readline(messages.MOST_BYTES):
                self.session.last_s = time.monotonic()
                number: object = None
                try:
                    request = messages.decode(line)
                    if request.get("do") == messages.BYE:
                        self._orderly = True
                        return
                    number = messages.whole(request, "id", 0, 1 << 53)
                    self._take(request, number)
                except MessageError as error:
                    self._send({"id": number, "error": messages.MISTAKE, "text": str(error)})

    def _take(self, request: Message, number: int) -> None:
        """Do what a request says, or put it before the bus."""
        what = messages.text(request, "do")
        if what == messages.STATUS:
            self._send({"id": number, **self._house.status()})
        elif what in (messages.ASK, messages.TELL):
            self._submit(number, self._request(request, number, tells=what == messages.TELL))
        elif what in (messages.FOLLOW, messages.RECONFIGURE):
            self._change(request, number, what)
        else:
            raise MessageError(f"do: {what!r} is not known")

    def _request(self, request: Message, number: int, *, tells: bool) -> BusRequest:
        """Return what a client wants to be sent."""
        unit = messages.whole(request, "unit", 0 if tells else 1, LAST_UNIT)
        pdu = messages.pdu(request)
        patience = self._house.bus.line.patience
        if not tells:
            patience = (
                min(patience[0], messages.seconds(request, "timeout_s", *TIMEOUTS_S)),
                min(patience[1], messages.whole(request, "retries", 0, _MOST_RETRIES)),
            )
        job = self._job(number, unit, pdu, messages.meaning_of(pdu), tells=tells, patience=patience)
        job.more_follows = request.get("more") is True
        if self._house.sessions.is_driven(self.session):
            job.share()
        return job

    def _change(self, request: Message, number: int, what: str) -> None:
        """Go on at another rate: with a board that was set so, or to look for one, if alone."""
        baud = messages.whole(request, "baud", LEAST_BAUD, MOST_BAUD)
        parity = messages.text(request, "parity")
        if parity not in PARITIES:
            raise MessageError(f"parity: one of {', '.join(PARITIES)}")
        others = len(self._house.sessions.present()) - 1
        if what == messages.RECONFIGURE and others:
            text = f"another rate is for a client that is alone, and {others} more use its server"
            self._send({"id": number, "error": messages.TAKEN, "text": text})
            return
        job = self._job(number, 0, b"\0", messages.RequestMeaning())

        job.act = lambda line: line.go_to(baud, parity, stays=what == messages.FOLLOW)
        self._strays = self._strays or what == messages.RECONFIGURE
        self._submit(number, job)

    def _job(
        self,
        number: int,
        unit: int,
        pdu: bytes,
        means: messages.RequestMeaning,
        *,
        tells: bool = False,
        patience: tuple[float, int] = (0.5, 0),
    ) -> BusRequest:
        def finish(answer: Message) -> None:
            self.session.open.discard(number)
            self._send({"id": number, **answer})

        rank = bus.WRITER if self._house.sessions.writer is self.session else bus.READER
        return BusRequest(
            self.session.name, unit, pdu, means, finish, bus.STOP if means.stops else rank,
            tells=tells, patience=patience, is_gone=self._is_gone,
        )  # fmt: skip

    def _submit(self, number: int, job: BusRequest) -> None:
        """Put a request before the bus, unless the client may not write, or asks too much."""
        means = job.meaning
        if len(self.session.open) >= _MOST_PENDING:
            raise MessageError(f"more than {_MOST_PENDING} requests at once")
        if means.writes and not means.stops:
            other = self._house.sessions.claim(self.session)
            if other:
                job.finish({"error": messages.TAKEN, "text": other})
                return
            self._house.sessions.drive(self.session, job.unit, means)
        self.session.requests += 1
        self.session.open.add(number)
        self._house.bus.submit(job)

    def _is_gone(self) -> bool:
        """Whether the client has ended its connection, or its process has ended."""
        try:
            return not self._link.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        except BlockingIOError:
            return False
        except OSError:
            return True

    def _send(self, message: Message) -> None:
        """Send an answer, and wait for nobody: a client that reads none is let go."""
        data = messages.encode(message)
        with self._sending:
            try:
                sent = self._link.send(data, socket.MSG_DONTWAIT | _NO_SIGNAL)
            except OSError:
                sent = 0
            if sent < len(data):
                self.close()
