# SPDX-License-Identifier: MIT
"""Stop, pause, home, jog and tweak: what a button does when the record looks at it.

A function that returns True has settled what this processing does.
"""

from pixstep.motor_record.field import Spmg
from pixstep.motor_record.model import limits, moving, readback
from pixstep.motor_record.model.readback import release_buttons, targets_become_readbacks
from pixstep.motor_record.model.state import State, Values
from pixstep.motor_record.traffic import Mip


def held(v: Values) -> bool:
    """True while SPMG lets nothing move."""
    return v.spmg in (Spmg.STOP, Spmg.PAUSE)


# --- STOP and SPMG -----------------------------------------------------------------------------


def stop_or_spmg(r: State) -> bool:
    """Act on STOP, or on a change of SPMG."""
    v = r.v
    stop_pressed = v.stop != 0
    if v.spmg != v.lspg:
        v.lspg = v.spmg
    elif stop_pressed:
        v.stop = 0
    else:
        return False
    if held(v) or stop_pressed:
        _stop(r, for_good=stop_pressed or v.spmg == Spmg.STOP)
        return True
    if v.spmg == Spmg.GO:
        _resume(v)
    else:
        v.mip, v.rcnt = Mip.DONE, 0
    return False


def _stop(r: State, *, for_good: bool) -> None:
    """Stop the motor. `for_good`: the target becomes the position, else it is kept."""
    v = r.v
    moving.stop(r)
    if for_good:
        if v.mip in (Mip.DONE, Mip.RETRY, Mip.STOP):
            _stop_at_rest(v)
            return
        if v.movn:
            v.pp = 1
            release_buttons(v)
        else:
            targets_become_readbacks(r)
    if v.mip & Mip.HOME:
        release_buttons(v)
    if not v.mip & Mip.DELAY_REQ:
        v.mip = Mip.STOP


def _stop_at_rest(v: Values) -> None:
    if v.mip & Mip.RETRY:
        v.mip, v.dmov = Mip.DONE, 1


def _resume(v: Values) -> None:
    if jog_wanted(v):
        v.mip = Mip.JOG_REQ
    elif v.mip == Mip.STOP:
        v.mip = Mip.DONE


# --- home --------------------------------------------------------------------------------------


def home(r: State) -> bool:
    """Begin to look for the home switch, if that is wanted."""
    v = r.v
    if not _home_wanted(v):
        return False
    if held(v):
        v.dmov = 0  # it begins at Go
        return True
    v.mip = Mip.HOMF if v.homf else Mip.HOMR
    v.pp = 1
    if v.movn:
        v.mip |= Mip.STOP
        moving.stop(r)
    else:
        begin_home(r)
    return True


def _home_wanted(v: Values) -> bool:
    ahead, behind = (v.lls, v.hls) if v.dir else (v.hls, v.lls)
    forwards = v.homf and not v.mip & Mip.HOMF and not ahead
    backwards = v.homr and not v.mip & Mip.HOMR and not behind
    return bool(forwards or backwards)


def begin_home(r: State) -> None:
    """Look for the home switch, now that the motor rests."""
    r.v.dmov = 0
    r.v.rcnt = 0
    moving.home(r)


# --- jog ---------------------------------------------------------------------------------------


def jog_wanted(v: Values) -> bool:
    """True if a jog button is down and its limit switch is not active."""
    return bool((v.jogf and not v.hls) or (v.jogr and not v.lls))


def jog(r: State) -> bool:
    """Begin a jog, or end one whose button was released."""
    v = r.v
    if v.mip & Mip.JOG_REQ and not v.mip & Mip.JOG and not held(v):
        _begin_jog(r)
        return True
    if v.mip & Mip.JOGGING and not v.mip & Mip.JOG_REQ:
        v.pp = 1
        v.mip = (v.mip | Mip.JOG_STOP) & ~Mip.JOGGING
        moving.stop(r)
        return True
    return bool(v.mip & Mip.AFTER_JOG)


def _begin_jog(r: State) -> None:
    v = r.v
    if limits.jog_violates(v, v.val):
        v.lvio = 1
        v.jogf = v.jogr = 0
        return
    v.mip = Mip.JOGF if v.jogf else Mip.JOGR
    v.pp = 1
    if v.movn:
        v.mip |= Mip.STOP
        moving.stop(r)
    else:
        v.dmov = 0
        moving.jog(r)


# --- tweaks and distances ----------------------------------------------------------------------


def relative_targets(v: Values) -> None:
    """Change VAL by a tweak or by RLV, DVAL by a written RVAL."""
    if v.twf or v.twr:
        v.val += v.twv if v.twf else -v.twv
        v.twf = v.twr = 0
    if v.rlv != v.lrlv:
        v.val += v.rlv
        v.rlv = v.lrlv = 0.0
    if v.rval != v.lrvl:
        v.dval = v.rval * v.mres


def targets_from_position(v: Values) -> None:
    """Make the targets the position, after a motion that had no target."""
    readback.targets_from_readback(v)
    v.diff, v.rdif = 0.0, 0
