# SPDX-License-Identifier: MIT
"""Boards: all that differs between them, as firmware/avr/boards/*.def says; what images have.

The boards there are, are these files. What an image was built with (firmware/build_features.def) a
board says in its input registers `features` and `features_high`; what needs a missing one is
refused before anything is sent.

A gated pixel clock has bursts of edges, one for each line, with rests between them. Line zero is
`gate_edges` (a board's setting) behind a burst's first edge. The board needs some of them to give a
line its place, so that there is a least number for each frequency.
"""

from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cache
from typing import Any

from pixstep import natives
from pixstep.board.errors import MissingFeatureError
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
class BoardKind:
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
        """Return the shortest interval with a reversal in its middle (firmware/app/axes/limits.c).

        `driver_us` is the longer of the driver's set-up and hold times.
        """
        driver_ticks = driver_us * (tick_hz or self.tick_hz) // _MICROSECONDS
        return 2 * (driver_ticks + self.reversal_margin_ticks)

    @property
    def mhz_text(self) -> str:
        """The CPU clock in words: "16 MHz"."""
        return f"{self.tick_hz / 1e6:g} MHz"


def load(name: str) -> BoardKind:
    """Return a board; raises UserError for an unknown one."""
    if name not in BOARD_NAMES:
        raise UserError(f"unknown board {name!r}: one of {', '.join(BOARD_NAMES)}")
    return _known()[name]


def all_boards() -> tuple[BoardKind, ...]:
    """Return every board, in the order of their numbers."""
    return tuple(load(name) for name in BOARD_NAMES)


def axes_text(name: str) -> str:
    """Return what axes a board has, in words: "mega has 4 axes: 0 to 3"."""
    count = load(name).axes
    return f"{name} has 1 axis: 0" if count == 1 else f"{name} has {count} axes: 0 to {count - 1}"


@cache
def _known() -> dict[str, BoardKind]:
    """Return all boards by name."""
    return {row["name"]: _board(row) for row in natives.tables()["boards"]}


def _board(row: dict[str, Any]) -> BoardKind:
    """Return a board of its row in the tables."""
    same = {one.name: row[one.name] for one in fields(BoardKind) if one.name in row}
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
    return BoardKind(**same | others)


BOARD_NAMES = tuple(row["name"] for row in natives.tables()["boards"])
DEFAULT = "uno"  # where a command or a test asks for no board


FEATURES = "features"
FEATURES_HIGH = "features_high"
_HIGH_BIT = 16  # the first one of them

# Registers that say nothing, and settings that change nothing, without a feature.
FEATURE_OF_REGISTERS = {
    "edge_error_ticks": "clock_statistics",
    "edge_error_max_ticks": "clock_statistics",
    "trip_code": "homing",
    "trip_axis": "homing",
    "trip_position_steps": "homing",
    "trip_ticks": "homing",
    "settings_serial": "store",
    "settings_state": "store",
    "idle_off_ms": "driver_timing",
    "enable_settle_ms": "driver_timing",
    "backlash_policy": "backlash",
    "gate_edges": "gate",
    "home_is_limit": "shared_switch",
    "silence_waits": "line_ends",
    "clock_out_hz": "clock_out",
}


@dataclass(frozen=True)
class FirmwareFeature:
    """A row of the table: its bit in the registers of features, its name, what it is."""

    bit: int
    name: str
    meaning: str


@cache
def features() -> tuple[FirmwareFeature, ...]:
    """Return all features, in the order of their bits."""
    return tuple(FirmwareFeature(**row) for row in natives.tables()["features"])


def feature_named(name: str) -> FirmwareFeature:
    """Return a feature by name; raises UserError if there is none."""
    for feature in features():
        if feature.name == name:
            return feature
    raise UserError(f"there is no feature {name!r}")


def feature_names(low: int, high: int = 0) -> frozenset[str]:
    """Return the names of the features of the two registers' values."""
    word = low | high << _HIGH_BIT
    return frozenset(feature.name for feature in features() if word >> feature.bit & 1)


def missing_feature(unit: int, name: str) -> MissingFeatureError:
    """Return the error for a board without a feature."""
    feature = feature_named(name)
    cure = _OTHER_CLOCK if name == CLOCK_OUT_FEATURE else ""
    return MissingFeatureError(unit, feature.name, feature.bit, feature.meaning + cure)


# A clock that a board makes itself: its timer counts once in so many ticks.
CLOCK_OUT_SETTING = "clock_out_hz"
CLOCK_OUT_FEATURE = "clock_out"
MOST_CLOCK_OUT_HZ = 2000
CLOCK_OUT_SHARE = 0.01  # of the frequency that lines expect, by which it may be off
_CLOCK_OUT_TICKS = 64
_OTHER_CLOCK = (
    ": another image makes one (docs/WIRING.md, A clock to try with); a line with `--sync free` "
    "needs no clock"
)


def clock_out_hz(asked_hz: int, tick_hz: int) -> Fraction:
    """Return the exact frequency that a board makes of setting `clock_out_hz`, which is not 0."""
    counts_hz = tick_hz // _CLOCK_OUT_TICKS
    return Fraction(counts_hz, (counts_hz + asked_hz // 2) // asked_hz)


def clock_out_of(name: str, asked_hz: int) -> Fraction:
    """Return the exact frequency that a board of a kind makes of the setting."""
    return clock_out_hz(asked_hz, load(name).tick_hz)


GATE_SETTING = "gate_edges"
GATE_FEATURE = "gate"
MOST_GATE_EDGES = 1000
# What the firmware has: PLACE_TICKS of app/axes/reference.c, CLOCK_FILTER_FRESH_EDGES of
# clock/clock_filter.h.
_PLACE_TICKS = 0x14000
_FRESH_EDGES = 3


def least_gate_edges(clock_hz: Fraction, tick_hz: int, *, locked: bool) -> int:
    """Return the least `gate_edges` with which lines can be armed."""
    return _PLACE_TICKS // int(tick_hz / clock_hz) + 1 + (_FRESH_EDGES if locked else 0)


def refuse_gate(gate_edges: int, clock_hz: Fraction, tick_hz: int, *, locked: bool) -> None:
    """Raise UserError for a number of edges with which a board arms no line; 0 is no gate."""
    least = least_gate_edges(clock_hz, tick_hz, locked=locked)
    if 0 < gate_edges < least:
        raise UserError(gate_text(gate_edges, clock_hz, least, locked=locked))


def gate_text(gate_edges: int, clock_hz: Fraction, least: int, *, locked: bool) -> str:
    """Return what is wrong with too few edges."""
    return (
        f"gate_edges {gate_edges}: at {float(clock_hz):.10g} Hz a line{' that is locked' * locked} "
        f"can begin {least} edges after the first edge of a burst at the earliest"
    )
