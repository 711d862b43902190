# SPDX-License-Identifier: MIT
"""`pixstep serve`: one process owns the bus, and others reach it."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pixstep import signals
from pixstep.board.port import Port
from pixstep.cli.board.group import port_options
from pixstep.cli.command import command
from pixstep.cli.options import show_json
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.server import messages, remote

if TYPE_CHECKING:
    from pixstep.server import journal, modbus_tcp, serving
else:
    journal = lazy("pixstep.server.journal")
    modbus_tcp = lazy("pixstep.server.modbus_tcp")
    serving = lazy("pixstep.server.serving")

_LOOPBACK = ("127.0.0.1", "localhost")
_TOKEN_FILE_MODE = 0o600
_MOST_NUMBER = 65_535

Door = tuple[str, int]  # host and number


class _DoorType(click.ParamType[Door, Door | str]):
    """A place on the network: 7420, or 127.0.0.1:7420."""

    name = "[HOST:]NUMBER"

    def convert(
        self, value: Door | str, param: click.Parameter | None, ctx: click.Context | None
    ) -> Door:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, tuple):
            return value
        host, _, number = value.rpartition(":")
        if not number.isdecimal() or int(number) > _MOST_NUMBER:
            self.fail(
                f"{value!r}: a number from 0 to {_MOST_NUMBER} is wanted, as in 7420 or "
                f"127.0.0.1:7420",
                param, ctx,
            )  # fmt: skip
        return host or _LOOPBACK[0], int(number)


@command("serve")
@port_options
@click.option(
    "--socket",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Another place for the socket.  [default: the one where commands look for it]",
)
@click.option("--tcp", type=_DoorType(), help="Listen on this TCP port of the loopback too.")
@click.option(
    "--token-file",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Where the token of --tcp is; made if it is not there.",
)
@click.option("--modbus-tcp", type=_DoorType(), help="Speak Modbus TCP there, for PLCs.")
@click.option("--allow-writes", is_flag=True, help="Let clients of Modbus TCP write too.")
@click.option("--status", is_flag=True, help="Ask a server that runs how it is, and end.")
@click.option("--json", "as_json", is_flag=True, help="Write the log, or the status, as JSON.")
def serve_command(
    port: Port,
    socket: Path | None,
    tcp: Door | None,
    token_file: Path | None,
    modbus_tcp: Door | None,
    allow_writes: bool,
    status: bool,
    as_json: bool,
) -> None:
    """Own a bus, and let other programs reach it: consoles, Python, PLCs.

    Commands of `pixstep board` and px.connect find the server of their port by themselves, and go
    through it; PIXSTEP_DIRECT=1 goes past it. Any number of them may read, one at a time may write.
    A stop goes first, whoever sends it. When a client dies, what it moves is stopped. It ends by
    Ctrl-C; docs/SERVER.md has the rest.
    """
    if status:
        _show_status(port, as_json=as_json)
        return
    if tcp and tcp[0] not in _LOOPBACK:
        raise UserError(f"--tcp {tcp[0]}: on the loopback alone: {' or '.join(_LOOPBACK)}")
    if token_file and not tcp:
        raise UserError("--token-file: the token is for --tcp: add it")
    if allow_writes and not modbus_tcp:
        raise UserError("--allow-writes: it is about Modbus TCP: add --modbus-tcp")
    if socket and socket.exists() and not socket.is_socket():
        raise UserError(f"--socket {socket}: there is something else of this name")
    server = serving.Server(port, log := journal.Journal(as_json=as_json))
    try:
        with signals.until_ctrl_c():
            server.open()
            _listen(server, log, socket, tcp, token_file)
            _listen_to_plcs(server, log, modbus_tcp, allow_writes)
            server.wait()
    finally:
        with signals.ignored():
            server.close()
            log.close()


def _listen(
    server: serving.Server,
    log: journal.Journal,
    socket: Path | None,
    tcp: Door | None,
    token_file: Path | None,
) -> None:
    """Open the doors for pixstep's own clients."""
    path = server.listen_here(socket)
    log.tell("serving", port=server.port.text, socket=str(path), pid=os.getpid())
    if tcp:
        place = token_file or path.with_suffix(".token")
        number = server.listen_tcp(*tcp, _token(place))
        log.tell("serving", tcp=f"{remote.TCP}{tcp[0]}:{number}", token_file=str(place))


def _listen_to_plcs(
    server: serving.Server, log: journal.Journal, place: Door | None, allow_writes: bool
) -> None:
    """Open the door for Modbus TCP."""
    if place:
        door = modbus_tcp.Door(server.bus, server.sessions, writes=allow_writes)
        number = door.listen(*place)
        access = "reads and writes" if allow_writes else "reads, and stops"
        log.tell("serving", modbus_tcp=f"{place[0]}:{number}", allows=access)


def _token(place: Path) -> str:
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


def _show_status(port: Port, *, as_json: bool) -> None:
    """Print how the server of a port is."""
    client = remote.find(port)
    if client is None:
        raise UserError(f"{port.name}: no server runs (`pixstep serve --port {port.name}`)")
    found = client.status()
    client.close()
    found.pop("id")
    if as_json:
        show_json(found)
    else:
        click.echo("\n".join(_status_lines(found)))


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
