# SPDX-License-Identifier: MIT
"""The alarm of the record: the first in this order, since a limit hides what the motor reports."""

from pixstep.motor_record.menus import Alarm, Severity
from pixstep.motor_record.model.readback import shows
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Msta


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
