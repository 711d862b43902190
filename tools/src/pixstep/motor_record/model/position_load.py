# SPDX-License-Identifier: MIT
"""The axis is told where it is: nothing moves, the controller takes a new position."""

from pixstep.motor_record.mip import Mip
from pixstep.motor_record.model import coordinates, limits
from pixstep.motor_record.model.arithmetic import nearest_long
from pixstep.motor_record.model.state import State
from pixstep.motor_record.traffic import Verb


def load_position(r: State) -> None:
    """Set the controller's position to DVAL; OFF or VAL follows, as FOFF says."""
    v = r.v
    if not coordinates.countable(v, v.dval):
        coordinates.back_to_last(v)
        v.dmov = 1
        return
    raw = v.dval / v.mres
    v.rval = nearest_long(raw)
    if v.foff:
        v.val = coordinates.user(v, v.dval)
    else:
        v.off = v.val - v.dval * coordinates.direction(v)
        limits.user_limits_from_dial(v)
    coordinates.keep_as_last(v)
    v.mip, v.dmov = Mip.LOAD_P, 0
    r.ask(Verb.LOAD_POS, raw)
    r.ask(Verb.GET_INFO)


def redefine_user_position(r: State) -> None:
    """Change OFF so that the axis is at VAL. The controller is not asked."""
    v = r.v
    v.off = v.val - v.dval * coordinates.direction(v)
    v.rbv = coordinates.user(v, v.drbv)
    limits.user_limits_from_dial(v)
    v.lval = v.val
    v.mip, v.dmov = Mip.DONE, 1
