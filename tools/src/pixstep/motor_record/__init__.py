# SPDX-License-Identifier: MIT
"""The motor record of EPICS as a model: without input and output, and without a clock of its own.

A client's writes and the motor's status go in, commands to the motor and changed fields come out.
Nothing here knows a board, a bus or EPICS' protocol, so that others can use the model alone.
"""

from pixstep.motor_record.catalogue import FIELDS, MONITOR_ORDER, NOT_SERVED
from pixstep.motor_record.field import FieldType, PutRefusedError, RecordField
from pixstep.motor_record.model.record import LinkName, MotorRecord
from pixstep.motor_record.traffic import Drive, Mip, MotorCommand, Msta, Outcome, Post, Status, Verb

__all__ = [
    "FIELDS",
    "MONITOR_ORDER",
    "NOT_SERVED",
    "Drive",
    "FieldType",
    "LinkName",
    "Mip",
    "MotorCommand",
    "MotorRecord",
    "Msta",
    "Outcome",
    "Post",
    "PutRefusedError",
    "RecordField",
    "Status",
    "Verb",
]
