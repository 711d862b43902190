# SPDX-License-Identifier: MIT
"""A page of this computer for browsers, and what it shows as it goes on: HTTP, events of a server.

Each browser has a thread that sends the newest state whenever there is one: a browser that reads
slowly misses states, one that does not read at all is let go, and none of them delays another.
"""

from __future__ import annotations

import contextlib
import gzip
import json
import secrets
import socket
import socketserver
import threading
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from typing import Any, ClassVar, Protocol
from urllib.parse import parse_qs, urlsplit

from pixstep.errors import UserError

PATIENCE_S = 10.0  # for a browser to send its request, and to take what it is sent
BEAT_S = 1.0  # something is sent at least so often: without it the page says that it is alone
MOST_BROWSERS = 32
_SEND_BYTES = 65_536  # that the system keeps for a browser that does not read
_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_HEADS = {
    "Content-Security-Policy": _POLICY, "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store",
}  # fmt: skip


class PageSource(Protocol):
    """What a page shows."""

    def first(self) -> Mapping[str, Any]:
        """Return what a browser is told first, by the names of events."""

    def now(self) -> Mapping[str, Any]:
        """Return the newest state, by the names of events."""


class Bell:
    """Tells threads that there is a new state."""

    def __init__(self) -> None:
        self._rung = threading.Condition()
        self._count = 0

    def ring(self) -> None:
        """Tell all who wait."""
        with self._rung:
            self._count += 1
            self._rung.notify_all()

    def wait(self, heard: int, timeout_s: float) -> int:
        """Wait for another ring than that of a number, at most so long; return the newest."""
        with self._rung:
            self._rung.wait_for(lambda: self._count != heard, timeout_s)
            return self._count


class Site(socketserver.ThreadingMixIn, socketserver.TCPServer):
    """Serves a page at a place, to whoever knows the token; `stop` is done if the page asks."""

    allow_reuse_address = True
    daemon_threads = True
    block_on_close = False
    request_queue_size = MOST_BROWSERS

    def __init__(
        self, place: tuple[str, int], page: str, shown: PageSource, bell: Bell, token: str,
        stop: Callable[[], str] | None = None,
    ) -> None:  # fmt: skip
        self.page, self.shown, self.bell, self.token = page.encode(), shown, bell, token
        self.packed = gzip.compress(self.page)
        self.stop, self.places = stop, threading.BoundedSemaphore(MOST_BROWSERS)
        self.over = threading.Event()
        try:
            super().__init__(place, _Request)
        except OSError as error:
            raise UserError(f"{place[0]}:{place[1]}: {error.strerror or error}") from None

    @property
    def address(self) -> str:
        """What is typed into a browser."""
        host, number = self.server_address[:2]
        named = "127.0.0.1" if host == "0.0.0.0" else host
        return f"http://{named!s}:{number}/?token={self.token}"

    def open(self) -> None:
        """Serve, in a thread of its own."""
        threading.Thread(target=self.serve_forever, args=(BEAT_S / 10,), daemon=True).start()

    def close(self) -> None:
        """Let all browsers go."""
        self.over.set()
        self.bell.ring()
        self.shutdown()
        self.server_close()


class _Request(BaseHTTPRequestHandler):
    server: Site
    timeout: ClassVar[float] = PATIENCE_S

    def setup(self) -> None:
        """Keep little for a browser that does not read."""
        self.request.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BYTES)
        super().setup()

    def handle(self) -> None:
        """Serve a request; a browser that goes away, or does not read, is let go."""
        with contextlib.suppress(OSError):
            super().handle()

    def finish(self) -> None:
        """Let go of the connection."""
        with contextlib.suppress(OSError):
            super().finish()

    def do_GET(self) -> None:
        """Send the page, or its events."""
        path = urlsplit(self.path).path
        if path not in ("/", "/events"):
            self._send(HTTPStatus.NOT_FOUND, "There is the page / and nothing else.\n")
        elif self._knows_token():
            if path == "/":
                self._send_page()
            else:
                self._send_events()

    def do_POST(self) -> None:
        """Stop, if that is allowed."""
        if urlsplit(self.path).path != "/stop" or self.server.stop is None:
            self._send(HTTPStatus.NOT_FOUND, "This page only shows.\n")
        elif self._knows_token():
            self._send(HTTPStatus.OK, f"{self.server.stop()}\n")

    def log_message(self, *_: Any) -> None:
        """Write no log: the page is no event of the boards."""

    def _knows_token(self) -> bool:
        given = parse_qs(urlsplit(self.path).query).get("token", [""])[0]
        if secrets.compare_digest(given.encode(), self.server.token.encode()):
            return True
        said = "The address needs its ?token=..., as `pixstep watch --web` has printed it.\n"
        self._send(HTTPStatus.FORBIDDEN, said)
        return False

    def _send_page(self) -> None:
        packs = "gzip" in self.headers.get("Accept-Encoding", "")
        more = {"Content-Encoding": "gzip"} if packs else {}
        self._send_bytes(
            HTTPStatus.OK, "text/html; charset=utf-8",
            self.server.packed if packs else self.server.page, more,
        )  # fmt: skip

    def _send_events(self) -> None:
        """Send the newest state again and again, until somebody goes."""
        if not self.server.places.acquire(blocking=False):
            self._send(HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_BROWSERS} browsers watch already.\n")
            return
        try:
            self._head(HTTPStatus.OK, {"Content-Type": "text/event-stream"})
            self._events(self.server.shown.first())
            sent: dict[str, Any] = {}
            heard = -1
            while not self.server.over.is_set():
                heard = self.server.bell.wait(heard, BEAT_S)
                now = self.server.shown.now()
                self._events({name: one for name, one in now.items() if sent.get(name) != one})
                sent = dict(now)
        finally:
            self.server.places.release()

    def _events(self, named: Mapping[str, Any]) -> None:
        for name, data in named.items():
            text = json.dumps(data, separators=(",", ":"))
            self.wfile.write(f"event: {name}\ndata: {text}\n\n".encode())

    def _send(self, status: HTTPStatus, text: str) -> None:
        self._send_bytes(status, "text/plain; charset=utf-8", text.encode(), {})

    def _send_bytes(
        self, status: HTTPStatus, kind: str, data: bytes, more: Mapping[str, str]
    ) -> None:
        length = str(len(data))
        self._head(status, {"Content-Type": kind, "Content-Length": length, **more})
        self.wfile.write(data)

    def _head(self, status: HTTPStatus, more: Mapping[str, str]) -> None:
        self.send_response(status)
        for name, value in {**_HEADS, **more}.items():
            self.send_header(name, value)
        self.end_headers()
