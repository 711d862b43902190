# SPDX-License-Identifier: MIT
"""The divider by which pixels are long enough for limits that a command was given."""

from fractions import Fraction

import click

from pixstep.cli import machinedefaults
from pixstep.lines.units import Quantity, TooLittleError, enough_edges
from pixstep.profiles.madefor import MOST_EDGES

_LIMITS = ("max_speed", "max_acceleration", "max_jerk")


def cure(ctx: click.Context, error: Exception) -> str:
    """Return which divider cures an error, in words; empty for another error, or if none does."""
    if not isinstance(error, TooLittleError) or error.quantity is None:
        return ""
    clock_hz = _clock_hz(ctx)
    if clock_hz is None:
        return ""
    given = [ctx.params.get(name) for name in _LIMITS]
    limits = [error.quantity, *(limit for limit in given if isinstance(limit, Quantity))]
    edges = max(enough_edges(limit, clock_hz, error.least) or 1 for limit in limits)
    if edges > MOST_EDGES:
        return ""
    machine = machinedefaults.used(ctx)
    file = f"divider = {edges} in the table [clock] of {machine.path}" if machine else ""
    if "divider" in ctx.params:
        return f": --divider {edges} would do" + (f", or {file}" if file else "")
    if file and machinedefaults.by_machine(ctx, "pixel_hz"):
        return f": {file} would do"
    hz = f"{float(clock_hz / edges):.10g}"
    return f": pixels of {edges} clock edges would do, --pixel-hz {hz}"


def option(ctx: click.Context, error: Exception) -> str:
    """Return `--max-speed: ` if the command line gave the limit that an error is about, else ""."""
    if not isinstance(error, TooLittleError) or error.given is None:
        return ""
    for param in ctx.command.params:
        name = param.name or ""
        if ctx.params.get(name) is error.given and not machinedefaults.by_machine(ctx, name):
            return f"{max(param.opts, key=len)}: "
    return ""


def _clock_hz(ctx: click.Context) -> Fraction | None:
    """Return the frequency of the clock's edges; of pixels where nothing says how many they are."""
    if "divider" not in ctx.params and machinedefaults.by_machine(ctx, "pixel_hz"):
        machine = machinedefaults.used(ctx)
        return machine.clock_hz if machine else None
    hz = ctx.params.get("pixel_hz")
    return hz if isinstance(hz, Fraction) else None
