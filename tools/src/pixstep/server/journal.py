# SPDX-License-Identifier: MIT
"""What a server writes while it runs: a line for each event, as text or as JSON."""

import contextlib
import json
import sys
import threading
import time
from typing import Any

from pixstep.errors import one_line


class Journal:
    """The log on the standard output; threads write whole lines."""

    def __init__(self, *, as_json: bool = False) -> None:
        self._as_json = as_json
        self._lock = threading.Lock()

    def tell(self, event: str, **facts: Any) -> None:
        """Write what has happened; an output that was closed is not missed."""
        if self._as_json:
            line = json.dumps({"time_s": round(time.time(), 3), "event": event, **facts})
        else:
            named = ", ".join(f"{key} {_said(value)}" for key, value in facts.items())
            line = f"{time.strftime('%H:%M:%S')} {event}{': ' if named else ''}{one_line(named)}"
        with self._lock, contextlib.suppress(OSError, ValueError):
            sys.stdout.write(line + "\n")
            sys.stdout.flush()


def _said(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
