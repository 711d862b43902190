# SPDX-License-Identifier: MIT
"""What a file's name or header says of its motor, beside the motor that an operation moves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pixstep.formats import ProfileHeader
from pixstep.operations.facts import Facts
from pixstep.profiles import origin


def motor_decode(facts: Facts, path: Path) -> str | None:
    """Return how the motor in a conventional file name decodes; None if nothing says it.

    The machine file knows its own motors, the printer's have their names.
    """
    named = origin.parse_name(path)
    if named is None:
        return None
    machine = facts.used
    if machine and named.motor in machine.motors:
        return machine[named.motor].decode
    return named.decode


def motor_notes(
    facts: Facts, path: Path, header: ProfileHeader | None, index: int = 0
) -> Iterator[str]:
    """Yield that a file is for another motor than the one it is used for, if that is so.

    `index` is the number of the line, of an operation that moves several motors.
    """
    motors = facts.motors_in_force
    if not motors:
        return
    motor = motors[index] if index < len(motors) else motors[0]
    made_for = origin.motor_of(path, header.name if header else None)
    if made_for is not None and made_for != motor.name:
        yield f"{path}: made for motor {made_for}, used for motor {motor.name}"


def line_notes(
    facts: Facts, path: Path, header: ProfileHeader | None, index: int = 0
) -> Iterator[str]:
    """Yield the same of a line, and that its header's lead-in is not the machine's."""
    yield from motor_notes(facts, path, header, index)
    machine = facts.used
    if machine is None or header is None or not header.lead_in_px:
        return
    if header.lead_in_px != machine.line.lead_in:
        yield (
            f"{path}: its header has LeadIn {header.lead_in_px}, {machine.path} has lead_in = "
            f"{machine.line.lead_in} in the table [line]: the image begins at another pixel"
        )
