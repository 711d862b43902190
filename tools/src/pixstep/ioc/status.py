# SPDX-License-Identifier: MIT
"""PVs of the server itself: whether it lives, since when, and which PVs it has."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from typing import Any

import caproto

from pixstep.ioc.common import GROUP
from pixstep.version import __version__

_NAMES_BYTES = 65_536


class StatusPvs:
    """The PVs of the server."""

    def __init__(self, records: Iterable[str]) -> None:
        names = "\n".join(records)
        self._began_s = time.monotonic()
        self._pvs: dict[str, Any] = {
            "HEARTBEAT": caproto.ChannelInteger(value=0),
            "UPTIME": caproto.ChannelString(value=_span(0)),
            "STARTTOD": caproto.ChannelString(value=_clock()),
            "VERSION": caproto.ChannelString(value=__version__),
            "MOTORS": caproto.ChannelInteger(value=len(names.split())),
            "LOST": caproto.ChannelInteger(value=0),
            "SAVED": caproto.ChannelString(value=""),
            "RECORDS": caproto.ChannelChar(value=names, max_length=_NAMES_BYTES),
        }
        for pv in self._pvs.values():
            pv.check_access = _read_only

    def named(self, prefix: str) -> Mapping[str, Any]:
        """Return the PVs by their names."""
        return {f"{prefix}{GROUP}{name}": pv for name, pv in self._pvs.items()}

    async def beat(self, lost: int) -> None:
        """Show that the server lives."""
        beats = self._pvs["HEARTBEAT"]
        await beats.write((beats.value + 1) & 0x7FFF_FFFF)
        await self._pvs["UPTIME"].write(_span(time.monotonic() - self._began_s))
        if self._pvs["LOST"].value != lost:
            await self._pvs["LOST"].write(lost)

    async def note_saved(self) -> None:
        """Show that the file has been written."""
        await self._pvs["SAVED"].write(_clock())


def _read_only(hostname: str, username: str) -> Any:
    del hostname, username
    return caproto.AccessRights.READ


def _clock() -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S")


def _span(seconds: float) -> str:
    minutes, second = divmod(int(seconds), 60)
    hours, minute = divmod(minutes, 60)
    days, hour = divmod(hours, 24)
    return f"{days} days, {hour:02}:{minute:02}:{second:02}"
