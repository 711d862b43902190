# SPDX-License-Identifier: MIT
"""When the edges of the pixel clock came, by the host's clock.

A board knows when an edge came by its own timer. A broadcast `mark`, which the board notes by a
coarse clock of its own, ties that timer to the host's time before the flight, while nothing else is
on the bus. During the flight the newest edge is looked at again and again, which says when it came;
edges between two looks are taken to be evenly spaced. Two errors are left. All times of a flight
are off by what the mark's frame took on its way, some milliseconds with a USB adapter. Each single
time is off by its edge's distance from an even clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pixstep.board import clock_marks, settings, values
from pixstep.board import registers as regs
from pixstep.board.clock_marks import COUNT, TICKS, UNIT_TICKS
from pixstep.board.device import Device
from pixstep.board.link import World
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
else:
    np, npt = lazy("numpy"), lazy("numpy.typing")

_MARK_BITS = 15 * 11  # of the frame that carries it: bytes, each with start, parity and stop


@dataclass(frozen=True)
class _Mark:
    """One instant: when the board heard a mark, by the host's clock and by its own coarse one."""

    heard_s: float
    ticks: int


class ClockTimes:
    """The times of one board's pixel clock. Make it before the lines are sent."""

    def __init__(self, device: Device, world: World) -> None:
        self._device, self._world = device, world
        self._tick_hz = device.tick_hz()
        self._mark = self._marked()
        self._begun_s = world.now_s()
        self._hz, self._edges_px, self._follows = 1.0, 1, True
        self._edges: list[int] = []  # since line zero, at each look
        self._seconds: list[float] = []  # when they came

    def armed(self) -> None:
        """Take what the lines have set; those that wait for no clock begin now."""
        self._begun_s = self._world.now_s()
        known = settings.read(self._device)
        self._hz = float(values.hz_of(known))
        self._edges_px = settings.divider_of(known)
        self._follows = known.get("sync") != regs.SYNCS["free"]

    def look(self) -> None:
        """Note the newest edge, while a line runs or after it."""
        if not self._follows:
            return
        found = self._device.inputs_from("mark_units", "clock_edge_ticks")
        edges = (found["clock_edge"] - found["zero_edge"]) % COUNT
        if self._edges:
            edges = self._edges[-1] + (edges - self._edges[-1]) % COUNT
            if edges == self._edges[-1]:  # the clock rests
                return
        ticks = UNIT_TICKS * found["started_units"] + found["clock_edge_ticks"]
        self._edges.append(edges)
        self._seconds.append(self._instant_s(ticks))

    def of_pixels(self, pixels: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        """Return when the edges that end pixels came, in the world's seconds; 0 is line zero."""
        edges = pixels * self._edges_px
        if not self._edges:
            return self._begun_s + edges / self._hz
        known, seconds = self._within(int(edges.max(initial=0)))
        if len(known) == 1:
            return seconds[0] + (edges - known[0]) / self._hz
        first = (seconds[1] - seconds[0]) / (known[1] - known[0])
        last = (seconds[-1] - seconds[-2]) / (known[-1] - known[-2])
        found = np.interp(edges, known, seconds)
        found = np.where(edges < known[0], seconds[0] + (edges - known[0]) * first, found)
        return np.where(edges > known[-1], seconds[-1] + (edges - known[-1]) * last, found)

    def _within(self, last: int) -> tuple[Sequence[int], Sequence[float]]:
        """Return the looks during a line: after its end a gated clock rests, and goes on later."""
        count = max(1, sum(edge <= last for edge in self._edges))
        return self._edges[:count], self._seconds[:count]

    def _marked(self) -> _Mark | None:
        """Make a mark; None of a board that knows none."""
        device = self._device
        if not device.has("tokens"):
            return None
        baud = 100 * device.setting("baud_100")
        heard_s = clock_marks.broadcast(device, self._world) + _MARK_BITS / baud
        return _Mark(heard_s, UNIT_TICKS * device.input("mark_units"))

    def _instant_s(self, ticks: int) -> float:
        """Return an instant by the board's coarse clock as one by the host's.

        The board's clock wraps after minutes: of the instants that `ticks` can mean, take the one
        nearest to now.
        """
        now_s = self._world.now_s()
        if self._mark is None:
            return now_s
        since_s = ((ticks - self._mark.ticks) % TICKS) / self._tick_hz
        wrap_s = TICKS / self._tick_hz
        return (
            self._mark.heard_s
            + since_s
            + wrap_s * round((now_s - self._mark.heard_s - since_s) / wrap_s)
        )
