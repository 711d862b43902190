# SPDX-License-Identifier: MIT
"""The generated part of docs/EPICS.md: every PV of a motor, and those of the server."""

from collections.abc import Iterable

from pixstep.ioc import common, names
from pixstep.motor_record import FIELDS, NOT_SERVED, FieldType, RecordField
from pixstep_dev.markdown import table

# The types by which Channel Access has the fields.
_TYPES = {
    FieldType.DOUBLE: "double",
    FieldType.FLOAT: "float",
    FieldType.LONG: "long",
    FieldType.ULONG: "double",
    FieldType.SHORT: "short",
    FieldType.USHORT: "long",
    FieldType.UCHAR: "char",
    FieldType.MENU: "enum",
    FieldType.STRING: "string",
    FieldType.LINK: "string",
}


def epics() -> str:
    """Return the tables as Markdown."""
    not_served = {**NOT_SERVED, **names.NOT_SERVED}
    return "\n".join(
        [
            "### Fields of a motor: `PREFIX` + motor + `.FIELD`\n",
            _fields(FIELDS.values()),
            "\n### Fields that every record has: read-only here\n",
            _fields(common.COMMON.values()),
            "\n### The server itself: `PREFIX` + `IOC:` + name\n",
            table(
                ("PV", "meaning"),
                [(f"`{names.GROUP}{name}`", text) for name, text in names.STATUS.items()],
            ),
            "\n### Not served\n",
            table(
                ("field or PV", "why"),
                [(f"`{name}`", reason) for name, reason in not_served.items()],
            ),
        ]
    )


def _fields(fields: Iterable[RecordField]) -> str:
    return table(
        ("field", "type", "access", "unit", "control limits", "meaning"),
        [_row(field) for field in fields],
    )


def _row(field: RecordField) -> tuple[str, ...]:
    limits = " to ".join(f"`{name}`" for name in field.limits) if field.limits else ""
    choices = f": {', '.join(field.menu)}" if field.menu and len(field.menu) <= 4 else ""
    return (
        f"`{field.name}`",
        _TYPES[field.type],
        "read, write" if field.writable else "read",
        field.unit,
        limits,
        field.meaning + choices,
    )
