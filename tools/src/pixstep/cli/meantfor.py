# SPDX-License-Identifier: MIT
"""What a file's name or header says of its motor, beside the motor that a command moves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pixstep.cli import machinedefaults
from pixstep.formats import ProfileHeader
from pixstep.profiles import names

if TYPE_CHECKING:
    from collections.abc import Iterator


def motor_decode(ctx: click.Context, path: Path) -> str | None:
    """Return how the motor in a conventional file name decodes; None if nothing says it.

    The machine file knows its own motors, the printer's have their names.
    """
    named = names.parse(path)
    if named is None:
        return None
    machine = machinedefaults.used(ctx)
    if machine and named.motor in machine.motors:
        return machine[named.motor].decode
    return named.decode


def motor_notes(path: Path, header: ProfileHeader | None, index: int = 0) -> Iterator[str]:
    """Yield that a file is for another motor than the one it is used for, if that is so.

    `index` is the number of the line, of a command that moves several motors.
    """
    motors = machinedefaults.motors_in_force(click.get_current_context())
    if not motors:
        return
    motor = motors[index] if index < len(motors) else motors[0]
    made_for = names.motor_of(path, header.name if header else None)
    if made_for is not None and made_for != motor.name:
        yield f"{path}: made for motor {made_for}, used for motor {motor.name}"


def line_notes(path: Path, header: ProfileHeader | None, index: int = 0) -> Iterator[str]:
    """Yield the same of a line, and that its header's lead-in is not the machine's."""
    yield from motor_notes(path, header, index)
    machine = machinedefaults.used(click.get_current_context())
    if machine is None or header is None or not header.lead_in_px:
        return
    if header.lead_in_px != machine.line.lead_in:
        yield (
            f"{path}: its header has LeadIn {header.lead_in_px}, {machine.path} has lead_in = "
            f"{machine.line.lead_in} in the table [line]: the image begins at another pixel"
        )
