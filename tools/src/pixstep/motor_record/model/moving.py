# SPDX-License-Identifier: MIT
"""A new target becomes a move: the record's decision, from the first question to the command.

The order of the questions is that of `toward_target`; each of them may end the decision.
"""

from pixstep.motor_record.menus import RetryMode
from pixstep.motor_record.mip import Mip
from pixstep.motor_record.model import asking, coordinates, decision, limits
from pixstep.motor_record.model.arithmetic import nearest_long
from pixstep.motor_record.model.decision import BacklashLeg, WayInSteps
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values


def toward_target(r: State) -> None:
    """Move to DVAL, if there is a move and nothing forbids it."""
    v = r.v
    retry = r.has(Mip.RETRY)
    _other_coordinates(v)
    if decision.too_small(v, retry=retry):
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
    v.val = coordinates.user(v, v.dval)
    v.rval = nearest_long(v.dval / v.mres)


def _end_without_move(v: Values) -> None:
    if v.mip in (Mip.DONE, Mip.RETRY):
        v.mip, v.dmov = Mip.DONE, 1
    coordinates.keep_as_last(v)


def _forbidden(r: State) -> bool:
    """True if a limit, a dead link or the motor's counter forbids the move."""
    v = r.v
    v.lvio = int(limits.move_violates(v, preferred=decision.preferred(v)))
    dead_link = bool(v.urip) and r.rdbl.value is None
    far = not (coordinates.countable(v, v.dval) and coordinates.countable(v, v.dval - v.bdst))
    return bool(v.lvio) or dead_link or far


def _refuse(v: Values) -> None:
    """Take the last target back. A retry that is under way goes on; it is over when it rests."""
    coordinates.back_to_last(v)
    if v.mip == Mip.RETRY:
        v.mip = Mip.DONE
    if v.mip == Mip.DONE:
        v.dmov = 1


def _begin(r: State, *, retry: bool) -> None:
    """Ask for the first leg."""
    v = r.v
    v.mip |= Mip.MOVE
    v.dmov = 0
    share = decision.retry_share(v) if retry else None
    target = decision.shared(decision.steps_to_target(v), share)
    overshoot = decision.shared(decision.steps_to_overshoot(v), share)
    chosen = decision.leg(v, overshoot)
    way = (
        decision.way_to_overshoot(v, overshoot)
        if chosen is BacklashLeg.OVERSHOOT
        else decision.way_to_target(v, target)
    )
    coordinates.keep_as_last(v)
    if chosen is BacklashLeg.OVERSHOOT:
        v.pp = 1
    v.cdir = int(v.rdif >= 0)
    _set_speed(r, chosen)
    asking.go(r, way)


def _set_speed(r: State, chosen: BacklashLeg) -> None:
    v = r.v
    if chosen is BacklashLeg.APPROACH:
        asking.set_speed(r, asking.raw(v, v.bvel), asking.backlash_acceleration(v))
    else:
        asking.set_speed(r, asking.raw(v, v.velo), asking.slew_acceleration(v, v.velo))


def second_leg(r: State, way: WayInSteps) -> None:
    """Ask for the approach against backlash."""
    v = r.v
    speed = asking.faster_than_base(v, v.bvel)
    asking.set_speed(r, speed, asking.backlash_acceleration(v), base=False)
    if not way.relative:
        v.rval = nearest_long(way.steps)
    asking.go(r, way)
