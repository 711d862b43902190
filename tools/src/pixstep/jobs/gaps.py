# SPDX-License-Identifier: MIT
"""How many pixels of the clock passed between the lines of a run, by a board's own counts.

A board counts the clock's edges, and the pixels that its lines have made. What it has counted since
the first line began and no line has made is a gap. On a gated clock each line has a burst: there a
gap is what lies between two lines beyond the shortest such distance, a burst that no line had.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from pixstep.jobs.account import JobAxis
from pixstep.jobs.job import Job
from pixstep.jobs.stations import Station

_EDGES = 0x10000  # a board counts so far


@dataclass
class Gaps:
    """Clock edges beside lines. `looks` is how often they were compared."""

    job: Job
    divider: int
    gated: bool
    looks: int = 0
    _most_px: int = 0
    # The first line that is known to have begun, and the edge of its line zero.
    _zero: tuple[int, int] | None = None
    _zeros: dict[int, int] = field(default_factory=dict)  # on a gated clock, by line

    @property
    def px(self) -> int:
        """Pixels between lines, all together."""
        if not self.gated:
            return self._most_px
        lines = sorted(self._zeros)
        apart = [
            (self._zeros[line] - self._zeros[line - 1]) % _EDGES
            for line in lines if line - 1 in self._zeros
        ]  # fmt: skip
        return sum(one - min(apart) for one in apart) // self.divider

    def look(self, station: Station, first: int) -> list[JobAxis]:
        """Look at a board's axes, and at its clock right before; `first` began the chain."""
        clock = station.board.inputs_from("zero_edge", "clock_edge")
        axes = station.look()
        running = [axis for axis in axes if axis.state == "running"]
        if not self._zero and (running or any(axis.counted for axis in axes)):
            self._zero = first, clock["zero_edge"]
        if running:
            line, pixel = max((first + axis.counted, axis.now["pixel"]) for axis in running)
            self._take(line, pixel, clock["zero_edge"], clock["clock_edge"])
        return axes

    def _take(self, line: int, pixel: int, zero_edge: int, clock_edge: int) -> None:
        self.looks += 1
        if self.gated:
            self._zeros[line] = zero_edge  # of a line's last look it is surely the line's own
        elif self._zero:
            begun, zero = self._zero
            made = ((line - begun) * self.job.pixels + pixel) * self.divider
            beside = (clock_edge - zero - made) % _EDGES
            if beside < _EDGES // 2:
                self._most_px = max(self._most_px, beside // self.divider)
