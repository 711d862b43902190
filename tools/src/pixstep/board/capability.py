# SPDX-License-Identifier: MIT
"""What a board can do at a pixel frequency: rates, speeds, accelerations, reversals.

The rules are those of the board's own line check (firmware/core/motion/line_check.c). What several
axes make at once is measured, not a rule: a line above it may end in the fault decoder_late.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path

from pixstep.board import boards, limits
from pixstep.board.boards import Board
from pixstep.lines.line_check import MAX_COUNT
from pixstep.lines.units import PERIOD_TICKS

PLAIN, SMOOTH, SEEK = "plain", "smooth", "seek"
KINDS = (PLAIN, SMOOTH, SEEK)
MOTIONS = ("constant", "smooth", "ramp")
DRIVER_US = 20  # dir_setup_us and dir_hold_us of a board as delivered
_DATA = Path(__file__).resolve().parents[1] / "data" / "rates.toml"


@dataclass(frozen=True)
class Measured:
    """The highest rate at which `axes` axes at once made every edge right."""

    board: str
    axes: int
    motion: str
    pixel_hz: int
    steps_s: int


@dataclass(frozen=True)
class Capability:
    """A board at a pixel frequency, with drivers that need `driver_us` around a reversal.

    `axes` is the number of axes that move together. Pixels locked to the clock may be `lock_ticks`
    shorter than nominal.
    """

    board: Board
    pixel_hz: Fraction
    driver_us: int = DRIVER_US
    axes: int = 1
    lock_ticks: int = 0

    @property
    def pixel_ticks(self) -> int:
        """Whole ticks of a pixel: intervals are judged without the fraction."""
        return int(self.board.tick_hz / self.pixel_hz)

    @property
    def shortest_ticks(self) -> int:
        """Whole ticks of the shortest pixel, by which intervals are judged."""
        return int(self.board.tick_hz / self.pixel_hz - self.lock_ticks)

    def interval_ticks(self, kind: str) -> int:
        """Return the shortest interval between two steps of a kind of line."""
        return {
            PLAIN: self.board.min_intervals_ticks[self.axes - 1],
            SMOOTH: self.board.smooth_min_intervals_ticks[self.axes - 1],
            SEEK: self.board.seek_min_interval_ticks,
        }[kind]

    def top_speed(self, kind: str) -> int:
        """Return the highest speed that the board accepts, steps/pixel; even of a smooth line."""
        speed = min(self.shortest_ticks // self.interval_ticks(kind), MAX_COUNT)
        return speed // 2 * 2 if kind == SMOOTH else speed

    def rate(self, kind: str) -> Fraction:
        """Return the same in steps/s."""
        return self.top_speed(kind) * self.pixel_hz

    def least_speed(self, kind: str) -> Fraction:
        """Return the lowest constant speed, and the step from one to the next, steps/s."""
        return (2 if kind == SMOOTH else 1) * self.pixel_hz

    def least_acceleration(self, kind: str) -> Fraction:
        """Return the smallest acceleration that is not 0, steps/s2.

        Speeds at pixel edges of a smooth line are even, so that they differ by 2 steps/px or more.
        """
        return (2 if kind == SMOOTH else 1) * self.pixel_hz**2

    @property
    def reversal_ticks(self) -> int:
        """Shortest interval between two steps of opposite direction."""
        return self.board.reversal_ticks(self.driver_us)

    @property
    def reversal_s(self) -> Fraction:
        """The same in seconds."""
        return Fraction(self.reversal_ticks, self.board.tick_hz)

    @property
    def direct_reversal_speed(self) -> int:
        """Highest count of a plain pixel right behind one of the other direction, steps/px."""
        return min(self.shortest_ticks // self.reversal_ticks, MAX_COUNT)

    @property
    def rest_px(self) -> int:
        """Zero pixels between two directions with which any speed may follow."""
        return -(-self.reversal_ticks // self.shortest_ticks)

    @property
    def clock_range_hz(self) -> tuple[Fraction, Fraction]:
        """Lowest and highest pixel frequency of the board."""
        shortest, longest = PERIOD_TICKS
        return Fraction(self.board.tick_hz, longest), Fraction(self.board.tick_hz, shortest)


def of(
    name: str,
    pixel_hz: Fraction,
    driver_us: int = DRIVER_US,
    axes: int | None = None,
    clock: Mapping[str, int] | None = None,
) -> Capability:
    """Return what a board can do. Raises UserError for a frequency that it cannot follow.

    Without `axes` all axes of the board move together; `clock` is as for `limits.named`.
    """
    board = boards.load(name)
    found = limits.named(name, pixel_hz, clock=clock)
    return Capability(board, pixel_hz, driver_us, axes or board.axes, found.lock_ticks)


def measured(board: str, axes: int) -> tuple[Measured, ...]:
    """Return the rates measured with so many axes of a board at once."""
    return tuple(row for row in all_measured() if (row.board, row.axes) == (board, axes))


@cache
def all_measured() -> tuple[Measured, ...]:
    """Return every rate that was measured."""
    rows = tomllib.loads(_DATA.read_text(encoding="utf-8"))["rates"]
    return tuple(Measured(*row) for row in rows)
