# SPDX-License-Identifier: MIT
"""The log of a server that an operation runs: the console's own, or a program's notes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pixstep.operations.desk import Desk

if TYPE_CHECKING:
    from pixstep.server.journal import Log


def log_of(desk: Desk) -> Log:
    """Return where a server tells what happens."""
    return desk.view() if desk.view else _Noted(desk)


class _Noted:
    """The log of a server that a program runs: its notes."""

    def __init__(self, desk: Desk):
        self._desk = desk

    def tell(self, event: str, **facts: Any) -> None:
        """Note what has happened."""
        self._desk.say((f"{event}: {', '.join(f'{key} {facts[key]}' for key in facts)}",))

    def close(self) -> None:
        """Keep what was noted."""
