# SPDX-License-Identifier: MIT
"""Which way motors run, for what is asked in the directions of their loads."""

from pixstep.errors import UserError
from pixstep.operations.facts import Facts


def way(facts: Facts) -> int:
    """Return -1 if the motor runs backwards for its load to go forwards, else 1.

    Without a motor steps are those of the board.
    """
    if facts.found is None:
        return 1
    try:
        return -1 if facts.motor.negative else 1
    except UserError:
        if facts.named.any:
            raise
        return 1


def negatives(facts: Facts, *, given: bool | None, lines: int) -> list[bool]:
    """Return for each line whether a smooth one runs backwards: as its motor does, if none is said.

    `given` is what the caller says, or what the motors have in common.
    """
    if given is not None or facts.found is None or facts.other_kind():
        return [bool(given)] * lines
    found = [motor.negative for motor in facts.motors]
    return found if len(found) == lines else found[:1] * lines


def ways(facts: Facts, axes: int) -> tuple[int, ...]:
    """Return the same as `way` for each axis of a table; 1 unless motors or axes are named."""
    if facts.found is None or not facts.named.any:
        return (1,) * axes
    found = [-1 if motor.negative else 1 for motor in facts.motors]
    if len(found) not in (1, axes):
        raise UserError(f"--motor is given {len(found)} times for {axes} axes")
    return tuple(found * (axes // len(found)))
