# SPDX-License-Identifier: MIT
"""A new target becomes a move: the record's decision, from the first question to the command.

The order of the questions is that of `toward_target`; each of them may end the decision.

The decisions about a move, from the fields alone: is there one, which leg, how far.

What the record asks of the motor for each kind of motion: the commands and their order.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

from pixstep.motor_record.field import RetryMode
from pixstep.motor_record.model import limits, readback
from pixstep.motor_record.model.readback import (
    direction,
    nearest,
    nearest_long,
    relative,
    share,
    user_is_raw,
)
from pixstep.motor_record.model.speeds import gain
from pixstep.motor_record.model.state import State, Values
from pixstep.motor_record.traffic import Mip, Verb


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


def raw(v: Values, egu: float) -> float:
    """Return a speed or an acceleration in steps."""
    return egu / abs(v.mres)


def slew_acceleration(v: Values, speed: float) -> float:
    """Return the acceleration of a move to a speed, both in EGU: ACCS, or ACCL's."""
    return v.accs if v.accu else share(gain(v, speed), v.accl)


def backlash_acceleration(v: Values) -> float:
    """Return the acceleration of an approach, in EGU/s2."""
    return gain(v, v.bvel) / v.bacc


def faster_than_base(v: Values, speed: float) -> float:
    """Return a raw speed, one step per second above the lowest at least."""
    base = raw(v, v.vbas)
    return raw(v, speed) if raw(v, speed) > base else base + 1


def set_speed(r: State, speed: float, acceleration: float, *, base: bool = True) -> None:
    """Ask for a raw speed and an acceleration in EGU/s2."""
    r.ask(Verb.SET_VELOCITY, speed)
    if base:
        r.ask(Verb.SET_VEL_BASE, raw(r.v, r.v.vbas))
    if acceleration > 0:
        r.ask(Verb.SET_ACCEL, raw(r.v, acceleration))


def go(r: State, way: WayInSteps) -> None:
    """Begin a move at the speed asked for."""
    r.ask(Verb.MOVE_REL if way.relative else Verb.MOVE_ABS, way.steps)
    r.ask(Verb.GO)


def stop(r: State) -> None:
    """Stop the motor."""
    r.ask(Verb.STOP_AXIS)


def home(r: State) -> None:
    """Begin to look for the home switch, forwards or backwards as MIP says."""
    v = r.v
    set_speed(r, raw(v, v.hvel), slew_acceleration(v, v.hvel))
    forwards = bool(v.mip & Mip.HOMF) == (v.mres > 0)
    r.ask(Verb.HOME_FOR if forwards else Verb.HOME_REV)
    r.ask(Verb.GO)
    v.cdir = int(forwards)


def jog_speed(v: Values, *, backwards: bool) -> float:
    """Return the raw speed of a jog, with its sign."""
    speed = v.jvel * direction(v) / v.mres
    return -speed if backwards else speed


def jog(r: State) -> None:
    """Begin to jog."""
    v = r.v
    v.cdir = int(bool(v.jogf) == user_is_raw(v))
    r.ask(Verb.SET_VEL_BASE, raw(v, v.vbas))
    r.ask(Verb.SET_ACCEL, raw(v, v.jar))
    r.ask(Verb.JOG, jog_speed(v, backwards=not v.jogf))


def change_jog(r: State) -> None:
    """Change the speed of a jog under way."""
    r.ask(Verb.SET_ACCEL, raw(r.v, r.v.jar))
    r.ask(Verb.JOG_VELOCITY, jog_speed(r.v, backwards=bool(r.v.jogr)))


def toward_target(r: State) -> None:
    """Move to DVAL, if there is a move and nothing forbids it."""
    v = r.v
    retry = r.has(Mip.RETRY)
    _other_coordinates(v)
    if too_small(v, retry=retry):
        _end_without_move(v)
        return
    if not retry:
        v.rcnt = 0
    elif v.rmod == RetryMode.IN_POSITION:
        return  # the controller servoes: the record only waits
    if _forbidden(r):
        _refuse(v)
        return
    if v.mip in (Mip.DONE, Mip.RETRY):
        _begin(r, retry=retry)


def _other_coordinates(v: Values) -> None:
    """Make VAL and RVAL agree with DVAL."""
    v.val = readback.user(v, v.dval)
    v.rval = nearest_long(v.dval / v.mres)


def _end_without_move(v: Values) -> None:
    if v.mip in (Mip.DONE, Mip.RETRY):
        v.mip, v.dmov = Mip.DONE, 1
    readback.keep_as_last(v)


def _forbidden(r: State) -> bool:
    """True if a limit, a dead link or the motor's counter forbids the move."""
    v = r.v
    v.lvio = int(limits.move_violates(v, preferred=preferred(v)))
    dead_link = bool(v.urip) and r.rdbl.value is None
    far = not (readback.countable(v, v.dval) and readback.countable(v, v.dval - v.bdst))
    return bool(v.lvio) or dead_link or far


def _refuse(v: Values) -> None:
    """Take the last target back. A retry that is under way goes on; it is over when it rests."""
    readback.back_to_last(v)
    if v.mip == Mip.RETRY:
        v.mip = Mip.DONE
    if v.mip == Mip.DONE:
        v.dmov = 1


def _begin(r: State, *, retry: bool) -> None:
    """Ask for the first leg."""
    v = r.v
    v.mip |= Mip.MOVE
    v.dmov = 0
    share = retry_share(v) if retry else None
    target = shared(steps_to_target(v), share)
    overshoot = shared(steps_to_overshoot(v), share)
    chosen = leg(v, overshoot)
    way = (
        way_to_overshoot(v, overshoot)
        if chosen is BacklashLeg.OVERSHOOT
        else way_to_target(v, target)
    )
    readback.keep_as_last(v)
    if chosen is BacklashLeg.OVERSHOOT:
        v.pp = 1
    v.cdir = int(v.rdif >= 0)
    _set_speed(r, chosen)
    go(r, way)


def _set_speed(r: State, chosen: BacklashLeg) -> None:
    v = r.v
    if chosen is BacklashLeg.APPROACH:
        set_speed(r, raw(v, v.bvel), backlash_acceleration(v))
    else:
        set_speed(r, raw(v, v.velo), slew_acceleration(v, v.velo))


def second_leg(r: State, way: WayInSteps) -> None:
    """Ask for the approach against backlash."""
    v = r.v
    speed = faster_than_base(v, v.bvel)
    set_speed(r, speed, backlash_acceleration(v), base=False)
    if not way.relative:
        v.rval = nearest_long(way.steps)
    go(r, way)
