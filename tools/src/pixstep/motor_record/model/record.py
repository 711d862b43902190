# SPDX-License-Identifier: MIT
"""The motor record: writes, statuses and the end of a delay go in, an Outcome comes out.

The start of a record: fields of a database file become consistent, the position is restored.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Literal

from pixstep.motor_record.catalogue import FIELDS
from pixstep.motor_record.field import (
    PutRefusedError,
    RecordField,
    Restore,
    Spmg,
    Value,
    names_a_record,
)
from pixstep.motor_record.model import limits, readback, speeds, writes
from pixstep.motor_record.model.processing import process
from pixstep.motor_record.model.readback import nearest_long
from pixstep.motor_record.model.state import InputLink, State, Values
from pixstep.motor_record.traffic import Mip, MotorCommand, Msta, Outcome, Status, Verb, whole


def initialise(r: State, status: Status) -> None:
    """Begin with the motor as `status` says."""
    v = r.v
    speeds.settle_resolution(v)
    speeds.settle(v)
    speeds.keep_dead_bands(v)
    if v.eres == 0:
        v.eres = v.mres
    v.udf = int(r.dol.exists)
    readback.take(v, _restored(r, status))
    readback.work_out(r, first=True)
    if not v.omsl:
        readback.targets_from_readback(v)
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
    readback.difference(v)
    readback.keep_as_last(v)
    beyond = v.drbv > v.dhlm + v.mres or v.drbv < v.dllm - v.mres
    v.lvio = int(limits.enabled(v) and (beyond or limits.contradict(v)))


LinkName = Literal["RDBL", "DOL"]
_NO_FIELDS: Mapping[str, float | str] = {}


class MotorRecord:
    """One motor record. It has no clock and no motor: both are its caller's.

    The caller gives it what clients write and what the driver reports, one after the other, and
    takes each Outcome: commands for the motor, posts for clients, perhaps a delay to wait for.
    """

    def __init__(self, fields: Mapping[str, float | str] = _NO_FIELDS) -> None:
        """Take fields as a database file has them, menus by number or text.

        PutRefusedError: a name or a value that is none, or a field that only the record writes.
        """
        self._r = State()
        for name, value in fields.items():
            self._r.v.write(name, _writable(name, value).taken(value))
        self._r.dol.exists = names_a_record(self._r.v.dol)
        self._r.rdbl.exists = names_a_record(self._r.v.rdbl)
        limits.user_limits_from_dial(self._r.v)  # clients look at them before a motor has answered

    def __getitem__(self, field: str) -> Value:
        """Return any field of FIELDS: menus, buttons and flags as numbers."""
        return self._r.v.read(field)

    def forget_refused_jog(self) -> Outcome | None:
        """Forget the request of a jog that a limit has refused; None if there is none.

        The record keeps it, and would begin the jog when it is processed next, with its button
        released and no limit to end it: whoever serves the record calls this after each event.
        """
        v = self._r.v
        if v.mip != Mip.JOG_REQ or not v.lvio:
            return None
        v.mip = Mip.DONE
        if v.dmov:
            self._r.journal.post_changes()
        else:  # what was asked for before is made now, or refused
            process(self._r)
        return self._outcome()

    def values(self) -> dict[str, Value]:
        """Return all fields with their values."""
        return dict(zip(FIELDS, vars(self._r.v).values(), strict=True))

    def initialise(self, status: Status) -> Outcome:
        """Begin, with the motor as `status` says: once, before all else."""
        initialise(self._r, status)
        return self._outcome()

    def put(self, field: str, value: float | str, status: Status | None = None) -> Outcome:
        """Take a client's write. PutRefusedError: it is not taken, and nothing has changed.

        `status`: a status that came while this write waited; one processing takes both.
        """
        r = self._r
        taken = _writable(field, value).taken(value)
        writes.refuse(r.v, field, value)
        disabled = r.v.disa == r.v.disv
        if field in writes.TARGETS and r.v.dmov and not disabled:
            r.v.dmov = 0
            r.journal.post("DMOV")
        r.v.write(field, taken)
        if field == "VAL":
            r.journal.doubt(field)  # the value that it has in the end is told
        else:
            r.journal.post(field)
        if writes.act(r, field) and not disabled:
            process(r, status, by_write=True)
        else:
            r.journal.post_changes()
        return self._outcome()

    def update(self, status: Status) -> Outcome:
        """Take a new status of the motor."""
        process(self._r, status)
        return self._outcome()

    def delay_over(self) -> Outcome:
        """Go on after the delay that an Outcome asked for."""
        v = self._r.v
        if v.mip & Mip.DELAY_REQ:
            v.mip = (v.mip & ~Mip.DELAY_REQ) | Mip.DELAY_ACK
            process(self._r)
        return self._outcome()

    def set_link(self, link: LinkName, value: float | None) -> Outcome:
        """Say what a link gives from now on; None: what it reads is dead. Nothing is processed."""
        known: InputLink = self._r.rdbl if link == "RDBL" else self._r.dol
        known.value, known.exists = value, True
        return self._outcome()

    def _outcome(self) -> Outcome:
        r = self._r
        commands, r.commands = tuple(r.commands), []
        delay_s, r.delay_s = r.delay_s, None
        return Outcome(
            commands=commands,
            posts=r.journal.take(),
            second_leg=second_leg(r, commands),
            delay_s=delay_s,
            complete=bool(r.v.dmov),
        )


def _writable(name: str, value: Value) -> RecordField:
    field = FIELDS.get(name)
    if field is None:
        raise PutRefusedError(name, value, "the motor record has no such field")
    if not field.writable:
        raise PutRefusedError(name, value, "only the record writes it")
    return field


_FIRST_LEGS = Mip.MOVE | Mip.JOG_BL1
_SECOND_LEGS = Mip.MOVE_BL | Mip.JOG_BL2


def second_leg(r: State, commands: Iterable[MotorCommand]) -> tuple[MotorCommand, ...]:
    """Return the approach that follows the leg among `commands`, or nothing."""
    way = next((one for one in commands if one.verb in (Verb.MOVE_ABS, Verb.MOVE_REL)), None)
    if way is None or not r.v.mip & _FIRST_LEGS:
        return ()
    twin = r.twin()
    steps = _length(r, way)
    if twin.rdbl.value is not None and r.v.rres != 0:
        twin.rdbl.value += steps * r.v.mres / r.v.rres
    process(twin, _arrived(r, steps))
    return tuple(twin.commands) if twin.v.mip & _SECOND_LEGS else ()


def _length(r: State, way: MotorCommand) -> int:
    """Return how many steps the leg makes, with their sign."""
    steps = whole(way.argument)
    return steps if way.verb is Verb.MOVE_REL else steps - r.v.rmp


def _arrived(r: State, steps: int) -> Status:
    """Return the status that the end of the leg brings."""
    v = r.v
    counts = math.floor(steps * v.mres / v.eres + 0.5) if v.ueip else 0
    flags = (Msta(v.msta) | Msta.DONE) & ~(Msta.MOVING | Msta.DIRECTION)
    if v.cdir:
        flags |= Msta.DIRECTION
    return Status(v.rmp + steps, v.rep + counts, flags)
