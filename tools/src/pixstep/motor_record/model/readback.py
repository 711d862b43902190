# SPDX-License-Identifier: MIT
"""A status of the motor becomes fields: positions, switches, states."""

from pixstep.motor_record.menus import RetryMode
from pixstep.motor_record.model import coordinates
from pixstep.motor_record.model.coordinates import difference, nearest_long, user, user_is_raw
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Mip, Msta, Status


def shows(v: Values, flag: Msta) -> bool:
    """True if the status of the motor has a bit."""
    return bool(v.msta & flag.value)


def take(v: Values, status: Status) -> None:
    """Copy what the driver says."""
    v.rmp = status.position_steps
    v.rep = status.encoder_counts
    known, v.msta = v.msta, int(status.flags)
    if v.msta != known and shows(v, Msta.GAIN_SUPPORT):
        v.cnen = int(shows(v, Msta.EA_POSITION))
    v.rvel = nearest_long(status.speed_steps_per_s)


def work_out(r: State, *, first: bool = False) -> None:
    """Work out all that follows from the status. `first`: at the start, links are not read."""
    v = r.v
    if v.ueip and not shows(v, Msta.EA_PRESENT):
        v.ueip = 0
    if not newest_position(r, links=not first) and v.mip != Mip.DONE:
        release_buttons(v)
        v.stop = 1
    v.tdir = int(shows(v, Msta.DIRECTION))
    _switches(v)
    _movement(v)
    v.athm = int(shows(v, Msta.EA_HOME if v.ueip else Msta.HOME))
    difference(v)


def newest_position(r: State, *, links: bool = True) -> bool:
    """Make all readbacks the newest position. False if the link that gives it is dead."""
    v = r.v
    if v.ueip:
        _set_raw(v, v.rep, v.eres)
    elif v.urip and links:
        return _read_link(r)
    else:
        _set_raw(v, v.rmp, v.mres)
    return True


def _set_raw(v: Values, raw: int, resolution: float) -> None:
    """Make all readbacks agree with a raw one."""
    v.rrbv = raw
    v.drbv = raw * resolution
    v.rbv = user(v, v.drbv)


def _read_link(r: State) -> bool:
    """Take the position from RDBL. False if that is dead: the position stays what it was."""
    if r.rdbl.value is None:
        return False
    _set_raw(r.v, nearest_long(r.rdbl.value * r.v.rres / r.v.mres), r.v.mres)
    return True


def _switches(v: Values) -> None:
    v.rhls = int(shows(v, Msta.PLUS_LS))
    v.rlls = int(shows(v, Msta.MINUS_LS))
    v.hls, v.lls = (v.rhls, v.rlls) if user_is_raw(v) else (v.rlls, v.rhls)


def at_switch_ahead(v: Values) -> bool:
    """True if the limit switch in the direction of the motion is active."""
    return bool(v.rhls if v.cdir else v.rlls)


def _movement(v: Values) -> None:
    halted = at_switch_ahead(v) or shows(v, Msta.PROBLEM)
    v.movn = int(not (halted or shows(v, Msta.DONE)))
    if halted:
        release_buttons(v)


def release_buttons(v: Values) -> None:
    """Clear the wishes to jog and to find the home switch."""
    v.jogf = v.jogr = v.homf = v.homr = 0


def relative(v: Values) -> bool:
    """True where moves are distances, since the position comes from elsewhere than the motor."""
    return v.rtry != 0 and v.rmod != RetryMode.IN_POSITION and bool(v.ueip or v.urip)


def targets_become_readbacks(r: State) -> None:
    """Make all targets the newest position, also as the last ones."""
    newest_position(r)
    coordinates.targets_from_readback(r.v)
    coordinates.keep_as_last(r.v)
