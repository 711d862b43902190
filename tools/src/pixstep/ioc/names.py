# SPDX-License-Identifier: MIT
"""The names of all PVs that a server has."""

from __future__ import annotations

from collections.abc import Iterable

from pixstep.ioc.common import ALL

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
