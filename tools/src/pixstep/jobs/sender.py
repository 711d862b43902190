# SPDX-License-Identifier: MIT
"""The lines of a job on their way into the boards' queues: one after the other, on all axes.

Before the first block of a line goes out it is logged as queued, on the disk. So whatever happens,
a line of which a board has a part is one that the log names.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from pixstep.board.upload import LineUpload, feed, pause_s, said_divider
from pixstep.jobs.job import Job
from pixstep.jobs.stations import Station
from pixstep.lines.runs import queue_entries


class Sender:
    """Sends the lines `first` to `last` of a chain, as far as they are allowed.

    Each but the last says that another one follows, so that the axes of a board end at the same
    line if one of them gets its next line too late.

    `begun` is the newest line of which something may be on a board, `sent` the newest that is in
    the queues of all of them as a whole. `intend` is called with a line before it is begun.
    """

    def __init__(
        self, job: Job, chain: tuple[int, int], divider: int, intend: Callable[[int], None], *,
        gated: bool,
    ) -> None:  # fmt: skip
        self._job, self._divider, self._gated = job, divider, gated
        self._first, self._last = chain
        self._intend = intend
        self.begun = self.sent = self._first - 1
        self._uploads: dict[str, list[LineUpload]] = {}

    def send(self, stations: list[Station], last: int) -> None:
        """Send what the queues have room for, of the lines up to `last`."""
        while self._go_on(stations):
            if self.begun >= last:
                return
            self._intend(self.begun + 1)
            self.begun += 1
            self._uploads = {}

    def pause_s(self, stations: list[Station], pixel_s: float, most_s: float) -> float:
        """Return the seconds that may pass until `send` is called again."""
        uploads = (item for one in stations for item in self._uploads.get(one.name, ()))
        return pause_s(uploads, pixel_s, most_s)

    def _go_on(self, stations: list[Station]) -> bool:
        """Send what is left of the newest line; True if all of it is on every board."""
        if self.sent == self.begun:
            return True
        for station in stations:
            if station.name not in self._uploads:
                self._uploads[station.name] = self._begin(station)
        for station in stations:
            feed(self._uploads[station.name])
            if not all(item.begun for item in self._uploads[station.name]):
                return False  # the other boards would begin the line without this one
        if not all(item.done for one in stations for item in self._uploads[one.name]):
            return False
        for station in stations:
            for item in self._uploads[station.name]:
                item.require_taken()
        self.sent = self.begun
        return True

    def _begin(self, station: Station) -> list[LineUpload]:
        """Return what sends the newest line to a board, its axes in turn."""
        board, lines = station.board, self._job.line(self.begun)
        said = said_divider(board, self._divider)
        waits = self._gated or self.begun == self._first
        more = not self._gated and self.begun != self._last
        return [
            LineUpload(
                board, axis, queue_entries(replace(lines[name], clocked=waits), said, more=more)
            )
            for name, axis in station.motors.items()
        ]
