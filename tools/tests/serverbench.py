# SPDX-License-Identifier: MIT
"""A server in this process, on a pseudo terminal with fake boards, and clients of its socket."""

import contextlib
import json
import shutil
import socket
import tempfile
import threading
import time
from pathlib import Path

import pytest

from bad_bus import Terminal
from pixstep.board.device import Device
from pixstep.board.port import Port
from pixstep.server import remote
from pixstep.server.serving import BusServer

HANG_S = 120  # a guard alone: what is judged is order and content, not time


class Notes:
    """A journal that is kept."""

    def __init__(self):
        self.rows = []

    def tell(self, event, **facts):
        self.rows.append({"event": event, **facts})

    def of(self, event):
        return [row for row in self.rows if row["event"] == event]


def until(holds, what):
    """Wait until something holds."""
    end = time.monotonic() + HANG_S
    while not holds():
        assert time.monotonic() < end, f"never: {what}"
        time.sleep(0.005)


class Desk:
    """A terminal, its server, and what clients need."""

    def __init__(self, terminal, timeout_s=0.5):
        self.terminal, self.notes = terminal, Notes()
        self.port = Port(terminal.name, timeout_s=timeout_s)
        self.server = BusServer(self.port, self.notes)
        self.server.open()
        self.path = self.server.listen_here(None)
        self._links = []

    def client(self, **options):
        """Return another client, which is let go at the end."""
        found = remote.find(Port(self.terminal.name, **options))
        self._links.append(found)
        return found

    def board(self, unit=1, **options):
        """Return a board as another client sees it."""
        return Device(self.client(**options), unit)

    def raw(self):
        """Return a client that speaks the protocol by hand."""
        return Raw(self.path)

    def frames(self):
        """Return the requests that have come out of the port."""
        return [frame for _, frame in self.terminal.frames]

    def close(self):
        for link in self._links:
            with contextlib.suppress(Exception):
                link.close()
        self.server.close()


class Raw:
    """A socket to a server, and lines."""

    def __init__(self, path, greet=True):
        self.link = socket.socket(socket.AF_UNIX)
        self.link.settimeout(HANG_S)
        self.link.connect(str(path))
        self.lines = self.link.makefile("rb")
        if greet:
            self.say({"pixstep": 1, "pid": 1, "command": "by hand"})
            self.hello = self.hear()

    def say(self, message):
        self.link.sendall(json.dumps(message).encode() + b"\n")

    def hear(self):
        return json.loads(self.lines.readline())

    def asked(self, number, pdu, unit=1, **more):
        self.say({"id": number, "do": "ask", "unit": unit, "pdu": pdu, "timeout_s": 60,
                  "retries": 0, **more})  # fmt: skip

    def die(self):
        """End as a process that was killed: without goodbye."""
        self.lines.close()
        self.link.close()


def beside(function, *arguments):
    """Call a function in a thread; return what waits for its result, or raises its exception."""
    results = []

    def call():
        try:
            results.append((function(*arguments), None))
        except BaseException as error:
            results.append((None, error))

    thread = threading.Thread(target=call, daemon=True)
    thread.start()

    def result():
        thread.join(HANG_S)
        assert results, "it hangs"
        value, error = results[0]
        if error:
            raise error
        return value

    return result


@pytest.fixture
def runtime(monkeypatch):
    """Give the user a folder for sockets, of a short name: they may not be long."""
    place = tempfile.mkdtemp(prefix="px", dir="/tmp")
    monkeypatch.setenv("XDG_RUNTIME_DIR", place)
    monkeypatch.delenv("RUNTIME_DIRECTORY", raising=False)
    monkeypatch.delenv(remote.DIRECT, raising=False)
    yield Path(place)
    shutil.rmtree(place)


@pytest.fixture
def terminal():
    """Yield a pseudo terminal with two fake Megas; the test sets `plan`."""
    made = Terminal(2)
    yield made
    made.close()


@pytest.fixture
def desk(terminal, runtime):
    """Yield a server on the terminal."""
    made = Desk(terminal)
    yield made
    made.close()


@pytest.fixture
def slow_desk(terminal, runtime):
    """Yield the same, with a server that waits long for a reply."""
    made = Desk(terminal, timeout_s=2.0)
    yield made
    made.close()
