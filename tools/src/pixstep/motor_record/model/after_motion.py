# SPDX-License-Identifier: MIT
"""What follows when the motor rests: second legs, ends of jogs, homing after a stop, retries."""

from pixstep.motor_record.menus import Spmg
from pixstep.motor_record.model import asking, buttons, coordinates, decision, moving
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Mip

_WITH_TARGET = Mip.MOVE | Mip.MOVE_BL | Mip.JOG_BL1 | Mip.JOG_BL2


def follow_up(r: State) -> None:
    """Do what is left of what was in progress, now that the motor rests."""
    v = r.v
    v.pp = 0
    if not v.omsl and not v.mip & _WITH_TARGET:
        buttons.targets_from_position(v)
    if v.mip & Mip.LOAD_P:
        v.mip = Mip.DONE
    elif v.mip & Mip.HOME:
        _home_or_homed(r)
    elif r.has(Mip.JOG_STOP, Mip.MOVE):
        _first_leg_over(r)
    elif v.mip & Mip.JOG_BL1:
        _approach_after_jog(r)
    coordinates.keep_as_last(v)
    v.mip &= ~Mip.STOP


def _home_or_homed(r: State) -> None:
    v = r.v
    if v.mip & Mip.STOP:
        v.mip &= ~Mip.STOP
        buttons.begin_home(r)
        v.pp = 1
    elif v.mip & Mip.HOMF:
        v.mip &= ~Mip.HOMF
        v.homf = 0
    else:
        v.mip &= ~Mip.HOMR
        v.homr = 0


def _first_leg_over(r: State) -> None:
    v = r.v
    if decision.has_backlash(v):
        if v.mip & Mip.JOG_STOP:
            _overshoot_after_jog(r)
        else:
            moving.second_leg(r, decision.approach(v, decision.steps_to_target(v)))
            v.mip = Mip.MOVE_BL
        _goes_on(v)
    v.mip &= ~(Mip.JOG_STOP | Mip.MOVE)


def _overshoot_after_jog(r: State) -> None:
    v = r.v
    speed = asking.faster_than_base(v, v.velo)
    asking.set_speed(r, speed, asking.slew_acceleration(v, v.velo))
    asking.go(r, decision.way_to_overshoot(v, decision.steps_to_overshoot(v)))
    v.mip = Mip.JOG_BL1


def _approach_after_jog(r: State) -> None:
    v = r.v
    distance = decision.steps_to_target(v) - decision.steps_to_overshoot(v)
    moving.second_leg(r, decision.approach(v, distance))
    v.mip = Mip.JOG_BL2
    _goes_on(v)


def _goes_on(v: Values) -> None:
    """Note that a leg follows: not done, and something to do when that one is over."""
    v.dmov, v.pp = 0, 1
    v.cdir = int(decision.steps_to_target(v) >= 0)


def retry_or_end(r: State) -> None:
    """Compare position and target: try again, give up, or be done."""
    v = r.v
    if abs(v.diff) < v.rdbd or _against_switch(v):
        _reached(v)
    elif v.rtry == 0:
        v.mip &= Mip.JOG_REQ
    elif v.rcnt < v.rtry:
        v.rcnt += 1
        v.dmov, v.mip = 0, Mip.RETRY
    else:
        _missed(v)


def _against_switch(v: Values) -> bool:
    """True if the limit switch is active in the direction that was asked for, user coordinates."""
    forwards = bool(v.cdir) == coordinates.user_is_raw(v)
    return bool(v.hls if forwards else v.lls)


def _reached(v: Values) -> None:
    v.mip &= Mip.JOG_REQ
    v.miss = 0
    if v.spmg == Spmg.MOVE:
        v.spmg = Spmg.PAUSE


def _missed(v: Values) -> None:
    v.rcnt += 1
    v.mip = Mip.JOG_REQ if buttons.jog_wanted(v) else Mip.DONE
    v.miss = 1
    coordinates.keep_as_last(v)
