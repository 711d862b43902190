# SPDX-License-Identifier: MIT
"""What there is to know about one field of the record, and how a client's value becomes its own."""

import struct
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from pixstep.errors import MISUSE, PlainError
from pixstep.motor_record.menus import OTHER_TEXTS

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
