# SPDX-License-Identifier: MIT
"""The server of a bus: its doors, its clients, and what it does when one of them dies.

Threads are few and each waits for one thing: one speaks on the bus, one listens at each door, one
reads from each client, one looks after clients that fall silent.
"""

import contextlib
import os
import secrets
import socket
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.board import registers as regs
from pixstep.board import run, settings
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.port import BOOT_S, Port, PortBusyError
from pixstep.errors import AskedText, UserError
from pixstep.server import connection, messages, places, remote
from pixstep.server.bus import BusRequest, BusThread
from pixstep.server.connection import Connection, House
from pixstep.server.journal import Log
from pixstep.server.line import SharedLine
from pixstep.server.local import LocalModbus
from pixstep.server.messages import Message
from pixstep.server.sessions import Axes, ClientSession, Sessions

_LOOK_S = 0.25  # between two looks at clients that may have fallen silent
_LEAST_SILENCE_S = 0.5  # of a client, for which its board is not asked what it allows
_HELD = ("loading", "loaded", *regs.MOVING_STATES)  # an axis has a line of its owner
_LEAVE_S, _POLL_S = 5.0, 0.005  # for clients to go when the server ends
_BACKLOG = 128


@dataclass
class _Silence:
    """A time in which a client that has moved axes asks for nothing."""

    since_s: float
    _limits_s: dict[int, float] = field(default_factory=dict)

    def limit_s(self, board: Device) -> float:
        """Return how long a board goes on without its host, 0 for ever; it is asked once."""
        if board.unit not in self._limits_s:
            with contextlib.suppress(BoardError, UserError):
                self._limits_s[board.unit] = settings.read(board)["bus_timeout_ms"] / 1000
        return self._limits_s.get(board.unit, 0.0)


class BusServer:
    """Owns a port; open it, let it listen, then wait until it is to end."""

    def __init__(self, port: Port, journal: Log) -> None:
        self.port, self.journal = port, journal
        self.line = SharedLine(port)
        self.bus = BusThread(self.line, self._note_stop)
        self.sessions = Sessions(journal.tell)
        self.since_s = time.time()
        self._house = House(self.bus, self.sessions, self.status, self.hello)
        self._connections: set[Connection] = set()
        self._doors: list[socket.socket] = []
        self._paths: list[Path] = []
        self._over = threading.Event()
        self._watch = threading.Thread(target=self._watch_owners, name="watch", daemon=True)

    def open(self) -> None:
        """Open the port. Raises UserError if it cannot be opened."""
        try:
            has_reset = self.line.connect_reset()
        except PortBusyError as error:
            raise PortBusyError(f"{error}{_whose(self.port.name)}") from None
        if has_reset:
            self.journal.tell("booting", board_reset_by="opening its port", seconds=BOOT_S)
            time.sleep(BOOT_S)
        self.bus.start()
        self._watch.start()

    def listen_here(self, path: Path | None) -> Path:
        """Listen on a local socket: at the port's own place if no other is given."""
        if path is None:
            place = places.make_folder()
            first, *others = [place / name for name in places.names(self.port.name)]
        else:
            first, others = path, []
        _clear(first)
        door = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            door.bind(str(first))
        except OSError as error:
            raise UserError(f"{first}: {error.strerror or error}") from None
        self._paths.append(first)
        for other in others:
            _clear(other)
            other.symlink_to(first.name)
            self._paths.append(other)
        self._listen(door, None)
        return first

    def listen_tcp(self, host: str, number: int, token: str) -> int:
        """Listen on TCP, for clients that know the token; return the port's number."""
        door = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        door.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            door.bind((host, number))
        except OSError as error:
            raise UserError(AskedText(
                "{tcp} {place}: {error}", place=f"{host}:{number}", error=error.strerror or error
            )) from None  # fmt: skip
        self._listen(door, token)
        found: int = door.getsockname()[1]
        return found

    def wait(self) -> None:
        """Wait until a signal ends this."""
        self._over.wait()

    def close(self) -> None:
        """Stop what clients move, let them go, and give the port back."""
        self._over.set()
        for door in self._doors:
            door.close()
        if self._watch.ident is not None:
            self._watch.join()
            for session in self.sessions.present():
                self._stop_lines(session, self.sessions.disown(session), "the server ends")
        end_s = time.monotonic() + _LEAVE_S
        while self._connections and time.monotonic() < end_s:
            for one in list(self._connections):
                one.close()
            time.sleep(_POLL_S)
        for path in self._paths:
            with contextlib.suppress(OSError):
                path.unlink()
        if self.bus.ident is not None:
            self.bus.close()
            self.journal.tell("ended", port=self.port.name)
        self.line.close()

    def hello(self) -> Message:
        """Return what a client is told first."""
        port = self.line.port
        timeout_s, _ = self.line.patience
        return {
            "pixstep": messages.VERSION, "port": port.name, "baud": port.baud,
            "parity": port.real_parity, "place": port.text, "timeout_s": timeout_s,
            "pid": os.getpid(),
        }  # fmt: skip

    def status(self) -> Message:
        """Return how the bus and its clients are."""
        writer = self.sessions.writer
        return {
            **self.hello(),
            "since_s": round(self.since_s, 3),
            "writer": writer.name if writer else None,
            "queue": self.bus.waiting(),
            "bus": {**vars(self.bus.counts), "frames": self.line.frames},
            "clients": [
                {
                    "client": one.name,
                    "door": one.door,
                    "since_s": round(one.since_s, 3),
                    "requests": one.requests,
                    "writes": one is writer,
                    "axes": [f"{unit}.{axis}" for unit, axis in sorted(one.axes)],
                }
                for one in self.sessions.present()
            ],
        }

    def _listen(self, door: socket.socket, token: str | None) -> None:
        door.listen(_BACKLOG)
        self._doors.append(door)
        threading.Thread(target=self._accept, args=(door, token), daemon=True).start()

    def _accept(self, door: socket.socket, token: str | None) -> None:
        """Let clients in until the door is closed."""
        while not self._over.is_set():
            try:
                link, _ = door.accept()
            except OSError:
                if self._over.is_set() or door.fileno() < 0:
                    return
                time.sleep(_LOOK_S)  # as with too many open files
                continue
            link.settimeout(connection.HELLO_S)
            one = Connection(self._house, link, token)
            self._connections.add(one)
            threading.Thread(target=self._serve, args=(one,), daemon=True).start()

    def _serve(self, one: Connection) -> None:
        try:
            one.serve(self._leave)
        finally:
            self._connections.discard(one)

    def _leave(self, session: ClientSession, orderly: bool) -> None:
        """Let a client go; one that has not said goodbye has died, and its lines are stopped."""
        axes = self.sessions.leave(session)
        if not orderly and not self._over.is_set():
            self._stop_lines(session, axes, "its client died")

    def _stop_lines(
        self, session: ClientSession, axes: Axes, why: str, states: tuple[str, ...] = _HELD
    ) -> None:
        """Stop those axes of a client that are in some states, and tell of it."""
        modbus = LocalModbus(self.bus, f"the server, for {session.name}")
        for unit in sorted({unit for unit, _ in axes}):
            board = Device(modbus, unit)
            mine = sorted(axis for other, axis in axes if other == unit)
            facts = {"client": session.name, "why": why, "unit": unit}
            if unit == 0:  # it has told all boards at once
                board.stop_all()
                self.journal.tell("stopped", **facts, axes=mine)
                continue
            try:
                moving = _in_state(board, mine, states)
                if moving:
                    run.stop_axes(board, moving)
                    self.journal.tell("stopped", **facts, axes=moving)
            except (BoardError, UserError) as error:
                self.journal.tell("NOT STOPPED", **facts, axes=mine, error=str(error))

    def _watch_owners(self) -> None:
        """Stop lines of clients that fall silent, as a board does with those of its only host."""
        watches: dict[ClientSession, _Silence] = {}
        while not self._over.wait(_LOOK_S):
            present = self.sessions.present()
            watches = {one: watch for one, watch in watches.items() if one in present}
            for session in present:
                if session.axes and not session.open:
                    watch = watches.get(session)
                    if not watch or watch.since_s != session.last_s:
                        watch = watches[session] = _Silence(session.last_s)
                    self._look_at(session, watch)

    def _look_at(self, session: ClientSession, watch: _Silence) -> None:
        """Stop the lines of a client that has been silent longer than their board allows."""
        silent_s = time.monotonic() - watch.since_s
        if silent_s < _LEAST_SILENCE_S:
            return
        for unit in {unit for unit, _ in set(session.axes)} - {0}:
            limit_s = watch.limit_s(Device(LocalModbus(self.bus), unit))
            if limit_s and silent_s > limit_s and not session.open:
                axes = self.sessions.disown(session, unit)
                self._stop_lines(session, axes, f"silent for {limit_s:g} s", regs.MOVING_STATES)

    def _note_stop(self, job: BusRequest, frames: int, late_s: float) -> None:
        self.journal.tell(
            "stop", client=job.by, unit=job.unit, frames_between=frames, ms=round(1000 * late_s, 2)
        )


def _in_state(board: Device, axes: list[int], states: tuple[str, ...]) -> list[int]:
    """Return those of some axes that are in some states; all of them if nobody can tell."""
    try:
        return [axis for axis, state in run.states(board, axes).items() if state in states]
    except BoardError:
        return axes


def _clear(path: Path) -> None:
    """Take a socket away that nobody serves; raises UserError if somebody does, or for a file."""
    if not path.is_symlink() and not path.exists():
        return
    if not path.is_symlink() and not path.is_socket():
        raise UserError(f"{path}: there is something else of this name")
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink(missing_ok=True)
            return
    raise UserError(f"{path}: another server listens there")


def _whose(port: str) -> str:
    """Return who has a port, if its server can be asked: with a colon in front."""
    with contextlib.suppress(UserError):
        found = remote.find(Port(port))
        if found:
            pid = found.server_pid
            found.close()
            return f" (`pixstep serve`, pid {pid})"
    return ""


def new_token() -> str:
    """Return a token that nobody guesses."""
    return secrets.token_urlsafe(24)
