# SPDX-License-Identifier: MIT
"""The menus of the record: their texts as clients see them, and the numbers that the model uses."""

from collections.abc import Mapping
from typing import Final

NO_YES_CAPITALS: Final = ("NO", "YES")
NO_YES: Final = ("No", "Yes")
SEVERITY: Final = ("NO_ALARM", "MINOR", "MAJOR", "INVALID")
DIRECTION: Final = ("Pos", "Neg")
USE_SET: Final = ("Use", "Set")
OFFSET: Final = ("Variable", "Frozen")
SPMG: Final = ("Stop", "Pause", "Move", "Go")
ENABLE: Final = ("Disable", "Enable")
STATUS_UPDATE: Final = ("OFF", "ON", "BUSY")
RETRY_MODE: Final = ("Default", "Arithmetic", "Geometric", "In-Position")
ACCELERATION: Final = ("Use ACCL", "Use ACCS")
RESTORE: Final = ("Never", "Always", "NearZero", "Conditional")
OUTPUT_MODE: Final = ("supervisory", "closed_loop")
ALARM: Final = (
    *("NO_ALARM", "READ", "WRITE", "HIHI", "HIGH", "LOLO", "LOW", "STATE", "COS", "COMM"),
    *("TIMEOUT", "HWLIMIT", "CALC", "SCAN", "LINK", "SOFT", "BAD_SUB", "UDF", "DISABLE", "SIMM"),
    *("READ_ACCESS", "WRITE_ACCESS"),
)


class Spmg:
    """Numbers of the menu of SPMG."""

    STOP: Final = 0
    PAUSE: Final = 1
    MOVE: Final = 2
    GO: Final = 3


class StatusUpdate:
    """Numbers of the menu of STUP."""

    OFF: Final = 0
    ON: Final = 1
    BUSY: Final = 2


class RetryMode:
    """Numbers of the menu of RMOD."""

    DEFAULT: Final = 0
    ARITHMETIC: Final = 1
    GEOMETRIC: Final = 2
    IN_POSITION: Final = 3


class Restore:
    """Numbers of the menu of RSTM."""

    NEVER: Final = 0
    ALWAYS: Final = 1
    NEAR_ZERO: Final = 2
    CONDITIONAL: Final = 3


class Alarm:
    """Numbers of the alarms that the record raises (STAT)."""

    NONE: Final = 0
    HIGH: Final = 4
    LOW: Final = 6
    STATE: Final = 7
    COMM: Final = 9
    UDF: Final = 17


class Severity:
    """Numbers of the severities (SEVR)."""

    NONE: Final = 0
    MAJOR: Final = 2
    INVALID: Final = 3


# What a database file may say instead of a menu's text, since older records did.
OTHER_TEXTS: Final[Mapping[str, Mapping[str, str]]] = {
    "ACCU": {"Accl": "Use ACCL", "Accs": "Use ACCS"},
}
