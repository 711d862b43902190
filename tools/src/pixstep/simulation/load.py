# SPDX-License-Identifier: MIT
"""Where the load was at every pixel edge of a simulated run, and where it should have been."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pixstep.lazy import lazy
from pixstep.lines.line import Line
from pixstep.reversals.compensate import strokes
from pixstep.simulation.plantlog import AxisPlant
from pixstep.simulation.summary import Load

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")


@dataclass(frozen=True)
class AxisLoad:
    """The load of one axis at the pixel edges 1..N, in steps from its start.

    `spans` are the transitions of a compensated line, as (first, last) 1-based pixels.
    """

    axis: int
    ideal_steps: np.ndarray
    load_steps: np.ndarray
    spans: tuple[tuple[int, int], ...]

    @property
    def errors(self) -> np.ndarray:
        """Load minus ideal at each pixel edge."""
        errors: np.ndarray = self.load_steps - self.ideal_steps
        return errors

    @property
    def outside(self) -> np.ndarray:
        """True for each pixel edge that lies in no transition."""
        away = np.ones(len(self.load_steps), dtype=bool)
        for first, last in self.spans:
            away[first - 1 : last] = False
        return away

    def summary(self) -> Load:
        """Return the largest errors and where they are, as plain data of summary.json."""
        worst, pixel = _worst(self.errors)
        outside, outside_pixel = _worst(np.where(self.outside, self.errors, 0))
        return {
            "max_load_error_steps": worst,
            "max_load_error_pixel": pixel,
            "max_load_error_outside_steps": outside,
            "max_load_error_outside_pixel": outside_pixel,
            "transitions": [list(span) for span in self.spans],
        }


def axis_load(
    axis: int, line: Line, ideal: tuple[int, ...] | None, plant: AxisPlant, edge_cycles: list[int]
) -> AxisLoad:
    """Return an axis' load at the cycles of its pixel edges.

    `ideal` are the counts that the load should follow, one a pixel; None: those of the line.
    """
    wanted = [line.direction * count for count in line.counts] if ideal is None else list(ideal)
    return AxisLoad(
        axis,
        np.cumsum(wanted),
        plant.load_at(np.array(edge_cycles, dtype=np.int64)),
        tuple(transition_spans(wanted, line.counts) if ideal is not None else ()),
    )


def transition_spans(ideal: list[int], made: tuple[int, ...]) -> list[tuple[int, int]]:
    """Return (first, last) 1-based pixels of each stroke's transition.

    It begins with the stroke and ends with the last pixel whose count is not the ideal one.
    """
    spans = []
    for stroke in strokes(ideal):
        changed = [k for k in range(stroke.start, stroke.end) if ideal[k] != made[k]]
        if changed:
            spans.append((stroke.start + 1, changed[-1] + 1))
    return spans


def _worst(errors: np.ndarray) -> tuple[int, int | None]:
    """Return the error of the largest magnitude and its 1-based pixel; (0, None) if all are 0."""
    if not np.any(errors):
        return 0, None
    index = int(np.argmax(np.abs(errors)))
    return int(errors[index]), index + 1
