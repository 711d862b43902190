# SPDX-License-Identifier: MIT
"""What the console has for some operations alone: a screen to draw on, a person to ask.

Each is what its operation calls `desk.view`; None where there is no terminal for it.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pixstep.cli import output

if TYPE_CHECKING:
    from pixstep.operations.board import selftest, simulate, watch
    from pixstep.server import journal


def of(words: str, *, as_json: bool) -> Any:
    """Return the view of an operation; None if it has none."""
    make = _VIEWS.get(words)
    return make(as_json) if make else None


def _watch(as_json: bool) -> watch.Screen | None:
    if as_json:
        return None
    from pixstep.cli.board import watchview  # rich takes a while to load

    return watchview.screen()


def _selftest(as_json: bool) -> selftest.AtTerminal:
    from pixstep.cli.board.person import Person  # which other commands do not need

    return Person(as_json=as_json)


def _simulate(as_json: bool) -> simulate.Terminal:
    from pixstep.cli.board.benchview import Terminal  # rich takes a while to load

    return Terminal(as_json=as_json)


def _serve(as_json: bool) -> journal.Write:
    def write(data: Mapping[str, Any], line: str) -> None:
        """Write an event past Python's own buffer, which is waited for at the end."""
        text = json.dumps({"schema": output.SCHEMA, **data}) if as_json else line
        left = f"{text}\n".encode(errors="replace")
        while left:
            left = left[os.write(sys.stdout.fileno(), left) :]

    return write


_VIEWS: dict[str, Callable[[bool], Any]] = {
    "board watch": _watch,
    "board selftest": _selftest,
    "board simulate": _simulate,
    "serve": _serve,
}
