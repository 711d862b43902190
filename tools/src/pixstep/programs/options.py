# SPDX-License-Identifier: MIT
"""How a program is planned; cheap to import."""

from dataclasses import dataclass

MODE1, LOOKAHEAD = "mode1", "lookahead"
MODES = (MODE1, LOOKAHEAD)
WINDOW = 1024  # moves
MOST_WINDOW = 1_000_000
SEGMENT_MS = (0, 255)  # of a circle: the shortest, 0 for none, and the longest


@dataclass(frozen=True)
class Options:
    """`window` is for lookahead, in moves; `assume_last` for mode1."""

    mode: str = LOOKAHEAD
    window: int = WINDOW
    assume_last: bool = True
