# SPDX-License-Identifier: MIT
"""Boards: the axes and pins of firmware/hal/boards/*.def."""

from dataclasses import dataclass

from pixstep import natives
from pixstep.board.deffiles import read_rows
from pixstep.errors import UserError

BOARD_NAMES = ("uno", "mega")
PARTS = {"uno": "ATmega328P", "mega": "ATmega2560"}
RAM_BYTES = {"uno": 2048, "mega": 8192}
FLASH_BYTES = {"uno": 32_768, "mega": 262_144}


@dataclass(frozen=True)
class Pin:
    """One signal: `axis` is 0 for a signal of the whole board."""

    signal: str
    axis: int
    port: str
    bit: int
    header: str


@dataclass(frozen=True)
class Board:
    """A board: the timer of each axis and its pins."""

    name: str
    timers: dict[int, int]
    pins: tuple[Pin, ...]

    @property
    def axes(self) -> int:
        """Number of axes."""
        return len(self.timers)


def load(name: str) -> Board:
    """Read a board's table; raises UserError for an unknown board or row."""
    if name not in BOARD_NAMES:
        raise UserError(f"unknown board {name!r}: one of {', '.join(BOARD_NAMES)}")
    timers: dict[int, int] = {}
    pins = []
    for row in read_rows(natives.source(f"firmware/hal/boards/{name}.def")):
        if row.macro == "BOARD_AXIS" and len(row.arguments) == 2:
            timers[row.arguments[0]] = row.arguments[1]
        elif row.macro == "BOARD_PIN" and len(row.arguments) == 5:
            pins.append(Pin(*row.arguments))
        else:
            raise UserError(f"{row.where}: unknown row {row.macro}")
    return Board(name, timers, tuple(pins))


def axes_text(name: str) -> str:
    """Return what axes a board has, in words: "mega has 4 axes: 0 to 3"."""
    count = load(name).axes
    return f"{name} has 1 axis: 0" if count == 1 else f"{name} has {count} axes: 0 to {count - 1}"
