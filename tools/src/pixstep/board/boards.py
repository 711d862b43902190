# SPDX-License-Identifier: MIT
"""Boards: all that differs between them, read from firmware/hal/boards/*.def.

The boards there are, are these files. Each begins with constants, `#define BOARD_NAME value`, and
goes on with rows for axes and pins.
"""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pixstep import natives
from pixstep.board.deffiles import read_rows
from pixstep.errors import UserError

_FOLDER = "firmware/hal/boards"
_CONSTANT = re.compile(r"^#define[ \t]+BOARD_(\w+)[ \t]+(\"[^\"\n]*\"|\w+)", re.MULTILINE)


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
    min_interval_ticks: int  # of plain lines
    smooth_min_interval_ticks: int
    seek_min_interval_ticks: int
    reversal_margin_ticks: int  # of a reversal, beside the driver's set-up and hold times
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

    @property
    def mhz_text(self) -> str:
        """The CPU clock in words: "16 MHz"."""
        return f"{self.tick_hz / 1e6:g} MHz"


def load(name: str) -> Board:
    """Return a board; raises UserError for an unknown board, a missing constant or a wrong row."""
    if name not in BOARD_NAMES:
        raise UserError(f"unknown board {name!r}: one of {', '.join(BOARD_NAMES)}")
    return _read(natives.source(f"{_FOLDER}/{name}.def"))


def all_boards() -> tuple[Board, ...]:
    """Return every board, in the order of their numbers."""
    return tuple(load(name) for name in BOARD_NAMES)


def axes_text(name: str) -> str:
    """Return what axes a board has, in words: "mega has 4 axes: 0 to 3"."""
    count = load(name).axes
    return f"{name} has 1 axis: 0" if count == 1 else f"{name} has {count} axes: 0 to {count - 1}"


@cache
def _read(path: Path) -> Board:
    """Read a board's file."""
    constants = _constants(path)

    def number(name: str) -> int:
        try:
            return int(text(name), 0)
        except ValueError:
            raise UserError(f"{path}: BOARD_{name} is not a number") from None

    def text(name: str) -> str:
        if name not in constants:
            raise UserError(f"{path}: BOARD_{name} is missing")
        return constants[name]

    timers, pins = _rows(path)
    if len(timers) != number("AXES"):
        raise UserError(f"{path}: BOARD_AXES is {number('AXES')}, {len(timers)} rows BOARD_AXIS")
    return Board(
        name=text("NAME"),
        label=text("LABEL"),
        id=number("ID"),
        part=text("PART"),
        mcu=text("MCU"),
        tick_hz=number("CPU_HZ"),
        flash_bytes=number("FLASH_BYTES"),
        ram_bytes=number("RAM_BYTES"),
        queue_entries=number("QUEUE_ENTRIES"),
        all_features=bool(number("ALL_FEATURES")),
        min_interval_ticks=number("MIN_INTERVAL_TICKS"),
        smooth_min_interval_ticks=number("SMOOTH_MIN_INTERVAL_TICKS"),
        seek_min_interval_ticks=number("SEEK_MIN_INTERVAL_TICKS"),
        reversal_margin_ticks=number("REVERSAL_MARGIN_TICKS"),
        programmer=Programmer(
            text("AVRDUDE_PART"), text("AVRDUDE_PROGRAMMER"), number("AVRDUDE_BAUD")
        ),
        timers=timers,
        pins=pins,
    )


def _constants(path: Path) -> dict[str, str]:
    """Return the constants of a board's file, without the quotes of texts."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    return {name: value.strip('"') for name, value in _CONSTANT.findall(text)}


def _rows(path: Path) -> tuple[dict[int, int], tuple[Pin, ...]]:
    """Return the timer of each axis, and the pins."""
    timers: dict[int, int] = {}
    pins = []
    for row in read_rows(path):
        if row.macro == "BOARD_AXIS" and len(row.arguments) == 2:
            timers[row.arguments[0]] = row.arguments[1]
        elif row.macro == "BOARD_PIN" and len(row.arguments) == 5:
            pins.append(Pin(*row.arguments))
        else:
            raise UserError(f"{row.where}: unknown row {row.macro}")
    return timers, tuple(pins)


def _names() -> tuple[str, ...]:
    """Return the names of all boards by their numbers; none outside of a clone."""
    paths = (natives.root() / _FOLDER).glob("*.def")
    numbered = sorted((int(_constants(path).get("ID", "0"), 0), path.stem) for path in paths)
    return tuple(name for _, name in numbered)


BOARD_NAMES = _names()
DEFAULT = "uno"  # where a command or a test asks for no board
