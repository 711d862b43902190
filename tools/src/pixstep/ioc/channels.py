# SPDX-License-Identifier: MIT
"""Fields of a motor record as PVs: types, units, precision and limits as clients of EPICS see them.

A value is the record's own at every read. A monitor has the value that was posted, although the
record may be further by the time when the monitor is sent.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import caproto
from caproto import AlarmSeverity, AlarmStatus, ChannelType, SubscriptionType

from pixstep.motor_record import FieldType, RecordField

if TYPE_CHECKING:
    from pixstep.motor_record.field import Value

MAX_ENUM_STATES = 16
ENCODING = "utf-8"
_STRING_BYTES = 39  # of a text that is no long string: one more is the zero
_UNIT_BYTES = 7
_ALARMED = ("VAL", "RBV", "DVAL")
_ON_CHANGE = SubscriptionType.DBE_VALUE | SubscriptionType.DBE_LOG
# What a field's units, precision and limits come from, apart from its own limits.
SHAPE = (
    "EGU", "PREC", "HLM", "LLM", "DHLM", "DLLM", "RHLM", "RLLM", "VBAS", "VMAX", "HOPR", "LOPR",
    "HIHI", "HIGH", "LOW", "LOLO",
)  # fmt: skip


class FieldOwner(Protocol):
    """A record whose fields are PVs."""

    def __getitem__(self, field: str) -> Value:
        """Return the value of a field as it is now."""

    async def put(self, field: str, value: Value) -> None:
        """Write a field, and return when what that begins is over."""


class FieldChannel(caproto.ChannelData):  # type: ignore[misc]  # caproto has no types
    """One field. The classes below add its type."""

    def __init__(
        self, owner: FieldOwner, field: RecordField, alarm: caproto.ChannelAlarm, **more: Any
    ):
        self._owner, self.field = owner, field
        self._flags = _ON_CHANGE
        super().__init__(
            value=owner[field.name], alarm=alarm, string_encoding=ENCODING,
            reported_record_type="motor", max_length=1, **more,
        )  # fmt: skip

    def now(self) -> Value:
        """Return the value as it is now."""
        return self._owner[self.field.name]

    async def post(self, value: Value, time_s: float) -> None:
        """Tell clients a new value."""
        self._data["timestamp"] = caproto.TimeStamp.from_flexible_value(time_s)
        self._data["value"] = value
        await self.publish(_ON_CHANGE)

    async def post_alarm(self) -> None:
        """Tell clients of alarms, without a new value."""
        self._update()
        await self.publish(SubscriptionType.DBE_ALARM)

    async def post_shape(self) -> None:
        """Tell those that asked for properties that units or limits are others."""
        self._update()
        await self.publish(SubscriptionType.DBE_PROPERTY)

    async def publish(self, flags: Any) -> None:
        """Put what has changed into the queues of clients that asked for such changes."""
        self._flags = flags
        await super().publish(flags)

    def _is_eligible(self, ss: Any) -> bool:
        return bool(ss.mask & self._flags) and bool(super()._is_eligible(ss))

    async def read(self, data_type: Any) -> Any:
        """Return the value as it is now."""
        self._update()
        return await super().read(data_type)

    async def subscribe(self, queue: Any, sub_spec: Any, sub: Any) -> None:
        """Take a new client in, which is told the value as it is now."""
        self._update()
        await super().subscribe(queue, sub_spec, sub)

    def _update(self) -> None:
        self._content.clear()
        self._data["value"] = self._owner[self.field.name]

    async def _read(self, data_type: Any) -> Any:
        """Return a value as clients ask for it; as a text it has the record's digits."""
        value = self._data["value"]
        try:
            if _is_string(data_type):
                self._data["value"] = [self._text(value)]
            return await super()._read(data_type)
        finally:
            self._data["value"] = value

    def _text(self, value: Any) -> str:
        """Return the value as a text of EPICS' size."""
        text = str(value)
        if isinstance(value, float):
            text = f"{value:.{max(0, int(self._owner['PREC']))}f}"
        elif self.field.menu:
            text = self.field.menu[int(value)]
        return _cut(text, _STRING_BYTES)

    def _read_metadata(self, dbr_metadata: Any) -> None:
        if hasattr(dbr_metadata, "units"):
            self._data.update(self._shape())
        super()._read_metadata(dbr_metadata)

    def _shape(self) -> dict[str, Any]:
        """Return units, precision and limits."""
        shape: dict[str, Any] = {
            "units": _cut(self.field.unit.replace("EGU", str(self._owner["EGU"])), _UNIT_BYTES),
            "precision": int(self._owner["PREC"]),
        }
        if self.field.limits:
            low, high = (self._number(name) for name in self.field.limits)
            shape |= {"lower_ctrl_limit": low, "upper_ctrl_limit": high}
            shape |= {"lower_disp_limit": low, "upper_disp_limit": high}
        if self.field.name in ("VAL", "RBV") and self._number("LOPR") != self._number("HOPR"):
            shape |= {
                "lower_disp_limit": self._number("LOPR"),
                "upper_disp_limit": self._number("HOPR"),
            }
        if self.field.name in _ALARMED:
            shape |= {
                "upper_alarm_limit": self._number("HIHI"),
                "upper_warning_limit": self._number("HIGH"),
                "lower_warning_limit": self._number("LOW"),
                "lower_alarm_limit": self._number("LOLO"),
            }
        return shape

    def _number(self, name: str) -> float | int:
        value = float(self._owner[name])
        return value if self.data_type in (ChannelType.DOUBLE, ChannelType.FLOAT) else int(value)

    async def write_from_dbr(
        self, data: Any, data_type: Any, metadata: Any, *, flags: int = 0
    ) -> Any:
        """Take a client's write to the record; what it refuses is an error of the write."""
        if data_type in (ChannelType.PUT_ACKS, ChannelType.PUT_ACKT):
            return await super().write_from_dbr(data, data_type, metadata, flags=flags)
        await self._owner.put(self.field.name, _written(data, data_type))
        return None


def _cut(text: str, most_bytes: int) -> str:
    """Return as much of a text as Channel Access has room for."""
    return text.encode(ENCODING)[:most_bytes].decode(ENCODING, errors="ignore")


def _is_string(data_type: Any) -> bool:
    """True for a value that goes over the wire as a text of at most 40 bytes."""
    return data_type in ChannelType and caproto.native_type(data_type) == ChannelType.STRING


def _written(data: Any, data_type: Any) -> Value:
    """Return what a client has written: a text, or a number. An empty write is an empty text."""
    native = caproto.native_type(data_type)
    if native == ChannelType.STRING:
        return bytes(data[0]).decode(ENCODING, errors="replace") if len(data) else ""
    if native == ChannelType.CHAR and len(data) != 1:
        return bytes(data).partition(b"\0")[0].decode(ENCODING, errors="replace")
    if not len(data):
        return ""
    found = data[0]
    whole = native not in (ChannelType.DOUBLE, ChannelType.FLOAT)
    return int(found) if whole else float(found)


class _Double(FieldChannel, caproto.ChannelDouble):  # type: ignore[misc]
    pass


class _Float(FieldChannel, caproto.ChannelFloat):  # type: ignore[misc]
    pass


class _Long(FieldChannel, caproto.ChannelInteger):  # type: ignore[misc]
    pass


class _Short(FieldChannel, caproto.ChannelShort):  # type: ignore[misc]
    pass


class _Byte(FieldChannel, caproto.ChannelShort):  # type: ignore[misc]
    data_type = ChannelType.CHAR


class _Menu(FieldChannel, caproto.ChannelEnum):  # type: ignore[misc]
    """A menu. Clients get the texts of its first 16 choices: Channel Access has room for these."""

    def __init__(self, owner: FieldOwner, field: RecordField, alarm: caproto.ChannelAlarm):
        super().__init__(owner, field, alarm, enum_strings=field.menu[:MAX_ENUM_STATES])
        self._data["enum_strings"] = field.menu

    @property
    def enum_strings(self) -> tuple[str, ...]:
        """The texts that clients get."""
        return self.field.menu[:MAX_ENUM_STATES]


class _String(FieldChannel, caproto.ChannelString):  # type: ignore[misc]
    pass


# As EPICS' Channel Access has them: it knows no unsigned numbers but bytes and menus.
_CLASSES: dict[FieldType, type[FieldChannel]] = {
    FieldType.DOUBLE: _Double,
    FieldType.FLOAT: _Float,
    FieldType.LONG: _Long,
    FieldType.ULONG: _Double,
    FieldType.SHORT: _Short,
    FieldType.USHORT: _Long,
    FieldType.UCHAR: _Byte,
    FieldType.MENU: _Menu,
    FieldType.STRING: _String,
    FieldType.LINK: _String,
}


def of_field(owner: FieldOwner, field: RecordField, alarm: caproto.ChannelAlarm) -> FieldChannel:
    """Return the PV of a field; all PVs of a record share its alarm."""
    more: dict[str, Any] = {}
    if field.type in (FieldType.STRING, FieldType.LINK):
        more["long_string_max_length"] = max(
            field.size, 1024 if field.type is FieldType.LINK else 0
        )
    return _CLASSES[field.type](owner, field, alarm, **more)


async def raise_alarm(alarm: caproto.ChannelAlarm, status: int, severity: int) -> bool:
    """Set the alarm of a record; return whether it was another."""
    if (int(alarm.status), int(alarm.severity)) == (status, severity):
        return False
    await alarm.write(status=AlarmStatus(status), severity=AlarmSeverity(severity), publish=False)
    return True
