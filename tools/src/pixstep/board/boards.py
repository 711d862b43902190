# SPDX-License-Identifier: MIT
"""Boards: all that differs between them, as firmware/hal/boards/*.def says it.

The boards there are, are these files.
"""

from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from pixstep import natives
from pixstep.errors import UserError

_MICROSECONDS = 1_000_000


@dataclass(frozen=True)
class Pin:
    """One signal: `axis` is 0 for a signal of the whole board."""

    signal: str
    axis: int
    port: str
    bit: int
    header: str


@dataclass(frozen=True)
class Programmer:
    """What avrdude needs to know of a board's boot loader."""

    part: str
    protocol: str
    baud: int


@dataclass(frozen=True)
class Board:
    """A board: its constants, the timer of each axis and its pins.

    `label` is the name for people, `part` the microcontroller as its maker writes it, `mcu` as the
    compiler does.
    """

    name: str
    label: str
    id: int
    part: str
    mcu: str
    tick_hz: int  # timer ticks a second: CPU cycles a second
    flash_bytes: int
    ram_bytes: int
    queue_entries: int
    all_features: bool  # in its default image; else what a printer's axis needs
    min_interval_ticks: int  # of plain lines, whatever axes move
    smooth_min_interval_ticks: int
    seek_min_interval_ticks: int
    reversal_margin_ticks: int  # of a reversal, beside the driver's set-up and hold times
    min_intervals_ticks: tuple[int, ...]  # of plain lines while one axis moves, two, ...
    smooth_min_intervals_ticks: tuple[int, ...]
    programmer: Programmer
    timers: dict[int, int]
    pins: tuple[Pin, ...]

    @property
    def axes(self) -> int:
        """Number of axes."""
        return len(self.timers)

    @property
    def tick_ns(self) -> float:
        """Length of a timer tick."""
        return 1e9 / self.tick_hz

    def reversal_ticks(self, driver_us: int, tick_hz: int | None = None) -> int:
        """Return the shortest interval with a reversal in its middle (firmware/app/limits.c).

        `driver_us` is the longer of the driver's set-up and hold times.
        """
        driver_ticks = driver_us * (tick_hz or self.tick_hz) // _MICROSECONDS
        return 2 * (driver_ticks + self.reversal_margin_ticks)

    @property
    def mhz_text(self) -> str:
        """The CPU clock in words: "16 MHz"."""
        return f"{self.tick_hz / 1e6:g} MHz"


def load(name: str) -> Board:
    """Return a board; raises UserError for an unknown one."""
    if name not in BOARD_NAMES:
        raise UserError(f"unknown board {name!r}: one of {', '.join(BOARD_NAMES)}")
    return _known()[name]


def all_boards() -> tuple[Board, ...]:
    """Return every board, in the order of their numbers."""
    return tuple(load(name) for name in BOARD_NAMES)


def axes_text(name: str) -> str:
    """Return what axes a board has, in words: "mega has 4 axes: 0 to 3"."""
    count = load(name).axes
    return f"{name} has 1 axis: 0" if count == 1 else f"{name} has {count} axes: 0 to {count - 1}"


@cache
def _known() -> dict[str, Board]:
    """Return all boards by name."""
    return {row["name"]: _board(row) for row in natives.tables()["boards"]}


def _board(row: dict[str, Any]) -> Board:
    """Return a board of its row in the tables."""
    same = {one.name: row[one.name] for one in fields(Board) if one.name in row}
    others = {
        "tick_hz": row["cpu_hz"],
        "all_features": bool(row["all_features"]),
        "min_intervals_ticks": tuple(row["min_intervals_ticks"]),
        "smooth_min_intervals_ticks": tuple(row["smooth_min_intervals_ticks"]),
        "programmer": Programmer(
            row["avrdude_part"], row["avrdude_programmer"], row["avrdude_baud"]
        ),
        "timers": {int(axis): timer for axis, timer in row["timers"].items()},
        "pins": tuple(Pin(**pin) for pin in row["pins"]),
    }
    return Board(**same | others)


BOARD_NAMES = tuple(row["name"] for row in natives.tables()["boards"])
DEFAULT = "uno"  # where a command or a test asks for no board
