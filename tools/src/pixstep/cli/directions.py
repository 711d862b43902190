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
        if facts.named.any:
            raise
        return 1


def negatives(ctx: click.Context, *, given: bool | None, lines: int) -> list[bool]:
    """Return for each line whether a smooth one runs backwards: as its motor does, if none is said.

    `given` is --negative, or what the motors have in common.
    """
    facts = facts_of(ctx)
    if given is not None or facts.found is None or facts.other_kind():
        return [bool(given)] * lines
    found = [motor.negative for motor in facts.motors]
    return found if len(found) == lines else found[:1] * lines


def ways(ctx: click.Context, axes: int) -> tuple[int, ...]:
    """Return the same for each axis of a table; 1 unless --motor or --axis says whose it is."""
    facts = facts_of(ctx)
    if facts.found is None or not facts.named.any:
        return (1,) * axes
    found = [-1 if motor.negative else 1 for motor in facts.motors]
    if len(found) not in (1, axes):
        raise UserError(f"--motor is given {len(found)} times for {axes} axes")
    return tuple(found * (axes // len(found)))
