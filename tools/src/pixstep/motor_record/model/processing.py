# SPDX-License-Identifier: MIT
"""One processing of the record: a status is followed up, then wishes are looked at."""

from enum import Enum, auto

from pixstep.motor_record.menus import Alarm, RetryMode, Severity, StatusUpdate
from pixstep.motor_record.model import asking, limits, readback, work
from pixstep.motor_record.model.after_motion import follow_up, retry_or_end
from pixstep.motor_record.model.readback import at_switch_ahead, shows
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Mip, Msta, Status, Verb


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
        if work.wanted(v, from_motor=from_motor):
            work.do_work(r, from_motor=from_motor)
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
        asking.stop(r)
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
