# SPDX-License-Identifier: MIT
"""What the record does next: it looks at the wishes of clients in a fixed order.

Status, stop, resolution, buttons, targets: the first that is there settles this processing.
"""

from pixstep.motor_record.menus import StatusUpdate
from pixstep.motor_record.model import buttons, coordinates, limits, moving
from pixstep.motor_record.model.coordinates import nearest_long
from pixstep.motor_record.model.readback import targets_become_readbacks
from pixstep.motor_record.model.resolution import keep_dead_bands
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Mip, Verb


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
    if coordinates.setting_position(v):
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
    if coordinates.setting_position(v) and not v.foff:
        redefine_user_position(r)
        return False
    v.dval = coordinates.dial(v, v.val)
    return True


def _dial_target(r: State) -> None:
    """Act on DVAL: a move, or a position where SET is on."""
    v = r.v
    coordinates.difference(v)
    if not coordinates.setting_position(v):
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
    if not coordinates.countable(v, v.dval):
        coordinates.back_to_last(v)
        v.dmov = 1
        return
    raw = v.dval / v.mres
    v.rval = nearest_long(raw)
    if v.foff:
        v.val = coordinates.user(v, v.dval)
    else:
        v.off = v.val - v.dval * coordinates.direction(v)
        limits.user_limits_from_dial(v)
    coordinates.keep_as_last(v)
    v.mip, v.dmov = Mip.LOAD_P, 0
    r.ask(Verb.LOAD_POS, raw)
    r.ask(Verb.GET_INFO)


def redefine_user_position(r: State) -> None:
    """Change OFF so that the axis is at VAL. The controller is not asked."""
    v = r.v
    v.off = v.val - v.dval * coordinates.direction(v)
    v.rbv = coordinates.user(v, v.drbv)
    limits.user_limits_from_dial(v)
    v.lval = v.val
    v.mip, v.dmov = Mip.DONE, 1
