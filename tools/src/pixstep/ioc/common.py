# SPDX-License-Identifier: MIT
"""Fields that every record of EPICS has, whatever it is for: here none of them can be written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from pixstep.motor_record import FIELDS, FieldType, RecordField
from pixstep.motor_record.field import NO_YES_CAPITALS, SEVERITY

if TYPE_CHECKING:
    from pixstep.motor_record.field import Value

_SCAN = (
    "Passive", "Event", "I/O Intr", "10 second", "5 second", "2 second", "1 second", ".5 second",
    ".2 second", ".1 second",
)  # fmt: skip

_field = partial(RecordField, writable=False, monitored=False)
_text = partial(_field, type=FieldType.STRING)
_number = partial(_field, type=FieldType.SHORT)
_byte = partial(_field, type=FieldType.UCHAR)
_menu = partial(_field, type=FieldType.MENU)

# Without NAME, which is each record's own.
VALUES: Mapping[str, Value] = {
    "RTYP": "motor",
    "DTYP": "pixstep",
    "SCAN": 0,
    "PINI": 0,
    "PHAS": 0,
    "EVNT": "",
    "TSE": 0,
    "TSEL": "",
    "SDIS": "",
    "DISS": 0,
    "ACKT": 1,
    "ACKS": 0,
    "ASG": "",
    "FLNK": "",
    "PRIO": 0,
    "TPRO": 0,
    "PACT": 0,
    "LCNT": 0,
}

COMMON: Mapping[str, RecordField] = {
    one.name: one
    for one in (
        _text("NAME", meaning="the name of the record", size=61),
        _text("RTYP", meaning="the kind of record: motor"),
        _text("DTYP", meaning="what moves the motor: pixstep"),
        _menu("SCAN", menu=_SCAN, meaning="when it is processed by itself: never"),
        _menu("PINI", menu=NO_YES_CAPITALS, meaning="kept"),
        _number("PHAS", meaning="kept"),
        _text("EVNT", meaning="kept"),
        _number("TSE", meaning="the time of a value is the server's"),
        _text("TSEL", meaning="kept"),
        _text("SDIS", meaning="kept"),
        _menu("DISS", menu=SEVERITY, meaning="kept"),
        _menu("ACKT", menu=NO_YES_CAPITALS, meaning="kept"),
        _menu("ACKS", menu=SEVERITY, meaning="kept"),
        _text("ASG", meaning="kept"),
        _text("FLNK", meaning="nothing is processed after it"),
        _menu("PRIO", menu=("LOW", "MEDIUM", "HIGH"), meaning="kept"),
        _byte("TPRO", meaning="kept"),
        _byte("PACT", meaning="kept"),
        _byte("LCNT", meaning="kept"),
    )
    if one.name not in FIELDS
}

ALL: Mapping[str, RecordField] = {**FIELDS, **COMMON}


GROUP = "IOC:"
# PVs of the server itself, by what they mean.
STATUS = {
    "HEARTBEAT": "counts seconds while the server lives",
    "UPTIME": "how long the server runs, as `3 days, 04:05:06`",
    "STARTTOD": "when the server began",
    "VERSION": "the version of pixstep",
    "MOTORS": "how many motors it has",
    "LOST": "how many of them have no connection to their board",
    "SAVED": "when settings and positions were written last; empty: not yet",
    "RECORDS": "the names of its records, one a line (a long text)",
}
_COMPARE = ("START_POSITION", "END_POSITION", "INCREMENT", "PULSE_WIDTH", "ENABLE")
# What EPICS has standard PVs for and the boards can't do yet.
NOT_SERVED = {f"PCO_{name}": "position compare: the boards have no triggers" for name in _COMPARE}


def all_names(prefix: str, records: Iterable[str]) -> list[str]:
    """Return the names of all PVs, a record's own name before those of its fields."""
    found = [f"{prefix}{GROUP}{name}" for name in STATUS]
    for record in records:
        found += [record, *(f"{record}.{field}" for field in ALL)]
    return found
