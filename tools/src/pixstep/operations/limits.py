# SPDX-License-Identifier: MIT
"""What a board, or a motor of the machine, can do at a pixel frequency."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, TypedDict

from pixstep.board import boards, capability, guarantee, settings
from pixstep.board.capability import DRIVER_US, KINDS, SMOOTH, Capability, Measured
from pixstep.lines.units import (
    ACCELERATION,
    DISTANCE,
    JERK,
    SPEED,
    STEP,
    Quantity,
    Scale,
    number_text,
    unit,
)
from pixstep.operations import shared, showing
from pixstep.operations.asked import AskedError
from pixstep.operations.clocks import OfClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Time, Whole
from pixstep.operations.perform import divider_words
from pixstep.operations.request import operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import generator
from pixstep.profiles.generator import ProfileLimits
from pixstep.profiles.origin import MOST_EDGES
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    import rich.table

_SEEN = 2  # measured clocks that are shown
_EVEN = 2  # steps/px, of which the speeds of a smooth line are multiples


class LineLimits(TypedDict):
    """What a board makes of a kind of lines."""

    kind: str
    min_interval_ticks: int
    max_speed_steps_px: int
    max_rate_steps_s: float
    least_speed_steps_s: float
    least_acceleration_steps_s2: float


class MeasuredRate(TypedDict):
    """The highest rate at which all axes at once made every edge right."""

    motion: str
    pixel_hz: int
    max_rate_steps_s: int


class GuaranteedRate(TypedDict):
    """The highest rate that all axes at once are guaranteed at the pixel frequency asked for.

    `bound_by`: interrupt, processor, ring (how far the board looks ahead) or bus.
    """

    motion: str
    max_speed_steps_px: int
    max_rate_steps_s: int
    bound_by: str


class ReversalLimits(TypedDict):
    """What a reversal needs: the time between its steps, and pixels of rest if it is faster."""

    min_interval_ticks: int
    min_interval_us: float
    max_direct_steps_px: int
    rest_px: int


class ShortestLine(TypedDict):
    """The shortest smooth line that reaches a speed."""

    speed_steps_px: int
    max_acceleration_steps_px2: int
    accelerating_px: int
    pixels: int
    pixels_with_backlash: int
    seconds: float


class BoardLimits(TypedDict):
    """What a board can do at a pixel frequency."""

    board: str
    axes: int
    pixel_hz: str
    tick_hz: int
    pixel_ticks: int
    shortest_pixel_ticks: int
    pixel_hz_least: float
    pixel_hz_most: float
    queue_segments: int
    lines: list[LineLimits]
    guaranteed: list[GuaranteedRate]
    measured: list[MeasuredRate]
    reversal: ReversalLimits
    divider: int
    sync: str
    shortest_line: ShortestLine


@operation("limits")
class ShowLimits(OfClock):
    """Show what a board can do: rates, accelerations, shortest lines, reversals.

    With limits of a motor (options, or those of the machine file) the shortest smooth line that
    reaches its speed, too.
    """

    result = BoardLimits

    board: str = shared.simulated_board()
    axes: int | None = option(Whole(1), "Axes that move at once.", default_text="all")
    sync: str = shared.sync()
    driver_us: int = option(
        Time("us", 1, 1000, int), default=DRIVER_US,
        about="The longer of the board's settings dir_setup_us and dir_hold_us.",
    )  # fmt: skip
    baud: int = shared.board_baud("Rate of the serial line while the axes move.")
    max_speed: Quantity | None = shared.max_speed()
    max_acceleration: Quantity | None = shared.max_acceleration()
    max_jerk: Quantity | None = shared.max_jerk()

    def run(self, desk: Desk) -> Result:
        """Reckon what the board can do."""
        if self.axes and self.axes > boards.load(self.board).axes:
            raise AskedError(f"{{axes}} {self.axes}: {boards.axes_text(self.board)}")
        shared.refuse_baud(self.board, self.baud)
        clock = settings.of_clock(self.sync, self.edges)
        hz = self.line_hz
        able = capability.of(self.board, hz, self.driver_us, self.axes, clock)
        shortest = _shortest(desk, able, self)
        low, high = able.clock_range_hz
        world = guarantee.world(self.board, hz, clock, self.baud)
        guaranteed = _guaranteed(able, world)
        data: BoardLimits = {
            "board": able.board.name,
            "axes": able.axes,
            "pixel_hz": str(hz),
            "tick_hz": able.board.tick_hz,
            "pixel_ticks": able.pixel_ticks,
            "shortest_pixel_ticks": able.shortest_ticks,
            "pixel_hz_least": float(low),
            "pixel_hz_most": float(high),
            "queue_segments": able.board.queue_entries,
            "lines": [
                {
                    "kind": kind,
                    "min_interval_ticks": able.interval_ticks(kind),
                    "max_speed_steps_px": able.top_speed(kind),
                    "max_rate_steps_s": float(able.rate(kind)),
                    "least_speed_steps_s": float(able.least_speed(kind)),
                    "least_acceleration_steps_s2": float(able.least_acceleration(kind)),
                }
                for kind in KINDS
            ],
            "guaranteed": guaranteed,
            "measured": [
                {"motion": row.motion, "pixel_hz": row.pixel_hz, "max_rate_steps_s": row.steps_s}
                for row in capability.measured(able.board.name, able.axes)
            ],
            "reversal": {
                "min_interval_ticks": able.reversal_ticks,
                "min_interval_us": float(able.reversal_s * 1_000_000),
                "max_direct_steps_px": able.direct_reversal_speed,
                "rest_px": able.rest_px,
            },
            "divider": self.edges,
            "sync": self.sync,
            "shortest_line": shortest,
        }
        scale = desk.facts.scale_if_known()
        return Result(data, lambda page: _page(page, data, able, shortest, scale))


def _guaranteed(able: Capability, world: guarantee.LineConditions) -> list[GuaranteedRate]:
    """Return what so many axes are guaranteed at once, for each motion."""
    found: list[GuaranteedRate] = []
    for motion in guarantee.MOTIONS:
        most = able.top_speed(guarantee.decode_of(motion))
        steps = guarantee.rate(motion, able.axes, world, most)
        found.append({
            "motion": motion,
            "max_speed_steps_px": steps,
            "max_rate_steps_s": int(steps * able.pixel_hz),
            "bound_by": guarantee.bound_by(steps, motion, able.axes, world, most),
        })  # fmt: skip
    return found


def _enough_edges(able: Capability, divider: int) -> Iterator[int]:
    """Yield the numbers of clock edges of a pixel in which a board makes a smooth line."""
    clock_hz = able.pixel_hz * divider
    lowest = able.clock_range_hz[0]
    for edges in range(divider + 1, min(MOST_EDGES, int(clock_hz / lowest)) + 1):
        # A lock allows each edge of the clock the same share of its time.
        lock_ticks = able.lock_ticks // divider * edges
        longer = replace(able, pixel_hz=clock_hz / edges, lock_ticks=lock_ticks)
        if longer.top_speed(SMOOTH) >= _EVEN:
            yield edges


def _shortest(desk: Desk, able: Capability, asked: ShowLimits) -> ShortestLine:
    """Return the shortest smooth line: by the board alone, or within limits that are given.

    A smooth line has a pixel up, one at speed and one down at least; backlash needs two more.
    """
    hz = able.pixel_hz
    limits = showing.limits(
        hz, asked.max_speed, asked.max_acceleration, asked.max_jerk, least=_EVEN
    )
    most = able.top_speed(SMOOTH)
    speed = min(limits.get(SPEED, most), most) // 2 * 2
    if speed < _EVEN:
        edges = next(_enough_edges(able, asked.edges), None)
        cure = f": {divider_words(desk, asked.edges_hz, edges)} would do" if edges else ""
        raise AskedError(f"a smooth line needs {_EVEN} steps/px: {most} are the most", cure)
    bounds = ProfileLimits(
        speed,
        generator.legal_limit(Fraction(limits.get(ACCELERATION, speed)), ACCELERATION, hz),
        generator.legal_limit(Fraction(limits.get(JERK, speed)), JERK, hz),
    )
    ramp = generator.shortest_pixels(bounds)
    return {
        "speed_steps_px": speed,
        "max_acceleration_steps_px2": bounds.max_acceleration,
        "accelerating_px": ramp,
        "pixels": 2 * ramp + 1,
        "pixels_with_backlash": 2 * ramp + 3,
        "seconds": float((2 * ramp + 1) / hz),
    }


def _page(
    page: Page, data: BoardLimits, able: Capability, shortest: ShortestLine, scale: Scale | None
) -> None:
    hz, board = able.pixel_hz, able.board
    low, high = able.clock_range_hz
    page.print(
        f"{board.label} at {float(hz):.10g} Hz: {able.pixel_ticks} ticks of {board.tick_ns:g} "
        f"ns a pixel{_clock_text(able, data['divider'])}; the board takes {float(low):.3g} to "
        f"{float(high):.0f} Hz",
        soft_wrap=True,
    )  # fmt: skip
    page.print(_kinds_table(able, None))
    if scale:
        page.print(_kinds_table(able, scale))
    page.print(
        "Most: what the board accepts. Least: smooth lines have even speeds, so that the\n"
        "smallest are 2 f steps/s and 2 f^2 steps/s2; on others f and f^2."
    )
    _rates(page, data["guaranteed"], capability.measured(board.name, able.axes), able)
    _reversal(page, able, scale)
    page.print(
        f"Shortest smooth line at {shortest['speed_steps_px']} {unit(SPEED)}, accelerating by up "
        f"to {shortest['max_acceleration_steps_px2']} {unit(ACCELERATION)}: {shortest['pixels']} "
        f"pixels ({shortest['seconds']:.4g} s), {shortest['accelerating_px']} of them "
        f"accelerating; {shortest['pixels_with_backlash']} with backlash",
        soft_wrap=True,
    )


def _clock_text(able: Capability, divider: int) -> str:
    """Return what pixels are to the clock, if anything but its edges one by one."""
    text = f", {divider} clock edges" if divider > 1 else ""
    if able.lock_ticks:
        text += f", locked to the clock {able.shortest_ticks} at least"
    return text


def _kinds_table(able: Capability, scale: Scale | None) -> rich.table.Table:
    """Return the most and the least of each kind of line, in steps or in the motor's length."""
    length, steps = (scale.length, scale.steps_per_unit) if scale else (STEP, 1)
    speed, acceleration = (unit(order, per_second=True, length=length) for order in (1, 2))
    names = (f"most {speed}", f"least {speed}", f"least {acceleration}")
    table = new_table("lines", *(() if scale else ("most steps/px",)), *names)
    for kind in KINDS:
        figures = (able.rate(kind), able.least_speed(kind), able.least_acceleration(kind))
        row = [number_text(figure / steps) for figure in figures]
        table.add_row(kind, *(() if scale else (str(able.top_speed(kind)),)), *row)
    return table


def _nearest(clocks_hz: Iterable[int], wanted_hz: float) -> list[int]:
    """Return the measured clocks nearest to the one that is asked for, by rising frequency."""
    return sorted(sorted(clocks_hz, key=lambda hz: abs(math.log(hz / wanted_hz)))[:_SEEN])


def _rates(
    page: Page, guaranteed: Sequence[GuaranteedRate], measured: Sequence[Measured], able: Capability
) -> None:
    """Write the rates of so many axes at once, which no rule of a single line tells."""
    clocks = _nearest({row.pixel_hz for row in measured}, float(able.pixel_hz))
    seen = [f"seen, {hz} Hz" for hz in clocks]
    table = new_table("guaranteed", "steps/px", "steps/s", "bound by", *seen)
    known = {row["motion"]: row for row in guaranteed}
    for motion in guarantee.MOTIONS:
        found = {one.pixel_hz: one.steps_s for one in measured if one.motion == motion}
        row = known.get(motion)
        figures = ("-",) * 3 if row is None else (
            str(row["max_speed_steps_px"]), str(row["max_rate_steps_s"]), row["bound_by"],
        )  # fmt: skip
        table.add_row(motion, *figures, *(str(found.get(hz, "-")) for hz in clocks))
    page.print(table)
    page.print(
        f"Guaranteed: {able.axes} {'axes' if able.axes > 1 else 'axis'} at once at this clock, "
        "whatever a host asks meanwhile; `pixstep line check` asks it of lines. Seen: the highest "
        "rates measured at the nearest clocks, every edge right (docs/TIMING.md).",
        soft_wrap=True,
    )


def _reversal(page: Page, able: Capability, scale: Scale | None) -> None:
    most = able.direct_reversal_speed
    page.print(
        f"Reversal: {float(able.reversal_s * 1_000_000):g} us between the steps on both sides "
        f"(drivers of {able.driver_us} us); plain lines may turn from one pixel to the next up "
        f"to {most} steps/px, faster after {able.rest_px} zero pixel"
        f"{'s' if able.rest_px > 1 else ''}",
        soft_wrap=True,
    )
    if scale:
        step = 1 / scale.steps_per_unit
        page.print(f"A step is {number_text(step)} {unit(DISTANCE, length=scale.length)} ({scale})")
