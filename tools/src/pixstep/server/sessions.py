# SPDX-License-Identifier: MIT
"""The clients of a server: who they are, which of them may write, and what each of them moves."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from pixstep.server.messages import RequestMeaning

LAPSE_S = 10.0  # without a request: another client may write

Axes = set[tuple[int, int]]  # unit and axis
Tell = Callable[..., None]


@dataclass(eq=False)
class ClientSession:
    """A client: `name` is its command and process, or the address of one on the network.

    `axes` are those that it was the last one to arm, or to queue a line for.
    """

    name: str
    door: str
    since_s: float = field(default_factory=time.time)
    last_s: float = field(default_factory=time.monotonic)
    requests: int = 0
    open: set[int] = field(default_factory=set)  # numbers of requests without an answer
    axes: Axes = field(default_factory=set)
    writes_since_s: float = 0.0

    def clock(self) -> str:
        """Return since when it writes, as the time of day."""
        return time.strftime("%H:%M:%S", time.localtime(self.writes_since_s))


class Sessions:
    """All clients; `tell` is told what happens to them."""

    def __init__(self, tell: Tell) -> None:
        self._lock = threading.Lock()
        self._tell = tell
        self.all: list[ClientSession] = []
        self.writer: ClientSession | None = None

    def enter(self, session: ClientSession) -> None:
        """Take a client in."""
        with self._lock:
            self.all.append(session)
        self._tell("connected", client=session.name, door=session.door)

    def leave(self, session: ClientSession) -> Axes:
        """Let a client go; return the axes that it has moved last."""
        with self._lock:
            self.all.remove(session)
            if self.writer is session:
                self.writer = None
            left, session.axes = session.axes, set()
        self._tell("disconnected", client=session.name, requests=session.requests)
        return left

    def claim(self, session: ClientSession) -> str:
        """Let a client write from now on; return who does instead, or "" if it may.

        The right to write ends with the client, or when it has asked for nothing for LAPSE_S.
        """
        with self._lock:
            other = self.writer
            if other is session:
                return ""
            if other and (other.open or time.monotonic() - other.last_s < LAPSE_S):
                return f"{other.name} has the right to write since {other.clock()}"
            self.writer = session
            session.writes_since_s = time.time()
        self._tell("writer", client=session.name)
        return ""

    def is_driven(self, session: ClientSession) -> bool:
        """Return whether another client moves axes, whose stream others must not keep waiting."""
        with self._lock:
            return any(other.axes for other in self.all if other is not session)

    def drive(self, session: ClientSession, unit: int, meaning: RequestMeaning) -> None:
        """Note whose lines the axes of a request carry from now on."""
        mask = meaning.drives
        axes = {(unit, axis) for axis in range(mask.bit_length()) if mask >> axis & 1}
        with self._lock:
            for other in self.all:
                other.axes -= axes
            session.axes |= axes

    def disown(self, session: ClientSession, unit: int | None = None) -> Axes:
        """Return the axes that a client has moved last, of all units if no other is given.

        They are nobody's from now on.
        """
        with self._lock:
            left = {item for item in session.axes if unit in (None, item[0])}
            session.axes -= left
        return left

    def present(self) -> list[ClientSession]:
        """Return all clients."""
        with self._lock:
            return list(self.all)
