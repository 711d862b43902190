# SPDX-License-Identifier: MIT
"""The decisions about a move, from the fields alone: is there one, which leg, how far."""

import math
from dataclasses import dataclass
from enum import StrEnum

from pixstep.motor_record.menus import RetryMode
from pixstep.motor_record.model.arithmetic import nearest
from pixstep.motor_record.model.readback import relative
from pixstep.motor_record.model.values import Values


class BacklashLeg(StrEnum):
    """What a move against backlash begins with."""

    STRAIGHT = "straight"
    """To the target, at VELO: there is no backlash, or the way there takes it out as well."""
    APPROACH = "approach"
    """To the target, at BVEL: it is near, and in the right direction."""
    OVERSHOOT = "overshoot"
    """To BDST before the target, at VELO. The approach follows."""


@dataclass(frozen=True, slots=True)
class WayInSteps:
    """A way in steps: where to (`relative` False) or how far (True)."""

    steps: float
    relative: bool


def too_small(v: Values, *, retry: bool) -> bool:
    """True if the target is where the motor is, as far as a move could tell."""
    steps = abs(nearest(v.dval / v.mres) - nearest(v.drbv / v.mres))
    if retry:
        return steps < nearest(v.rdbd / abs(v.mres))
    return steps < 1 or (v.spdb > 0 and v.dval - v.spdb < v.drbv < v.dval + v.spdb)


def preferred(v: Values) -> bool:
    """True if the way to the target has the direction of the last approach."""
    forwards = v.diff > 0 if relative(v) else v.dval > v.ldvl
    return forwards == (v.bdst > 0)


def leg(v: Values, to_overshoot: float) -> BacklashLeg:
    """Choose the leg that a move begins with. `to_overshoot`: steps to where an approach begins."""
    takes_out = preferred(v)
    if not has_backlash(v):
        return BacklashLeg.STRAIGHT
    if takes_out and v.bvel == v.velo and v.bacc == v.accl:
        return BacklashLeg.STRAIGHT
    if takes_out and _near(v, to_overshoot):
        return BacklashLeg.APPROACH
    return BacklashLeg.OVERSHOOT


def has_backlash(v: Values) -> bool:
    """True if BDST is one step or more."""
    return abs(v.bdst) >= abs(v.mres)


def _near(v: Values, to_overshoot: float) -> bool:
    """True if the target is within BDST, and one step."""
    if relative(v):
        return to_overshoot <= 1 if v.bdst > 0 else to_overshoot >= 1
    return abs(v.dval / v.mres - v.ldvl / v.mres) <= 1 + abs(v.bdst) / abs(v.mres)


def way_to_target(v: Values, distance: float) -> WayInSteps:
    """Return the way of a leg to the target. `distance`: steps to it from the readback."""
    if relative(v):
        return WayInSteps(distance * v.frac, relative=True)
    here, there = v.ldvl / v.mres, v.dval / v.mres
    return WayInSteps(here + v.frac * (there - here), relative=False)


def way_to_overshoot(v: Values, distance: float) -> WayInSteps:
    """Return the way to where an approach begins. `distance`: steps to it from the readback."""
    if relative(v):
        return WayInSteps(distance, relative=True)
    return WayInSteps(overshoot_steps(v), relative=False)


def approach(v: Values, distance: float) -> WayInSteps:
    """Return the way of the second leg. `distance`: steps, where moves are relative."""
    if relative(v):
        return WayInSteps(distance * v.frac, relative=True)
    start = overshoot_steps(v)
    return WayInSteps(start + v.frac * (v.dval / v.mres - start), relative=False)


def overshoot_steps(v: Values) -> float:
    """Return where an approach begins: BDST before the target."""
    return (v.dval - v.bdst) / v.mres


def steps_to_target(v: Values) -> float:
    """Return the distance from the readback to the target."""
    return v.diff / v.mres


def steps_to_overshoot(v: Values) -> float:
    """Return the distance from the readback to where an approach begins."""
    return ((v.dval - v.bdst) - v.drbv) / v.mres


def retry_share(v: Values) -> float | None:
    """Return which part of a distance this retry covers. None: all of it, however small."""
    if v.rmod == RetryMode.ARITHMETIC:
        return (v.rtry - v.rcnt + 1.0) / max(v.rtry, 1)  # RTRY may become 0 in a retry
    if v.rmod == RetryMode.GEOMETRIC:
        return math.ldexp(1.0, 1 - v.rcnt)
    return None


def shared(distance: float, share: float | None) -> float:
    """Return the part of a distance that a retry covers: at least one step."""
    if share is None:
        return distance
    part = distance * share
    if abs(part) >= 1:
        return part
    return 1.0 if part > 0 else -1.0
