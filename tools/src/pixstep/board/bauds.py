# SPDX-License-Identifier: MIT
"""Rates of a board's serial port: those that its setting `baud_100` takes.

A port divides the board's clock by whole numbers, so that it makes few rates exactly. The setting
takes what the port comes within 2.5 % of, as firmware/core/wire/baud.c has it.
"""

from collections.abc import Iterator
from itertools import islice

from pixstep.board import boards
from pixstep.board import registers as regs

_STEP = 100  # of the setting
_BIT_CYCLES = 8  # of the clock for the shortest bit


def setting_range() -> tuple[int, int]:
    """Return the lowest and the highest rate that the setting can hold, baud."""
    held = regs.register_map().holding("baud_100")
    return _STEP * (held.minimum or 0), _STEP * (held.maximum or 0)


def is_made(board: str, baud: int) -> bool:
    """Whether a board comes within 2.5 % of a rate, a multiple of 100 in the setting's range."""
    clock = boards.load(board).tick_hz // _BIT_CYCLES
    made = (clock + baud // 2) // baud * baud
    return 39 * made <= 40 * clock < 41 * made


def refusal(board: str, baud: int) -> str | None:
    """Return why a board does not take a rate, and the nearest that it takes; None if it does."""
    if is_made(board, baud):
        return None
    near = " and ".join(map(str, _nearest(board, baud)))
    return f"the {board} cannot make {baud} baud within 2.5 %: {near} would do"


def _nearest(board: str, baud: int) -> Iterator[int]:
    """Yield the nearest rate below, and above, where there is one."""
    least, most = setting_range()
    for rates in (range(baud, least - 1, -_STEP), range(baud, most + 1, _STEP)):
        yield from islice((rate for rate in rates if is_made(board, rate)), 1)
