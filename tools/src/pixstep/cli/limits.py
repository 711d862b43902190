# SPDX-License-Identifier: MIT
"""`pixstep limits`: what a board, or a motor of the machine, can do at a pixel frequency."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from pixstep.board import boards, capability, settings
from pixstep.board.capability import DRIVER_US, KINDS, MOTIONS, SMOOTH, Capability, Measured
from pixstep.cli.clockoptions import divider_option, sync_option
from pixstep.cli.command import command
from pixstep.cli.options import Facts, json_option, pixel_hz_option, show_json
from pixstep.cli.quantities import (
    LimitOptions,
    TimeType,
    limit_options,
    scale_if_known,
    whole_limit,
)
from pixstep.errors import UserError
from pixstep.lines.units import ACCELERATION, DISTANCE, JERK, SPEED, STEP, Scale, number_text, unit
from pixstep.profiles import make
from pixstep.profiles.madefor import MOST_EDGES
from pixstep.profiles.make import ProfileLimits
from pixstep.simulation.report import new_console, new_table

if TYPE_CHECKING:
    import rich.console
    import rich.table

_EVEN = 2  # steps/px, of which the speeds of a smooth line are multiples


@command("limits")
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--axes", type=click.IntRange(1), help="Axes that move at once.  [default: all]")
@pixel_hz_option
@divider_option
@sync_option
@click.option(
    "--driver-us",
    type=TimeType("us", 1, 1000, int),
    default=str(DRIVER_US),
    show_default=True,
    help="The longer of the board's settings dir_setup_us and dir_hold_us.",
)
@limit_options
@json_option
@click.pass_context
def limits_command(
    ctx: click.Context,
    board: str,
    axes: int | None,
    pixel_hz: Fraction,
    divider: int,
    sync: str,
    driver_us: int,
    as_json: bool,
    **limits: Unpack[LimitOptions],
) -> None:
    """Show what a board can do: rates, accelerations, shortest lines, reversals.

    With limits of a motor (options, or those of the machine file) the shortest smooth line that
    reaches its speed, too.
    """
    if axes and axes > boards.load(board).axes:
        raise UserError(f"--axes {axes}: {boards.axes_text(board)}")
    clock = settings.of_clock(sync, divider)
    able = capability.of(board, pixel_hz / divider, driver_us, axes, clock)
    axes = able.axes
    shortest = _shortest(able, divider, limits)
    if as_json:
        clocked = {"divider": divider, "sync": sync}
        show_json({**_facts(able, axes), **clocked, "shortest_line": shortest})
    else:
        _print(new_console(), able, axes, divider, shortest, scale_if_known(ctx))


def _facts(able: Capability, axes: int) -> Facts:
    """Return everything as plain data."""
    low, high = able.clock_range_hz
    return {
        "board": able.board.name,
        "axes": axes,
        "pixel_hz": str(able.pixel_hz),
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
        "measured": [
            {"motion": row.motion, "pixel_hz": row.pixel_hz, "max_rate_steps_s": row.steps_s}
            for row in capability.measured(able.board.name, axes)
        ],
        "reversal": {
            "min_interval_ticks": able.reversal_ticks,
            "min_interval_us": float(able.reversal_s * 1_000_000),
            "max_direct_steps_px": able.direct_reversal_speed,
            "rest_px": able.rest_px,
        },
    }


class _Shortest(TypedDict):
    speed_steps_px: int
    max_acceleration_steps_px2: int
    accelerating_px: int
    pixels: int
    pixels_with_backlash: int
    seconds: float


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


def _shortest(able: Capability, divider: int, limits: LimitOptions) -> _Shortest:
    """Return the shortest smooth line: by the board alone, or within limits that are given.

    A smooth line has a pixel up, one at speed and one down at least; backlash needs two more.
    """
    hz = able.pixel_hz
    top = whole_limit(limits["max_speed"], hz, least=_EVEN)
    acceleration = whole_limit(limits["max_acceleration"], hz, least=_EVEN)
    jerk = whole_limit(limits["max_jerk"], hz, least=_EVEN)
    most = able.top_speed(SMOOTH)
    speed = min(top or most, most) // 2 * 2
    if speed < _EVEN:
        edges = next(_enough_edges(able, divider), None)
        cure = f": --divider {edges} would do" if edges else ""
        raise UserError(f"a smooth line needs {_EVEN} steps/px: {most} are the most{cure}")
    bounds = ProfileLimits(
        speed,
        make.legal_limit(Fraction(acceleration or speed), ACCELERATION, hz),
        make.legal_limit(Fraction(jerk or speed), JERK, hz),
    )
    ramp = make.shortest_pixels(bounds)
    return {
        "speed_steps_px": speed,
        "max_acceleration_steps_px2": bounds.max_acceleration,
        "accelerating_px": ramp,
        "pixels": 2 * ramp + 1,
        "pixels_with_backlash": 2 * ramp + 3,
        "seconds": float((2 * ramp + 1) / hz),
    }


def _print(
    console: rich.console.Console,
    able: Capability,
    axes: int,
    divider: int,
    shortest: _Shortest,
    scale: Scale | None,
) -> None:
    """Print the page."""
    hz, board = able.pixel_hz, able.board
    low, high = able.clock_range_hz
    console.print(
        f"{board.label} at {float(hz):.10g} Hz: {able.pixel_ticks} ticks of {board.tick_ns:g} "
        f"ns a pixel{_clock_text(able, divider)}; the board takes {float(low):.3g} to "
        f"{float(high):.0f} Hz",
        soft_wrap=True,
    )  # fmt: skip
    console.print(_kinds_table(able, None))
    if scale:
        console.print(_kinds_table(able, scale))
    console.print(
        "Most: what the board accepts. Least: smooth lines have even speeds, so that the\n"
        "smallest are 2 f steps/s and 2 f^2 steps/s2; on others f and f^2."
    )
    measured = capability.measured(able.board.name, axes)
    if measured:
        _print_measured(console, measured, axes)
    _print_reversal(console, able, scale)
    _print_shortest(console, shortest)


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


def _print_measured(console: rich.console.Console, measured: Sequence[Measured], axes: int) -> None:
    """Print the rates of so many axes at once, which no rule of a single line tells."""
    clocks = sorted({row.pixel_hz for row in measured})
    table = new_table("motion", *(f"steps/s at {hz} Hz" for hz in clocks))
    for motion in MOTIONS:
        found = {row.pixel_hz: row.steps_s for row in measured if row.motion == motion}
        table.add_row(motion, *(str(found.get(hz, "-")) for hz in clocks))
    console.print(table)
    console.print(
        f"Highest rates measured with {axes} {'axes' if axes > 1 else 'axis'} at once, every edge "
        f"right (docs/TIMING.md).\nAt higher pixel clocks less: simulate the line."
    )


def _print_reversal(console: rich.console.Console, able: Capability, scale: Scale | None) -> None:
    most = able.direct_reversal_speed
    console.print(
        f"Reversal: {float(able.reversal_s * 1_000_000):g} us between the steps on both sides "
        f"(drivers of {able.driver_us} us); plain lines may turn from one pixel to the next up "
        f"to {most} steps/px, faster behind {able.rest_px} zero pixel"
        f"{'s' if able.rest_px > 1 else ''}",
        soft_wrap=True,
    )
    if scale:
        step = 1 / scale.steps_per_unit
        console.print(
            f"A step is {number_text(step)} {unit(DISTANCE, length=scale.length)} ({scale})"
        )


def _print_shortest(console: rich.console.Console, line: _Shortest) -> None:
    console.print(
        f"Shortest smooth line at {line['speed_steps_px']} {unit(SPEED)}, accelerating by up to "
        f"{line['max_acceleration_steps_px2']} {unit(ACCELERATION)}: {line['pixels']} pixels "
        f"({line['seconds']:.4g} s), {line['accelerating_px']} of them accelerating; "
        f"{line['pixels_with_backlash']} with backlash",
        soft_wrap=True,
    )
