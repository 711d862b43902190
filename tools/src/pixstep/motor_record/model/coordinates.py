# SPDX-License-Identifier: MIT
"""User, dial and raw coordinates: user = dial x direction + OFF, dial = raw x MRES."""

import math
from typing import Final

from pixstep.motor_record.model.values import Values

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
