# SPDX-License-Identifier: MIT
"""A line that flies over the points of a scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pixstep.api.motions import MotionLine
from pixstep.api.shown import Facts
from pixstep.lazy import np, npt


@dataclass(frozen=True, repr=False)
class ScanLine(MotionLine):
    """A line with the points of a scan in it, between a run-up and a run-down."""

    scan_axis: str = ""
    """The axis of the scan that it is for."""
    unit: str = "steps"
    """Unit of the scan's positions: those of `start` and `end`, and of documents."""
    steps_per_unit: float = 1.0
    """The motor's steps for one unit, negative where the motor runs backwards."""
    start: float = 0.0
    """Where the load is at line zero, on a whole step: the run-up before the first point."""
    end: float = 0.0
    """Where the load is at the end of the line."""
    point_pixels: tuple[int, ...] = ()
    """Pixels of each point, in their order."""
    run_up: int = 0
    """Pixels before the first point."""

    @property
    def start_steps(self) -> int:
        """Where the load is at line zero, in steps: from position 0 it is `board.move` so far."""
        return round(self.start * abs(self.steps_per_unit))

    @property
    def points(self) -> int:
        """Points of the scan."""
        return len(self.point_pixels)

    def points_of(self, pixels: Sequence[int] | npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Return the point, from 1, that each pixel, from 1, belongs to; 0 outside of them."""
        first = self.run_up + np.cumsum((1, *self.point_pixels))  # pixels in which points begin
        found = np.searchsorted(first, np.asarray(pixels), side="right")
        return np.where(found > self.points, 0, found)

    def _facts(self) -> Facts:
        yield from super()._facts()
        yield "points", f"{self.points}, of axis {self.scan_axis}, from pixel {self.run_up + 1}"
        yield "from, to", f"{self.start:.6g} to {self.end:.6g} {self.unit}"
