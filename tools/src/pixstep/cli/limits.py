# SPDX-License-Identifier: MIT
"""`pixstep limits`: what a board, or a motor of the machine, can do at a pixel frequency."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import click

from pixstep.board import boards, capability, settings
from pixstep.board.capability import DRIVER_US, KINDS, MOTIONS, SMOOTH, Capability
from pixstep.cli.clockoptions import divider_option, sync_option
from pixstep.cli.command import command
from pixstep.cli.options import json_option, pixel_hz_option, show_json
from pixstep.cli.quantities import (
    TimeType,
    limit_options,
    scale_of,
    whole_limit,
)
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.lines.units import ACCELERATION, DISTANCE, JERK, SPEED, STEP, Scale, number_text, unit
from pixstep.profiles import make
from pixstep.profiles.make import ProfileLimits
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    import rich.console
    import rich.table
else:
    rich = lazy("rich")


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
def limits_command(ctx, board, axes, pixel_hz, divider, sync, driver_us, as_json, **limits):
    """Show what a board can do: rates, accelerations, shortest lines, reversals.

    With limits of a motor (options, or those of the machine file) the shortest smooth line that
    reaches its speed, too.
    """
    if axes and axes > boards.load(board).axes:
        raise UserError(f"--axes {axes}: {boards.axes_text(board)}")
    clock = settings.of_clock(sync, divider)
    able = capability.of(board, pixel_hz / divider, driver_us, axes, clock)
    axes = able.axes
    told = _facts(able, axes) | {"divider": divider, "sync": sync}
    told["shortest_line"] = _shortest(able, limits)
    if as_json:
        show_json(told)
    else:
        _print(rich.console.Console(highlight=False), able, told, scale_of(ctx))


def _facts(able: Capability, axes: int) -> dict:
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


def _shortest(able: Capability, limits: dict) -> dict:
    """Return the shortest smooth line: by the board alone, or within limits that are given.

    A smooth line has a pixel up, one at speed and one down at least; backlash needs two more.
    """
    hz = able.pixel_hz
    top, acceleration, jerk = (
        whole_limit(limits[name], hz) for name in ("max_speed", "max_acceleration", "max_jerk")
    )
    speed = min(top or able.top_speed(SMOOTH), able.top_speed(SMOOTH)) // 2 * 2
    if speed < 2:
        raise UserError(f"a smooth line needs 2 steps/px: {able.top_speed(SMOOTH)} are the most")
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
    console: rich.console.Console, able: Capability, told: dict, scale: Scale | None
) -> None:
    """Print the page."""
    hz, board = able.pixel_hz, able.board
    low, high = able.clock_range_hz
    console.print(
        f"{board.label} at {float(hz):.10g} Hz: {told['pixel_ticks']} ticks of {board.tick_ns:g} "
        f"ns a pixel{_clock_text(able, told)}; the board takes {float(low):.3g} to "
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
    if told["measured"]:
        _print_measured(console, told)
    _print_reversal(console, able, scale)
    _print_shortest(console, told["shortest_line"])


def _clock_text(able: Capability, told: dict) -> str:
    """Return what pixels are to the clock, if anything but its edges one by one."""
    text = f", {told['divider']} clock edges" if told["divider"] > 1 else ""
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


def _print_measured(console: rich.console.Console, told: dict) -> None:
    """Print the rates of so many axes at once, which no rule of a single line tells."""
    clocks = sorted({row["pixel_hz"] for row in told["measured"]})
    table = new_table("motion", *(f"steps/s at {hz} Hz" for hz in clocks))
    for motion in MOTIONS:
        found = {
            row["pixel_hz"]: row["max_rate_steps_s"]
            for row in told["measured"]
            if row["motion"] == motion
        }
        table.add_row(motion, *(str(found.get(hz, "-")) for hz in clocks))
    console.print(table)
    axes = told["axes"]
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


def _print_shortest(console: rich.console.Console, line: dict) -> None:
    console.print(
        f"Shortest smooth line at {line['speed_steps_px']} {unit(SPEED)}, accelerating by up to "
        f"{line['max_acceleration_steps_px2']} {unit(ACCELERATION)}: {line['pixels']} pixels "
        f"({line['seconds']:.4g} s), {line['accelerating_px']} of them accelerating; "
        f"{line['pixels_with_backlash']} with backlash",
        soft_wrap=True,
    )
