# SPDX-License-Identifier: MIT
"""What a server tells while it runs: each event, as a line of text and as data."""

import contextlib
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from pixstep.errors import one_line


class Journal:
    """The log of a server, of all its threads: `row` takes events as data, `write` as lines."""

    def __init__(
        self,
        row: Callable[[Mapping[str, Any]], None] = lambda _: None,
        write: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._row, self._write = row, write
        self._lock = threading.Lock()

    def tell(self, event: str, **facts: Any) -> None:
        """Tell what has happened; an output that was closed is not missed."""
        named = ", ".join(f"{key} {_said(value)}" for key, value in facts.items())
        line = f"{time.strftime('%H:%M:%S')} {event}{': ' if named else ''}{one_line(named)}"
        with self._lock, contextlib.suppress(OSError, ValueError):
            self._row({"time_s": round(time.time(), 3), "event": event, **facts})
            self._write(line)


def _said(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
