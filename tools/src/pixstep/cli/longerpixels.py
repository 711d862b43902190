# SPDX-License-Identifier: MIT
"""The divider that would do, for commands that are no operations yet."""

import functools

import click

from pixstep.cli import machinedefaults
from pixstep.lines.units import TooLittleError
from pixstep.operations import longer_pixels


def told(ctx: click.Context, error: Exception) -> tuple[str, str]:
    """Return what stands before and after an error: its option, and what cures it; "" for none."""
    if not isinstance(error, TooLittleError):
        return "", ""
    by_machine = functools.partial(machinedefaults.by_machine, ctx)
    options = {str(param.name): max(param.opts, key=len) for param in ctx.command.params}
    name = longer_pixels.field(error, ctx.params, by_machine)
    cure = longer_pixels.cure(error, ctx.params, by_machine, machinedefaults.used(ctx))
    return f"{options[name]}: " if name else "", cure.format_map(options)
