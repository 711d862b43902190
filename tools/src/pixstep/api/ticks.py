# SPDX-License-Identifier: MIT
"""Times in ticks of a board's timer."""

import math
from dataclasses import dataclass

from pixstep.simulation.report import ticks_text


@dataclass(frozen=True)
class Ticks:
    """A time in ticks of the board's timer; `print` shows nanoseconds beside it."""

    ticks: float
    """Timer ticks."""
    tick_hz: int
    """Ticks a second."""

    @property
    def ns(self) -> float:
        """The time in nanoseconds."""
        return self.ticks / self.tick_hz * 1e9

    def __str__(self) -> str:
        if math.isnan(self.ticks):
            return "unknown"
        return f"{ticks_text(self.ticks)} ticks ({self.ns:.1f} ns)"
