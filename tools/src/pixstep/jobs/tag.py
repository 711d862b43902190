# SPDX-License-Identifier: MIT
"""Whose run a board is in, and whether it was reset since: a number in its memory.

Boards have no register of their own for that. `bus_timeout_ms` is kept in memory and is as stored
again after a reset, so the last three digits of it are the tag. Where no line needs the host while
it moves, the time is longer than two lines last: when the host dies, the motors stop at the end of
a line instead of inside.
"""

from __future__ import annotations

import secrets

from pixstep.board.device import Board

NAME = "bus_timeout_ms"
MOST_MS = 60_000
_TAGS = 1000
_SPARE_MS = 1000


def new(stored_ms: int, two_lines_s: float, *, safe: bool) -> int:
    """Return the time with a new tag for a board; 0 for one that waits for ever."""
    if not stored_ms:
        return 0
    least = stored_ms
    if safe:
        least = max(least, int(1000 * two_lines_s) + _SPARE_MS)
    whole = min(least, MOST_MS - _TAGS) // _TAGS * _TAGS + (_TAGS if least % _TAGS else 0)
    return min(whole, MOST_MS - _TAGS) + 1 + secrets.randbelow(_TAGS - 1)


def put(board: Board, tag: int) -> None:
    """Let a board keep a tag, until its next reset."""
    if is_lost(board, tag):
        board.write_setting(NAME, tag)


def is_lost(board: Board, tag: int) -> bool:
    """Return whether a board has lost its tag, by a reset or somebody else's order."""
    return board.setting(NAME) != tag
