# SPDX-License-Identifier: MIT
"""What a board can do at a pixel frequency: rates, speeds, accelerations, reversals.

The rules are those of the board's own line check (firmware/core/line/line_check.c). What several
axes make at once is measured, not a rule: a line above it may end in the fault decoder_late.
What a board lets a line do is asked of a connected board, or is in the table of a named one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path

from pixstep.board import boards, settings, values
from pixstep.board.device import Device
from pixstep.lines import line_check
from pixstep.lines.core import CoreLimits
from pixstep.lines.line import Line
from pixstep.lines.line_check import MAX_COUNT, Finding, Limits
from pixstep.lines.units import PERIOD_TICKS, period_ticks, refuse_periods

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

    board: boards.BoardKind
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
    found = named_limits(name, pixel_hz, clock=clock)
    return Capability(board, pixel_hz, driver_us, axes or board.axes, found.lock_ticks)


def measured(board: str, axes: int) -> tuple[Measured, ...]:
    """Return the rates measured with so many axes of a board at once."""
    return tuple(row for row in all_measured() if (row.board, row.axes) == (board, axes))


@cache
def all_measured() -> tuple[Measured, ...]:
    """Return every rate that was measured."""
    import tomllib

    rows = tomllib.loads(_DATA.read_text(encoding="utf-8"))["rates"]
    return tuple(Measured(*row) for row in rows)


_ADVICE = "nothing was sent; `pixstep line check` shows all"


@dataclass(frozen=True)
class BoardCapability:
    """The limits of a board at a frequency of pixels, its settings included.

    Intervals are in timer ticks: the shortest ones of plain lines, of smooth lines, of seeks, and
    the shortest one between two steps of opposite direction. A setting that is 0 is no limit.
    """

    pixel_hz: Fraction
    tick_hz: int
    min_interval_ticks: int
    smooth_min_interval_ticks: int
    seek_min_interval_ticks: int
    reversal_ticks: int
    max_acceleration: int
    start_stop_steps: int
    lock_ticks: int = 0  # a pixel that is locked to the clock may be so much shorter than nominal

    def of(self, line: Line) -> Limits:
        """Return the limits for a line's decode rule."""
        smallest = self.smooth_min_interval_ticks if line.smooth else self.min_interval_ticks
        return Limits(
            # The board asks the acceleration of smooth lines only, reversals of plain ones.
            max_acceleration=(self.max_acceleration or None) if line.smooth else None,
            start_stop=None if line.smooth else (self.start_stop_steps or None),
            min_interval_ticks=smallest,
            period_ticks=self.shortest_ticks,
            reversal_ticks=self.reversal_ticks,
        )

    @property
    def shortest_ticks(self) -> Fraction:
        """The shortest pixel that there may be."""
        return period_ticks(self.pixel_hz, self.tick_hz) - self.lock_ticks

    def of_core(self) -> CoreLimits:
        """Return the limits as the firmware's core takes them."""
        return CoreLimits(
            int(self.shortest_ticks),
            self.min_interval_ticks,
            self.smooth_min_interval_ticks,
            self.seek_min_interval_ticks,
            self.reversal_ticks,
            self.max_acceleration,
            self.start_stop_steps,
        )


def named_limits(
    name: str,
    pixel_hz: Fraction,
    tick_hz: int | None = None,
    axes: int = 1,
    clock: Mapping[str, int] | None = None,
) -> BoardCapability:
    """Return the limits of a board with its default settings; at another timer's rate if given.

    `axes` is the number of axes that move together: the more, the longer the shortest intervals.
    `clock` are the settings of the pixel clock that differ: `sync` and `divider`.
    Raises UserError for an unknown board, and for a pixel frequency that a board cannot carry.
    """
    board = boards.load(name)
    rate = tick_hz or board.tick_hz
    known = settings.defaults() | dict(clock or {})
    locked = settings.locks(known)
    refuse_periods(pixel_hz, settings.divider_of(known), rate, locked=locked)
    return BoardCapability(
        pixel_hz,
        rate,
        board.min_intervals_ticks[axes - 1],
        board.smooth_min_intervals_ticks[axes - 1],
        board.seek_min_interval_ticks,
        board.reversal_ticks(_driver_us(known), rate),
        known["max_acceleration"],
        known["start_stop_steps"],
        lock_ticks(known, pixel_hz, rate),
    )


def connected_limits(
    board: Device,
    pixel_hz: Fraction | None = None,
    axes: int = 1,
    clock: Mapping[str, int] | None = None,
) -> BoardCapability:
    """Ask a board for its limits; at another frequency of pixels than its own if one is given.

    `axes` is the number of axes that move together: a board with fewer has the limits of its own.
    `clock` are the settings `sync` and `divider` that it is to have then. No register has the
    intervals of seeks and reversals: they are those of the board's table, and 0 where the tables
    have no such board.
    """
    state, known = board.inputs(), settings.read(board) | dict(clock or {})
    table = next((item for item in boards.all_boards() if item.id == state["board_id"]), None)
    rate = board.tick_hz()
    hz = pixel_hz or values.hz_of(known) / settings.divider_of(known)
    return BoardCapability(
        hz,
        rate,
        state[_of_axes("min_interval", axes, state)],
        state[_of_axes("smooth_min_interval", axes, state)],
        table.seek_min_interval_ticks if table else 0,
        table.reversal_ticks(_driver_us(known)) if table else 0,
        known["max_acceleration"],
        known["start_stop_steps"],
        lock_ticks(known, hz, rate),
    )


def check_line(
    line: Line, found: BoardCapability, motor: Limits | None = None, advice: str = _ADVICE
) -> list[Finding]:
    """Return the findings of a line, by the limits of its board and of its motor.

    Raises RefusedError naming the first that refuses it, with `advice` behind.
    """
    findings = line_check.check(line, found.of(line).lower(motor or Limits()))
    line_check.raise_if_refused(line.name, findings, advice)
    return findings


def lock_ticks(known: Mapping[str, int], pixel_hz: Fraction, tick_hz: int) -> int:
    """Return how much shorter a pixel may be than nominal by the board's settings.

    Of lines that are not locked to the clock 0; of others what the board's grid allows.
    """
    if not settings.locks(known):
        return 0
    edges = known["divider"]
    clock_ticks = int(period_ticks(pixel_hz * edges, tick_hz))
    tolerated = clock_ticks // (1_000_000 // known["lock_tolerance_ppm"]) + 1
    return (tolerated + tolerated // 64 + 1) * edges


def _of_axes(name: str, axes: int, state: Mapping[str, int]) -> str:
    """Return the register of a shortest interval: there is one for each number of axes but all."""
    return f"{name}_{axes}_ticks" if axes < state["axis_count"] else f"{name}_ticks"


def _driver_us(known: Mapping[str, int]) -> int:
    return max(known["dir_setup_us"], known["dir_hold_us"])
