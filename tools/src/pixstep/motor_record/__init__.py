# SPDX-License-Identifier: MIT
"""The motor record of EPICS as a model: without input and output, and without a clock of its own.

A client's writes and the motor's status go in, commands to the motor and changed fields come out.
Nothing here knows a board, a bus or EPICS' protocol, so that others can use the model alone.
"""

from pixstep.motor_record.traffic import Command, Drive, Msta, Outcome, Post, Status, Verb

__all__ = ["Command", "Drive", "Msta", "Outcome", "Post", "Status", "Verb"]
