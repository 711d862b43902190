# SPDX-License-Identifier: MIT
"""Whose run a board is in, and whether it was reset since: its register `tag`.

A reset makes the tag 0. Beside it a board has a time for which its bus may be silent. Where no line
needs the host while it moves, that time is longer than two lines last: when the host dies, the
motors of all boards make what is queued, and stop at the end of the same line.
"""

from __future__ import annotations

import secrets

from pixstep.board.device import Device

NAME, SILENCE = "tag", "bus_timeout_ms"
NONE = 0  # a board's tag after a reset, and when it is in no run
_MOST = 0xFFFF
_MOST_MS = 60_000
_SPARE_MS = 1000


def new() -> int:
    """Return the tag of a run on a board."""
    return 1 + secrets.randbelow(_MOST)


def silence_ms(stored_ms: int, two_lines_s: float, *, safe: bool) -> int:
    """Return how long the bus of a board may be silent while it runs; 0 is for ever."""
    if not (stored_ms and safe):
        return stored_ms
    return min(max(stored_ms, int(1000 * two_lines_s) + _SPARE_MS), _MOST_MS)


def put(board: Device, name: str, value: int) -> None:
    """Let a board keep a tag or a time, until its next reset."""
    if board.setting(name) != value:
        board.write_setting(name, value)


def is_lost(board: Device, tag: int) -> bool:
    """Return whether a board has lost its tag, by a reset or somebody else's order."""
    return board.setting(NAME) != tag
