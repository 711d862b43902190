# SPDX-License-Identifier: MIT
"""A status of the motor becomes fields: positions, switches, states.

User, dial and raw coordinates: user = dial x direction + OFF, dial = raw x MRES.
"""

import math
from typing import Final

from pixstep.motor_record.field import RetryMode
from pixstep.motor_record.model.state import State, Values
from pixstep.motor_record.traffic import Mip, Msta, Status

LOWEST_LONG: Final = -(2**31)
HIGHEST_LONG: Final = 2**31 - 1
_BEYOND: Final = 2.0**62


def nearest(number: float) -> int:
    """Return the nearest whole number, halves away from zero."""
    bounded = min(max(number, -_BEYOND), _BEYOND)
    return math.floor(bounded + 0.5) if bounded > 0 else math.ceil(bounded - 0.5)


def nearest_long(number: float) -> int:
    """Return the nearest whole number that a field of 32 bits holds."""
    return min(max(nearest(number), LOWEST_LONG), HIGHEST_LONG)


def within(number: float, lowest: float, highest: float) -> float:
    """Return the number, or the end that it is beyond. A highest of 0 means none."""
    if highest != 0 and max(number, lowest) > highest:
        return highest
    return max(number, lowest)


def share(whole: float, parts: float) -> float:
    """Return whole / parts; 0 where there are no parts."""
    return whole / parts if parts else 0.0


def direction(v: Values) -> int:
    """Return 1 where user and dial have one direction (DIR Pos), else -1."""
    return -1 if v.dir else 1


def user(v: Values, dial: float) -> float:
    """Return a position in user coordinates."""
    return dial * direction(v) + v.off


def dial(v: Values, user_position: float) -> float:
    """Return a position in dial coordinates."""
    return (user_position - v.off) / direction(v)


def user_is_raw(v: Values) -> bool:
    """True where user and raw coordinates grow in one direction."""
    return (v.dir == 0) == (v.mres >= 0)


def setting_position(v: Values) -> bool:
    """True where targets say where the axis is: SET, unless IGSET."""
    return bool(v.set) and not v.igset


def countable(v: Values, dial_position: float) -> bool:
    """True for a dial position that a raw counter of 32 bits can hold."""
    return LOWEST_LONG <= dial_position / v.mres <= HIGHEST_LONG


def difference(v: Values) -> None:
    """Make DIFF and RDIF the way from the position to the target."""
    v.diff = v.dval - v.drbv
    v.rdif = nearest_long(v.diff / v.mres)


def keep_as_last(v: Values) -> None:
    """Make the targets those of the last move."""
    v.lval, v.ldvl, v.lrvl = v.val, v.dval, v.rval


def back_to_last(v: Values) -> None:
    """Give the targets the values of the last move."""
    v.val, v.dval, v.rval = v.lval, v.ldvl, v.lrvl


def targets_from_readback(v: Values) -> None:
    """Make the targets what the position is."""
    v.val, v.dval = v.rbv, v.drbv
    v.rval = nearest_long(v.dval / v.mres)


def shows(v: Values, flag: Msta) -> bool:
    """True if the status of the motor has a bit."""
    return bool(v.msta & flag.value)


def take(v: Values, status: Status) -> None:
    """Copy what the driver says."""
    v.rmp = status.position_steps
    v.rep = status.encoder_counts
    known, v.msta = v.msta, int(status.flags)
    if v.msta != known and shows(v, Msta.GAIN_SUPPORT):
        v.cnen = int(shows(v, Msta.EA_POSITION))
    v.rvel = nearest_long(status.speed_steps_per_s)


def work_out(r: State, *, first: bool = False) -> None:
    """Work out all that follows from the status. `first`: at the start, links are not read."""
    v = r.v
    if v.ueip and not shows(v, Msta.EA_PRESENT):
        v.ueip = 0
    if not newest_position(r, links=not first) and v.mip != Mip.DONE:
        release_buttons(v)
        v.stop = 1
    v.tdir = int(shows(v, Msta.DIRECTION))
    _switches(v)
    _movement(v)
    v.athm = int(shows(v, Msta.EA_HOME if v.ueip else Msta.HOME))
    difference(v)


def newest_position(r: State, *, links: bool = True) -> bool:
    """Make all readbacks the newest position. False if the link that gives it is dead."""
    v = r.v
    if v.ueip:
        _set_raw(v, v.rep, v.eres)
    elif v.urip and links:
        return _read_link(r)
    else:
        _set_raw(v, v.rmp, v.mres)
    return True


def _set_raw(v: Values, raw: int, resolution: float) -> None:
    """Make all readbacks agree with a raw one."""
    v.rrbv = raw
    v.drbv = raw * resolution
    v.rbv = user(v, v.drbv)


def _read_link(r: State) -> bool:
    """Take the position from RDBL. False if that is dead: the position stays what it was."""
    if r.rdbl.value is None:
        return False
    _set_raw(r.v, nearest_long(r.rdbl.value * r.v.rres / r.v.mres), r.v.mres)
    return True


def _switches(v: Values) -> None:
    v.rhls = int(shows(v, Msta.PLUS_LS))
    v.rlls = int(shows(v, Msta.MINUS_LS))
    v.hls, v.lls = (v.rhls, v.rlls) if user_is_raw(v) else (v.rlls, v.rhls)


def at_switch_ahead(v: Values) -> bool:
    """True if the limit switch in the direction of the motion is active."""
    return bool(v.rhls if v.cdir else v.rlls)


def _movement(v: Values) -> None:
    halted = at_switch_ahead(v) or shows(v, Msta.PROBLEM)
    v.movn = int(not (halted or shows(v, Msta.DONE)))
    if halted:
        release_buttons(v)


def release_buttons(v: Values) -> None:
    """Clear the wishes to jog and to find the home switch."""
    v.jogf = v.jogr = v.homf = v.homr = 0


def relative(v: Values) -> bool:
    """True where moves are distances, since the position comes from elsewhere than the motor."""
    return v.rtry != 0 and v.rmod != RetryMode.IN_POSITION and bool(v.ueip or v.urip)


def targets_become_readbacks(r: State) -> None:
    """Make all targets the newest position, also as the last ones."""
    newest_position(r)
    targets_from_readback(r.v)
    keep_as_last(r.v)
