# SPDX-License-Identifier: MIT
"""What the record asks of the motor for each kind of motion: the commands and their order."""

from pixstep.motor_record.mip import Mip
from pixstep.motor_record.model.arithmetic import share
from pixstep.motor_record.model.coordinates import direction, user_is_raw
from pixstep.motor_record.model.decision import WayInSteps
from pixstep.motor_record.model.speeds import gain
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Verb


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
