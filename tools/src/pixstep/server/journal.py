# SPDX-License-Identifier: MIT
"""What a server writes while it runs: a line for each event, as text or as JSON.

A thread of its own writes: whoever does not read the log must not stop the bus.
"""

import contextlib
import json
import os
import queue
import sys
import threading
import time
from typing import Any, Protocol

from pixstep.errors import one_line

_KEPT = 10_000  # lines that nobody has read yet; more are lost
_LAST_S = 1.0  # for the lines that are left at the end


class Log(Protocol):
    """Where a server tells what happens."""

    def tell(self, event: str, **facts: Any) -> None:
        """Tell what has happened, some time soon."""

    def close(self) -> None:
        """Let go of it."""


class ServerJournal:
    """The log on the standard output."""

    def __init__(self, *, as_json: bool = False) -> None:
        self._as_json = as_json
        self._output: int | None = None
        with contextlib.suppress(OSError):  # an output that is no file has none
            self._output = sys.stdout.fileno()
        self._lines: queue.Queue[str | None] = queue.Queue(_KEPT)
        self._writer = threading.Thread(target=self._write, name="journal", daemon=True)
        self._writer.start()

    def tell(self, event: str, **facts: Any) -> None:
        """Write what has happened, some time soon."""
        if self._as_json:
            line = json.dumps({"time_s": round(time.time(), 3), "event": event, **facts})
        else:
            named = ", ".join(f"{key} {_said(value)}" for key, value in facts.items())
            line = f"{time.strftime('%H:%M:%S')} {event}{': ' if named else ''}{one_line(named)}"
        with contextlib.suppress(queue.Full):
            self._lines.put_nowait(line)

    def close(self) -> None:
        """Write what is left, if anybody reads it."""
        with contextlib.suppress(queue.Full):
            self._lines.put_nowait(None)
            self._writer.join(_LAST_S)

    def _write(self) -> None:
        """Write lines to the end; an output that was closed is not missed."""
        while (line := self._lines.get()) is not None:
            with contextlib.suppress(OSError):
                self._put(f"{line}\n")

    def _put(self, text: str) -> None:
        """Write past Python's own buffer, for which a program would wait at its end."""
        if self._output is None:
            sys.stdout.write(text)
            return
        data = text.encode(errors="replace")
        while data:
            data = data[os.write(self._output, data) :]


def _said(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
