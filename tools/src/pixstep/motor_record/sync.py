# SPDX-License-Identifier: MIT
"""Targets become readbacks: SYNC, and a stop of a motor that rests already."""

from pixstep.motor_record import coordinates
from pixstep.motor_record.readback import set_raw
from pixstep.motor_record.values import Values


def targets_become_readbacks(v: Values) -> None:
    """Make all targets the newest position, also as the last ones."""
    if v.ueip:
        set_raw(v, v.rep, v.eres)
    elif v.urip:
        set_raw(v, v.rrbv, v.mres)
    else:
        set_raw(v, v.rmp, v.mres)
    coordinates.targets_from_readback(v)
    coordinates.keep_as_last(v)
