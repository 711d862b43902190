# SPDX-License-Identifier: MIT
"""Which way the motors of a command run, for what is asked in the directions of their loads."""

import click

from pixstep.cli.machinedefaults import facts_of
from pixstep.errors import UserError


def way(ctx: click.Context) -> int:
    """Return -1 if the motor of a command runs backwards for its load to go forwards, else 1.

    Without a motor steps are those of the board.
    """
    facts = facts_of(ctx)
    if facts.found is None:
        return 1
    try:
        return -1 if facts.motor.negative else 1
    except UserError:
        if facts.names:
            raise
        return 1


def ways(ctx: click.Context, axes: int) -> tuple[int, ...]:
    """Return the same for each axis of a table; 1 unless --motor says which motors they are."""
    facts = facts_of(ctx)
    if facts.found is None or not facts.names:
        return (1,) * axes
    found = [-1 if motor.negative else 1 for motor in facts.motors]
    if len(found) not in (1, axes):
        raise UserError(f"--motor is given {len(found)} times for {axes} axes")
    return tuple(found * (axes // len(found)))
