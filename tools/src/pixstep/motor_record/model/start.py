# SPDX-License-Identifier: MIT
"""The start of a record: fields of a database file become consistent, the position is restored."""

from dataclasses import replace

from pixstep.motor_record.menus import Restore, Spmg
from pixstep.motor_record.model import coordinates, limits, readback, resolution, speeds
from pixstep.motor_record.model.coordinates import nearest_long
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Mip, Status, Verb


def initialise(r: State, status: Status) -> None:
    """Begin with the motor as `status` says."""
    v = r.v
    resolution.settle(v)
    speeds.settle(v)
    resolution.keep_dead_bands(v)
    if v.eres == 0:
        v.eres = v.mres
    v.udf = int(r.dol.exists)
    readback.take(v, _restored(r, status))
    readback.work_out(r, first=True)
    if not v.omsl:
        coordinates.targets_from_readback(v)
    _limits(r)
    _state(v)
    r.resolution_written = False
    r.journal.post_changes()


def _restored(r: State, status: Status) -> Status:
    """Set the controller's position to DVAL, if RSTM says so."""
    v = r.v
    if not _restores(v, status):
        return status
    raw = v.dval / v.mres
    r.ask(Verb.LOAD_POS, raw)
    return replace(status, position_steps=nearest_long(raw))


def _restores(v: Values, status: Status) -> bool:
    near = max(abs(v.rdbd), abs(v.mres))
    lost = abs(v.dval) > near and abs(status.position_steps * v.mres) < near
    if v.rstm == Restore.CONDITIONAL:
        return lost or readback.relative(v)
    return v.rstm == Restore.ALWAYS or (v.rstm == Restore.NEAR_ZERO and lost)


def _limits(r: State) -> None:
    """Make raw and user limits agree with the dial limits."""
    limits.high_dial_limit_changed(r)
    limits.low_dial_limit_changed(r)


def _state(v: Values) -> None:
    v.dmov, v.movn, v.mip = 1, 0, Mip.DONE
    v.lspg = v.spmg = Spmg.GO
    coordinates.difference(v)
    coordinates.keep_as_last(v)
    beyond = v.drbv > v.dhlm + v.mres or v.drbv < v.dllm - v.mres
    v.lvio = int(limits.enabled(v) and (beyond or limits.contradict(v)))
