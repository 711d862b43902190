# SPDX-License-Identifier: MIT
"""What will be asked after the first leg of a move, if nothing comes between."""

from collections.abc import Sequence

from pixstep.motor_record.traffic import Command
from pixstep.motor_record.values import Values


def second_leg(v: Values, commands: Sequence[Command]) -> tuple[Command, ...]:
    """Return the approach that follows a first leg among `commands`, or nothing."""
    return ()
