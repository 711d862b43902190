# SPDX-License-Identifier: MIT
"""What there is to know about one field of the record, and how a client's value becomes its own.

The menus of the record: their texts as clients see them, and the numbers that the model uses.

The names of records, and whether the text of a link is one.
"""

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, partial
from typing import Final

from pixstep.errors import MISUSE, PlainError

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


LONGEST = 55  # with a point and four letters of a field EPICS has room for no more
_NAME = re.compile(r"[A-Za-z0-9_:;<>\[\]{}/+-]+")
WANTED = f"letters, digits and _ - : ; < > [ ] {{ }} / + are wanted, at most {LONGEST}"


def is_record_name(text: str) -> bool:
    """True if a record can have this name."""
    return len(text) <= LONGEST and _NAME.fullmatch(text) is not None


def names_a_record(text: str) -> bool:
    """True for the text of a link to a record: neither empty nor a number."""
    try:
        float(text)
    except ValueError:
        return bool(text.strip())
    return False


Value = float | int | str


class PutRefusedError(PlainError):
    """A write that the record does not take: the field, the value, and why."""

    status = MISUSE

    def __init__(self, field: str, value: Value, reason: str) -> None:
        super().__init__(f"{field}: {value!r} is refused: {reason}")
        self.field = field
        self.value = value
        self.reason = reason


class FieldType(StrEnum):
    """The kinds of fields, by the names of EPICS' database definition without DBF_."""

    DOUBLE = "double"
    FLOAT = "float"
    LONG = "long"
    ULONG = "ulong"
    SHORT = "short"
    USHORT = "ushort"
    UCHAR = "uchar"
    MENU = "menu"
    STRING = "string"
    LINK = "link"


HIGHEST = 1e100
"""Of any number; its inverse is the least that is not 0. Products and quotients stay numbers."""

TEXTS = (FieldType.STRING, FieldType.LINK)
BITS = {
    FieldType.LONG: 32,
    FieldType.ULONG: 32,
    FieldType.SHORT: 16,
    FieldType.USHORT: 16,
    FieldType.UCHAR: 8,
}
SIGNED = (FieldType.LONG, FieldType.SHORT)


@dataclass(frozen=True)
class RecordField:
    """One field. `unit` is as clients see it, EGU standing for the text of the field EGU."""

    name: str
    type: FieldType
    meaning: str
    unit: str = ""
    default: Value = 0
    writable: bool = True
    processes: bool = False
    """A write makes the record look at its fields and act."""
    menu: tuple[str, ...] = ()
    limits: tuple[str, str] | None = None
    """The fields with the lowest and the highest value, as DBR_CTRL gives them to clients."""
    group: str = ""
    monitored: bool = True
    size: int = 40
    """Of a text: how many bytes the record has for it, with the zero at the end."""

    @cached_property
    def attribute(self) -> str:
        """The name of the field among the values of the model."""
        return self.name.lower()

    def taken(self, value: Value) -> Value:
        """Return a client's value as the field holds it; PutRefusedError if it can't."""
        if self.type in TEXTS:
            return self._text(value)
        if self.type is FieldType.MENU:
            return self._choice(value)
        number = self._number(value)
        if self.type is FieldType.DOUBLE:
            return number
        if self.type is FieldType.FLOAT:
            return self._single(number)
        return self._whole(number)

    def _text(self, value: Value) -> str:
        text = value if isinstance(value, str) else f"{value:.10g}"
        if self.type is FieldType.STRING and len(text.encode()) >= self.size:
            raise PutRefusedError(self.name, value, f"at most {self.size - 1} bytes")
        return text

    def _choice(self, value: Value) -> int:
        if isinstance(value, str):
            text = OTHER_TEXTS.get(self.name, {}).get(value, value)
            if text in self.menu:
                return self.menu.index(text)
        number = self._number(value, f"a number, or one of {', '.join(self.menu)}")
        if not 0 <= number < len(self.menu):
            raise PutRefusedError(self.name, value, f"0 to {len(self.menu) - 1}")
        return int(number)

    def _number(self, value: Value, wanted: str = "a number") -> float:
        try:
            number = float(value)
        except ValueError:
            raise PutRefusedError(self.name, value, f"{wanted} is wanted") from None
        if not abs(number) <= HIGHEST:
            raise PutRefusedError(self.name, value, f"a number of at most {HIGHEST:g} is wanted")
        return number if abs(number) >= 1 / HIGHEST else 0.0

    def _single(self, number: float) -> float:
        try:
            packed = struct.pack("<f", number)
        except OverflowError:
            raise PutRefusedError(self.name, number, "at most 3.4e38") from None
        single: float = struct.unpack("<f", packed)[0]
        return single

    def _whole(self, number: float) -> int:
        bits = BITS[self.type]
        lowest, highest = 0, 2**bits - 1
        if self.type in SIGNED:
            lowest, highest = -(2 ** (bits - 1)), 2 ** (bits - 1) - 1
        if not lowest <= int(number) <= highest:
            raise PutRefusedError(self.name, number, f"{lowest} to {highest}")
        return int(number)


setting = partial(RecordField, type=FieldType.DOUBLE)
"""A number that clients write."""
reading = partial(RecordField, type=FieldType.DOUBLE, writable=False)
"""A number that only the record writes."""
count = partial(RecordField, type=FieldType.LONG)
counted = partial(RecordField, type=FieldType.LONG, writable=False)
button = partial(RecordField, type=FieldType.SHORT)
flag = partial(RecordField, type=FieldType.SHORT, writable=False)
choice = partial(RecordField, type=FieldType.MENU)
text = partial(RecordField, type=FieldType.STRING)
link = partial(RecordField, type=FieldType.LINK, default="")
