# SPDX-License-Identifier: MIT
"""What a server tells while it runs: each event, as data and as a line of text.

A thread of its own tells it: whoever does not read the log must not stop the bus.
"""

import contextlib
import queue
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from pixstep.errors import one_line

Write = Callable[[Mapping[str, Any], str], None]  # takes an event as data and as a line
_KEPT = 10_000  # events that nobody has read yet; more are lost
_LAST_S = 1.0  # for the events that are left at the end


def _nobody(data: Mapping[str, Any], line: str) -> None:
    """Tell nobody."""


class Journal:
    """The log of a server, of all its threads."""

    def __init__(self, write: Write | None = None) -> None:
        self._write = write or _nobody
        self._events: queue.Queue[tuple[Mapping[str, Any], str] | None] = queue.Queue(_KEPT)
        self._writer = threading.Thread(target=self._tell_all, name="journal", daemon=True)
        self._writer.start()

    def tell(self, event: str, **facts: Any) -> None:
        """Tell what has happened, some time soon."""
        named = ", ".join(f"{key} {_said(value)}" for key, value in facts.items())
        line = f"{time.strftime('%H:%M:%S')} {event}{': ' if named else ''}{one_line(named)}"
        data = {"time_s": round(time.time(), 3), "event": event, **facts}
        with contextlib.suppress(queue.Full):
            self._events.put_nowait((data, line))

    def close(self) -> None:
        """Tell what is left, if anybody reads it."""
        with contextlib.suppress(queue.Full):
            self._events.put_nowait(None)
            self._writer.join(_LAST_S)

    def _tell_all(self) -> None:
        """Tell events to the end; an output that was closed is not missed."""
        while (event := self._events.get()) is not None:
            with contextlib.suppress(OSError, ValueError):
                self._write(*event)


def _said(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
