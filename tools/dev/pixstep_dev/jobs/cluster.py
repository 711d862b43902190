# SPDX-License-Identifier: MIT
"""A Dask cluster on this computer: a scheduler, workers in processes of their own, a counted line.

The client reaches the scheduler by a relay that counts all bytes in both directions.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pixstep.errors import UserError

_READY_S = 60.0
_POLL_S = 0.1
_BYTES = 1 << 16
_MODULES = {"scheduler": "distributed.cli.dask_scheduler", "worker": "distributed.cli.dask_worker"}


@dataclass
class Relay:
    """Passes connections on to a port, and counts the bytes of both directions."""

    port: int
    bytes: int = 0
    _listener: socket.socket = field(default_factory=socket.socket)
    _sockets: list[socket.socket] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._listener.bind(("127.0.0.1", 0))
        self._listener.listen()
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def address(self) -> str:
        """Where it listens."""
        return f"tcp://127.0.0.1:{self._listener.getsockname()[1]}"

    def close(self) -> None:
        """End it."""
        for one in (self._listener, *self._sockets):
            with contextlib.suppress(OSError):
                one.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                near, _ = self._listener.accept()
                far = socket.create_connection(("127.0.0.1", self.port))
                self._sockets += near, far
                for pair in ((near, far), (far, near)):
                    threading.Thread(target=self._pass_on, args=pair, daemon=True).start()

    def _pass_on(self, source: socket.socket, target: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(_BYTES):
                self.bytes += len(data)
                target.sendall(data)
        with contextlib.suppress(OSError):
            target.shutdown(socket.SHUT_WR)


@dataclass
class Cluster:
    """A scheduler, and its workers by number from 0 on."""

    folder: Path
    workers: int
    running: list[subprocess.Popen[bytes]] = field(default_factory=list)
    address: str = ""

    @contextlib.contextmanager
    def up(self) -> Iterator[Relay]:
        """Yield the line to the scheduler, once all workers are there."""
        file = self.folder / "scheduler.json"
        scheduler = self._begin("scheduler", "--host", "127.0.0.1", "--port", "0",
                                "--scheduler-file", str(file), "--no-dashboard")  # fmt: skip
        relay = None
        try:
            self.address = _address(file)
            for _ in range(self.workers):
                self.add()
            relay = Relay(int(self.address.rpartition(":")[2]))
            if self.workers:
                self.await_workers()
            yield relay
        finally:
            if relay:
                relay.close()
            for one in (*self.running, scheduler):
                one.kill()
                one.wait()

    def add(self, **environment: str) -> None:
        """Begin a worker in a process of its own, with some variables besides."""
        self.running.append(self._begin(
            "worker", self.address, "--name", f"w{len(self.running)}", "--nthreads", "1",
            "--no-nanny", "--no-dashboard", "--local-directory", str(self.folder), **environment,
        ))  # fmt: skip

    def kill(self, number: int) -> None:
        """Kill a worker."""
        self.running[number].send_signal(signal.SIGKILL)

    def _begin(self, what: str, *words: str, **environment: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-m", _MODULES[what], *words], env={**os.environ, **environment},
            stdout=subprocess.DEVNULL, stderr=(self.folder / f"{what}.log").open("ab"),
        )  # fmt: skip

    def await_workers(self) -> None:
        """Wait until all workers are there."""
        import distributed

        client: Any
        with distributed.Client(  # type: ignore[no-untyped-call]
            self.address, set_as_default=False
        ) as client:
            client.wait_for_workers(len(self.running), timeout=_READY_S)


def _address(file: Path) -> str:
    end_s = time.monotonic() + _READY_S
    while time.monotonic() < end_s:
        with contextlib.suppress(OSError, ValueError):
            found: str = json.loads(file.read_text())["address"]
            return found
        time.sleep(_POLL_S)
    raise UserError(f"{file}: the scheduler has not begun")
