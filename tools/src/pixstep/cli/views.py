# SPDX-License-Identifier: MIT
"""What the console has for some operations alone: a screen to draw on, a person to ask.

Each is what its operation calls `desk.view`; None where there is no terminal for it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pixstep.operations.board import bring_up, simulate, watch
    from pixstep.server.journal import Log


def of(words: str, *, as_json: bool) -> Any:
    """Return the view of an operation; None if it has none."""
    make = _VIEWS.get(words)
    return make(as_json) if make else None


def _watch(as_json: bool) -> watch.Screen | None:
    if as_json:
        return None
    from pixstep.cli.board import watchview  # rich takes a while to load

    return watchview.screen()


def _selftest(as_json: bool) -> bring_up.AtTerminal:
    from pixstep.cli.board.person import TerminalPerson  # which other commands do not need

    return TerminalPerson(as_json=as_json)


def _simulate(as_json: bool) -> simulate.Terminal:
    from pixstep.cli.board.benchview import BenchTerminal  # rich takes a while to load

    return BenchTerminal(as_json=as_json)


def _serve(as_json: bool) -> Callable[[], Log]:
    from pixstep.server.journal import ServerJournal  # which other commands do not need

    return partial(ServerJournal, as_json=as_json)


def _confirm(as_json: bool) -> Callable[[str], bool] | None:
    """Return what asks a person for a yes, where there is a terminal."""
    if as_json or not sys.stdin or not sys.stdin.isatty():
        return None
    import click

    return lambda text: bool(click.confirm(text, err=True))


_VIEWS: dict[str, Callable[[bool], Any]] = {
    "board watch": _watch,
    "board selftest": _selftest,
    "board simulate": _simulate,
    "job run": _confirm,
    "job resume": _confirm,
    "serve": _serve,
    "ioc": _serve,
}
