# SPDX-License-Identifier: MIT
"""One processing of the record: a status is followed up, then wishes are looked at.

What follows when the motor rests are second legs, ends of jogs, homing after a stop, retries. The
wishes of clients have a fixed order, status, stop, resolution, buttons, targets: the first that is
there settles this processing.
"""

from enum import Enum, auto

from pixstep.motor_record.field import Alarm, RetryMode, Severity, Spmg, StatusUpdate
from pixstep.motor_record.model import buttons, limits, moving, readback
from pixstep.motor_record.model.readback import (
    at_switch_ahead,
    nearest_long,
    shows,
    targets_become_readbacks,
)
from pixstep.motor_record.model.speeds import keep_dead_bands
from pixstep.motor_record.model.state import State, Values
from pixstep.motor_record.traffic import Mip, Msta, Status, Verb


def do_work(r: State, *, from_motor: bool) -> None:
    """Look at all wishes once. `from_motor`: this processing began with a status or a delay."""
    v = r.v
    if v.stup == StatusUpdate.ON:
        ask_for_status(r, for_client=True)
    settled = buttons.stop_or_spmg(r) or _new_resolution(r)
    if not settled and _targets(r) and not buttons.held(v):
        _act(r, from_motor=from_motor)


def _targets(r: State) -> bool:
    """Gather what changes DVAL. False if something on the way settled this processing."""
    gathered = _target_from_link(r) if closed_loop(r) else _wishes(r)
    return gathered and _user_target(r)


def _act(r: State, *, from_motor: bool) -> None:
    """Act on DVAL, else on SYNC; if there is nothing to do, ask for a status."""
    v = r.v
    if v.dval != v.ldvl or not v.dmov:
        _dial_target(r)
    elif v.sync and v.mip == Mip.DONE:
        targets_become_readbacks(r)
        v.sync = 0
    elif not from_motor and v.stup == StatusUpdate.OFF:
        ask_for_status(r)


def ask_for_status(r: State, *, for_client: bool = False) -> None:
    """Ask for a status, and note that one is awaited."""
    r.status_for_client = for_client
    r.v.stup = StatusUpdate.BUSY
    r.ask(Verb.GET_INFO)


def closed_loop(r: State) -> bool:
    """True where the target comes from DOL."""
    return bool(r.v.omsl) and r.dol.exists


def _target_from_link(r: State) -> bool:
    """Take VAL from DOL. False if that is dead."""
    if r.dol.value is None:
        r.v.udf = 1
        return False
    r.v.val = r.dol.value
    r.v.udf = 0
    return True


def _wishes(r: State) -> bool:
    """Look at the buttons. False if one of them settled this processing."""
    if buttons.home(r) or buttons.jog(r):
        return False
    buttons.relative_targets(r.v)
    return True


def _new_resolution(r: State) -> bool:
    """Act on a change of MRES, ERES or UEIP: the controller's position is set anew."""
    v = r.v
    if not r.resolution_written:
        return False
    keep_dead_bands(v)
    if readback.setting_position(v):
        v.pp = 1
        r.ask(Verb.GET_INFO)
    elif not v.mip & Mip.LOAD_P:
        load_position(r)
    return True


def _user_target(r: State) -> bool:
    """Act on a new VAL. False if that settled this processing."""
    v = r.v
    if v.val == v.lval:
        return True
    if readback.setting_position(v) and not v.foff:
        redefine_user_position(r)
        return False
    v.dval = readback.dial(v, v.val)
    return True


def _dial_target(r: State) -> None:
    """Act on DVAL: a move, or a position where SET is on."""
    v = r.v
    readback.difference(v)
    if not readback.setting_position(v):
        moving.toward_target(r)
    elif not v.mip & Mip.LOAD_P:
        load_position(r)


def wanted(v: Values, *, from_motor: bool) -> bool:
    """True if this processing looks at wishes at all: not while a motion goes on."""
    waits_for_motor = from_motor and not v.dmov and not v.mip & Mip.RETRY
    return bool(v.stop) or buttons.held(v) or not waits_for_motor


def load_position(r: State) -> None:
    """Set the controller's position to DVAL; OFF or VAL follows, as FOFF says."""
    v = r.v
    if not readback.countable(v, v.dval):
        readback.back_to_last(v)
        v.dmov = 1
        return
    raw = v.dval / v.mres
    v.rval = nearest_long(raw)
    if v.foff:
        v.val = readback.user(v, v.dval)
    else:
        v.off = v.val - v.dval * readback.direction(v)
        limits.user_limits_from_dial(v)
    readback.keep_as_last(v)
    v.mip, v.dmov = Mip.LOAD_P, 0
    r.ask(Verb.LOAD_POS, raw)
    r.ask(Verb.GET_INFO)


def redefine_user_position(r: State) -> None:
    """Change OFF so that the axis is at VAL. The controller is not asked."""
    v = r.v
    v.off = v.val - v.dval * readback.direction(v)
    v.rbv = readback.user(v, v.drbv)
    limits.user_limits_from_dial(v)
    v.lval = v.val
    v.mip, v.dmov = Mip.DONE, 1


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
    readback.keep_as_last(v)
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
    if moving.has_backlash(v):
        if v.mip & Mip.JOG_STOP:
            _overshoot_after_jog(r)
        else:
            moving.second_leg(r, moving.approach(v, moving.steps_to_target(v)))
            v.mip = Mip.MOVE_BL
        _goes_on(v)
    v.mip &= ~(Mip.JOG_STOP | Mip.MOVE)


def _overshoot_after_jog(r: State) -> None:
    v = r.v
    speed = moving.faster_than_base(v, v.velo)
    moving.set_speed(r, speed, moving.slew_acceleration(v, v.velo))
    moving.go(r, moving.way_to_overshoot(v, moving.steps_to_overshoot(v)))
    v.mip = Mip.JOG_BL1


def _approach_after_jog(r: State) -> None:
    v = r.v
    distance = moving.steps_to_target(v) - moving.steps_to_overshoot(v)
    moving.second_leg(r, moving.approach(v, distance))
    v.mip = Mip.JOG_BL2
    _goes_on(v)


def _goes_on(v: Values) -> None:
    """Note that a leg follows: not done, and something to do when that one is over."""
    v.dmov, v.pp = 0, 1
    v.cdir = int(moving.steps_to_target(v) >= 0)


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
    forwards = bool(v.cdir) == readback.user_is_raw(v)
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
    readback.keep_as_last(v)


class Next(Enum):
    """What a processing does after it has followed up a status."""

    WORK = auto()
    """Look at wishes."""
    LEAVE = auto()
    """Nothing: a status or a delay is awaited."""


def process(r: State, status: Status | None = None, *, by_write: bool = False) -> None:
    """Process the record: because of a write, a status or both, or of a delay (neither)."""
    v = r.v
    r.by_write = by_write
    violated = v.lvio
    if status is not None:
        readback.take(v, status)
    from_motor = status is not None or bool(v.mip & Mip.DELAY_ACK)
    if not from_motor or _follow(r) is Next.WORK:
        _guard_limits(v, violated)
        if wanted(v, from_motor=from_motor):
            do_work(r, from_motor=from_motor)
    if from_motor and v.stup == StatusUpdate.BUSY:
        v.stup = StatusUpdate.OFF
    r.resolution_written = False
    raise_alarm(v)
    r.journal.post_changes()


def _follow(r: State) -> Next:
    """Follow what the motor did."""
    readback.work_out(r)
    if r.v.movn:
        _while_moving(r)
        return Next.WORK
    if r.v.stup == StatusUpdate.BUSY and not _ends_motion(r):
        return Next.WORK
    return _at_rest(r)


def _ends_motion(r: State) -> bool:
    """True if a status that was awaited ends a motion as well: else that would never be over."""
    over = r.v.dmov and not r.v.mip & Mip.STOP
    return not (over or r.status_for_client or r.by_write)


def _while_moving(r: State) -> None:
    v = r.v
    if v.dmov:
        v.dmov = 0
        v.mip |= Mip.EXTERNAL
        v.pp = 1
    if v.ntm and _target_behind(v):
        moving.stop(r)
        v.mip |= Mip.STOP
        v.pp = 0


def _target_behind(v: Values) -> bool:
    """True if a move goes away from its target, and that is far."""
    far = abs(v.diff) > v.ntmf * (abs(v.bdst) + v.rdbd)
    away = (v.rdif >= 0) != bool(v.cdir)
    return far and away and bool(v.mip & (Mip.MOVE | Mip.RETRY)) and not v.mip & Mip.STOP


def _at_rest(r: State) -> Next:
    """Follow up a motion that is over, or a status of a motor at rest."""
    v = r.v
    stopped_now = not v.dmov
    v.dmov = 1
    if stopped_now and v.mip in (Mip.JOGF, Mip.JOGR):
        _jog_ended_by_itself(v)
    if v.mip != Mip.DONE and at_switch_ahead(v):
        _look_again(r)
        return Next.LEAVE
    if v.pp:
        if v.val != v.lval and not r.has(Mip.STOP, Mip.JOG_STOP):
            _new_target_came(v)
            return Next.WORK
        follow_up(r)
    if at_switch_ahead(v) or v.mip == Mip.LOAD_P:
        v.mip = Mip.DONE
        return Next.WORK
    return _settle(r, stopped_now) if v.dmov else Next.WORK


def _new_target_came(v: Values) -> None:
    """Forget what was in progress: the target that came meanwhile is next, before all buttons."""
    v.mip = Mip.DONE
    v.homf = v.homr = 0


def _jog_ended_by_itself(v: Values) -> None:
    readback.release_buttons(v)
    v.mip = Mip.DONE
    v.pp = 1


def _look_again(r: State) -> None:
    """Ask for the position at the switch before anything else is done."""
    v = r.v
    v.dmov, v.pp, v.mip = 0, 1, Mip.DONE
    r.ask(Verb.GET_INFO)


def _settle(r: State, stopped_now: bool) -> Next:
    """Wait for DLY after a motion, then decide on a retry."""
    v = r.v
    if v.dly > 0 and not v.mip & Mip.DELAY_ACK:
        return _wait(r) if stopped_now else Next.WORK
    if v.mip & Mip.DELAY == Mip.DELAY_ACK:
        return _look_after_delay(r)
    if v.stup != StatusUpdate.ON and v.mip != Mip.DONE:
        _judge(r)
    return Next.WORK


def _look_after_delay(r: State) -> Next:
    """Ask where the motor is, now that it has settled."""
    r.v.mip |= Mip.DELAY
    r.v.dmov = 0
    r.ask(Verb.GET_INFO)
    return Next.LEAVE


def _judge(r: State) -> None:
    """Decide on a retry. A controller that servoes gets another DLY instead."""
    v = r.v
    v.mip &= ~Mip.DELAY
    retry_or_end(r)
    if v.mip == Mip.RETRY and v.rmod == RetryMode.IN_POSITION:
        _begin_delay(r)


def _wait(r: State) -> Next:
    r.v.dmov = 0
    if not r.v.mip & Mip.DELAY_REQ:
        _begin_delay(r)
    return Next.LEAVE


def _begin_delay(r: State) -> None:
    r.v.mip |= Mip.DELAY_REQ
    r.delay_s = r.v.dly


def _guard_limits(v: Values, violated: int) -> None:
    """Stop a jog that comes near a limit. Homing is free."""
    if not limits.enabled(v) or v.mip & Mip.HOME:
        v.lvio = 0
    elif v.mip & Mip.JOG:
        v.lvio = int(limits.jog_violates(v, v.rbv))
    if v.lvio and not violated and not v.set and not v.igset:
        v.stop = 1
        readback.release_buttons(v)


def raise_alarm(v: Values) -> None:
    """Set STAT and SEVR."""
    v.stat, v.sevr = _alarm(v)


def _alarm(v: Values) -> tuple[int, int]:
    if v.udf:
        return Alarm.UDF, Severity.INVALID
    if v.hlsv and (v.hls or v.dval > v.dhlm):
        return Alarm.HIGH, v.hlsv
    if v.hlsv and (v.lls or v.dval < v.dllm):
        return Alarm.LOW, v.hlsv
    if shows(v, Msta.COMM_ERR):
        return _communication(v)
    if shows(v, Msta.SLIP_STALL) or shows(v, Msta.PROBLEM):
        return Alarm.STATE, Severity.MAJOR
    return Alarm.NONE, Severity.NONE


def _communication(v: Values) -> tuple[int, int]:
    """Report the error once: the bit goes, the next status sets it again."""
    v.msta &= ~Msta.COMM_ERR.value
    return Alarm.COMM, Severity.INVALID
