# SPDX-License-Identifier: MIT
"""Targets become readbacks: SYNC, and a stop of a motor that rests already."""

from pixstep.motor_record.model import coordinates
from pixstep.motor_record.model.readback import read_link, set_raw
from pixstep.motor_record.model.state import State


def targets_become_readbacks(r: State) -> None:
    """Make all targets the newest position, also as the last ones."""
    v = r.v
    if v.ueip:
        set_raw(v, v.rep, v.eres)
    elif v.urip:
        read_link(r)
    else:
        set_raw(v, v.rmp, v.mres)
    coordinates.targets_from_readback(v)
    coordinates.keep_as_last(v)
