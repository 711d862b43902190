# SPDX-License-Identifier: MIT
"""What will be asked after the first leg of a move, if nothing comes between.

There is no second set of rules for that: a twin of the record is shown the status that the end of
the leg will bring, and what it asks for is the answer.
"""

import math
from collections.abc import Iterable

from pixstep.motor_record.mip import Mip
from pixstep.motor_record.model.processing import process
from pixstep.motor_record.model.state import State
from pixstep.motor_record.traffic import MotorCommand, Msta, Status, Verb, whole

_FIRST_LEGS = Mip.MOVE | Mip.JOG_BL1
_SECOND_LEGS = Mip.MOVE_BL | Mip.JOG_BL2


def second_leg(r: State, commands: Iterable[MotorCommand]) -> tuple[MotorCommand, ...]:
    """Return the approach that follows the leg among `commands`, or nothing."""
    way = next((one for one in commands if one.verb in (Verb.MOVE_ABS, Verb.MOVE_REL)), None)
    if way is None or not r.v.mip & _FIRST_LEGS:
        return ()
    twin = r.twin()
    steps = _length(r, way)
    if twin.rdbl.value is not None and r.v.rres != 0:
        twin.rdbl.value += steps * r.v.mres / r.v.rres
    process(twin, _arrived(r, steps))
    return tuple(twin.commands) if twin.v.mip & _SECOND_LEGS else ()


def _length(r: State, way: MotorCommand) -> int:
    """Return how many steps the leg makes, with their sign."""
    steps = whole(way.argument)
    return steps if way.verb is Verb.MOVE_REL else steps - r.v.rmp


def _arrived(r: State, steps: int) -> Status:
    """Return the status that the end of the leg brings."""
    v = r.v
    counts = math.floor(steps * v.mres / v.eres + 0.5) if v.ueip else 0
    flags = (Msta(v.msta) | Msta.DONE) & ~(Msta.MOVING | Msta.DIRECTION)
    if v.cdir:
        flags |= Msta.DIRECTION
    return Status(v.rmp + steps, v.rep + counts, flags)
