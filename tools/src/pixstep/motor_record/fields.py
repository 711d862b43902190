# SPDX-License-Identifier: MIT
"""All fields of the motor record, and the order in which what changed is posted."""

from collections.abc import Mapping
from typing import Final

from pixstep.motor_record.catalogue import general, motion, position
from pixstep.motor_record.field import RecordField

FIELDS: Final[Mapping[str, RecordField]] = {
    field.name: field for field in position.TABLE + motion.TABLE + general.TABLE
}

# After one processing, as the record does it: what the write of a setting changed beside it comes
# first, DMOV nearly last, so that whoever waits for DMOV has the position.
_LAST_POSTED: Final = (
    *("STAT", "SEVR", "RBV", "RRBV", "DRBV", "DIFF", "RDIF", "MSTA", "CNEN", "VAL", "DVAL"),
    *("RVAL", "TDIR", "MIP", "HLM", "LLM", "SPMG", "RCNT", "RLV", "OFF", "DHLM", "DLLM", "HLS"),
    *("LLS", "RHLS", "RLLS", "ATHM", "MRES", "ERES", "UEIP", "LVIO", "STOP", "SBAS", "SREV"),
    *("UREV", "VELO", "VBAS", "MISS", "MOVN", "DMOV", "STUP", "JOGF", "JOGR", "HOMF", "HOMR"),
)
MONITOR_ORDER: Final = tuple(
    name for name, field in FIELDS.items() if field.monitored and name not in _LAST_POSTED
) + tuple(_LAST_POSTED)
