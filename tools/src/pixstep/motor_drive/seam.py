# SPDX-License-Identifier: MIT
"""What a drive wants of a board that boards cannot do yet: each in one place, and what it does.

A later board replaces the body of a function here, and nothing else.

A braking stop. Instead `stop` is the board's stop: the axis makes at most one STEP edge more,
whatever its speed. The position stays right by the count, but a motor that is faster than it can
stop at once slips. The record's STOP, the end of a jog and a new target while the motor moves stop
like this.

Set position. Instead `set_position` is an offset between the board's register and the record's raw
position. The drive keeps it; it is gone with the process, and RSTM and autosave bring the position
back. A homing makes it 0.

A jog on the board. Instead `motions.Jog` sends short lines that follow each other without a gap,
queued beyond what the board decodes ahead: 0.3 s at 2000 steps/s, 1.3 s of slow steps. A
change of speed begins after that time, and a motor whose host has died stops after it.

An encoder. There is none: EA_PRESENT is never set.
"""

from __future__ import annotations

from pixstep.board import run
from pixstep.board.device import Device
from pixstep.motor_drive.feed import Steps


def stop(board: Device, axis: int) -> None:
    """Stop an axis; raises BoardError if it is not known to have been."""
    run.stop_axes(board, [axis])


def set_position(position_steps: int, register_steps: int) -> int:
    """Return the offset by which a board's register shows a position."""
    return position_steps - register_steps


def clear_fault(board: Device, axes: int) -> None:
    """Clear the board's fault. Raises BoardError saying why that is not possible."""
    run.command(board, "clear_fault", list(range(axes)))


def discard(board: Device, axis: int) -> Steps:
    """Forget what is queued of a line that does not run."""
    run.command(board, "disarm", [axis])
    yield 0.0
