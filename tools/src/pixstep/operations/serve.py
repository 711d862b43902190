# SPDX-License-Identifier: MIT
"""One process owns the bus, and others reach it."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

from pixstep import signals
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import OnPort
from pixstep.operations.desk import Desk, log_of
from pixstep.operations.kinds import PATH, Parsed
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result
from pixstep.server import messages, remote

if TYPE_CHECKING:
    from pixstep.server import modbus_tcp, serving
    from pixstep.server.journal import Log
else:
    modbus_tcp = lazy("pixstep.server.modbus_tcp")
    serving = lazy("pixstep.server.serving")

LOOPBACK = ("127.0.0.1", "localhost")
_TOKEN_FILE_MODE = 0o600
_MOST_NUMBER = 65_535

Door = tuple[str, int]  # host and number


class ServedClient(TypedDict):
    """A client of a server; `axes` are those that it has lines on, as unit.axis."""

    client: str
    door: str
    since_s: float
    requests: int
    writes: bool
    axes: list[str]


class Served(TypedDict):
    """The state of a port's server; of a server that has ended only the port."""

    port: str
    pixstep: NotRequired[int]
    baud: NotRequired[int]
    parity: NotRequired[str]
    place: NotRequired[str]
    timeout_s: NotRequired[float]
    pid: NotRequired[int]
    since_s: NotRequired[float]
    writer: NotRequired[str | None]
    queue: NotRequired[int]
    bus: NotRequired[dict[str, float]]
    clients: NotRequired[list[ServedClient]]


def _read_door(text: str) -> Door:
    """Return a place on the network: 7420, or 127.0.0.1:7420."""
    host, _, number = text.rpartition(":")
    if not number.isdecimal() or int(number) > _MOST_NUMBER:
        raise UserError(
            f"{text!r}: a number from 0 to {_MOST_NUMBER} is wanted, as in 7420 or 127.0.0.1:7420"
        )
    return host or LOOPBACK[0], int(number)


class _Door(Parsed):
    def __init__(self) -> None:
        super().__init__("[HOST:]NUMBER", _read_door, "int | str | tuple[str, int]")

    def judge(self, value: Any) -> Door:
        """Return a number, or a host and a number, that Python has."""
        several = value if isinstance(value, (tuple, list)) else (value,)
        return _read_door(":".join(map(str, several)))


DOOR = _Door()


@operation("serve")
class Serve(OnPort):
    """Own a bus, and let other programs reach it: consoles, Python, PLCs.

    Commands of `pixstep board` and px.connect find the server of their port by themselves, and go
    through it; PIXSTEP_DIRECT=1 goes past it. Any number of them may read, one at a time may write.
    A stop goes first, whoever sends it. When a client dies, what it moves is stopped. It ends by
    Ctrl-C; docs/SERVER.md has the rest.
    """

    result = Served
    json_rows = "event, or the status as one document"

    socket: Path | None = option(
        PATH, "Another place for the socket.", default_text="the one where commands look for it"
    )
    tcp: Door | None = option(DOOR, "Listen on this TCP port of the loopback too.")
    token_file: Path | None = option(
        PATH, "File of the token of --tcp; made if it is missing.", shown="PATH"
    )
    modbus_tcp: Door | None = option(DOOR, "Serve Modbus TCP there, for PLCs.")
    allow_writes: bool = flag("Let clients of Modbus TCP write too.")
    status: bool = flag("Show the state of a running server, and end.")

    def run(self, desk: Desk) -> Result:
        """Serve until a signal comes, or ask another server."""
        if self.status:
            return self._status()
        if self.tcp and self.tcp[0] not in LOOPBACK:
            raise AskedError(
                "{tcp} {host}: on the loopback alone: {places}",
                host=self.tcp[0], places=" or ".join(LOOPBACK),
            )  # fmt: skip
        if self.token_file and not self.tcp:
            raise AskedError("{token_file}: the token is for {tcp}: add it")
        if self.allow_writes and not self.modbus_tcp:
            raise AskedError("{allow_writes}: it is about Modbus TCP: add {modbus_tcp}")
        if self.socket and self.socket.exists() and not self.socket.is_socket():
            raise AskedError(
                "{socket} {path}: there is something else of this name", path=self.socket
            )
        log = log_of(desk)
        server = serving.BusServer(self.bus, log)
        try:
            with signals.until_ctrl_c():
                server.open()
                self._listen(server, log)
                self._listen_to_plcs(server, log)
                server.wait()
        finally:
            with signals.ignored():
                server.close()
                log.close()
        return Result({"port": self.port}, f"{self.port}: ended", told=True)

    def _listen(self, server: serving.BusServer, log: Log) -> None:
        """Open the doors for pixstep's own clients."""
        path = server.listen_here(self.socket)
        log.tell("serving", port=server.port.text, socket=str(path), pid=os.getpid())
        if self.tcp:
            place = self.token_file or path.with_suffix(".token")
            number = server.listen_tcp(*self.tcp, token_in(place))
            log.tell("serving", tcp=f"{remote.TCP}{self.tcp[0]}:{number}", token_file=str(place))

    def _listen_to_plcs(self, server: serving.BusServer, log: Log) -> None:
        """Open the door for Modbus TCP."""
        if self.modbus_tcp:
            host, number = self.modbus_tcp
            door = modbus_tcp.Door(server.bus, server.sessions, writes=self.allow_writes)
            found = door.listen(host, number)
            access = "reads and writes" if self.allow_writes else "reads, and stops"
            log.tell("serving", modbus_tcp=f"{host}:{found}", allows=access)

    def _status(self) -> Result:
        """Return how the server of the port is."""
        client = remote.find(self.bus)
        if client is None:
            raise UserError(f"{self.port}: no server runs (`pixstep serve --port {self.port}`)")
        found = client.status()
        client.close()
        del found["id"]
        return Result(found, "\n".join(_status_lines(found)))


def token_in(place: Path) -> str:
    """Return the token in a file, which is made for this user alone if it is not there."""
    try:
        if place.exists():
            token = place.read_text(encoding="ascii").strip()
            if not token:
                raise UserError(f"{place}: there is no token in it")
            return token
        token = serving.new_token()
        with os.fdopen(os.open(place, os.O_WRONLY | os.O_CREAT, _TOKEN_FILE_MODE), "w") as file:
            file.write(f"{token}\n")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{place}: {getattr(error, 'strerror', None) or error}") from None
    return token


def _status_lines(found: messages.Message) -> list[str]:
    counts = found["bus"]
    lines = [
        f"{found['place']}: server pid {found['pid']} since {_clock(found['since_s'])}",
        f"writes: {found['writer'] or 'nobody'}; requests that wait: {found['queue']}",
        f"bus: {counts['requests']} requests, {counts['frames']} frames, {counts['no_replies']} "
        f"without reply, port lost {counts['line_losses']} times",
        f"stops: {counts['stops']}, at most {1000 * counts['longest_stop_s']:.1f} ms on their way; "
        f"{counts['cut_short']} requests gave way without a reply",
    ]
    for one in found["clients"]:
        axes = f", lines on {' '.join(one['axes'])}" if one["axes"] else ""
        lines.append(
            f"client: {one['client']}, {one['door']}, since {_clock(one['since_s'])}, "
            f"{one['requests']} requests{', writes' if one['writes'] else ''}{axes}"
        )
    return lines


def _clock(seconds: float) -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(seconds))
