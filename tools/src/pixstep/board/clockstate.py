# SPDX-License-Identifier: MIT
"""The pixel clock as a board has measured it: period, offset from its setting, jitter."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypedDict

from pixstep.board import registers as regs
from pixstep.board import settings
from pixstep.board.device import Board


class ClockData(TypedDict):
    """A clock as plain data."""

    period_ticks: float
    period_us: float
    offset_ppm: float
    mean_jitter_us: float
    missing_edges: int
    false_edges: int


@dataclass(frozen=True)
class ClockState:
    """Figures of a clock, in timer ticks of which there are `tick_hz` a second.

    `jitter_ticks` is the mean distance of its edges from where they were expected; missing and
    false edges are counted since the board's reset.
    """

    period_ticks: float
    nominal_ticks: float
    jitter_ticks: float
    missing: int
    false: int
    tick_hz: int

    @property
    def offset_ppm(self) -> float:
        """How much higher the clock's frequency is than the board's setting."""
        return 1e6 * (self.nominal_ticks / self.period_ticks - 1)

    @property
    def period_us(self) -> float:
        """Its period in microseconds."""
        return 1e6 * self.period_ticks / self.tick_hz

    @property
    def jitter_us(self) -> float:
        """Its jitter in microseconds."""
        return 1e6 * self.jitter_ticks / self.tick_hz

    @property
    def text(self) -> str:
        """All of it in words."""
        return (
            f"period {self.period_us:.3f} us ({self.offset_ppm:+.1f} ppm), jitter "
            f"{self.jitter_us:.2f} us, {self.missing} missing, {self.false} false"
        )

    def as_json(self) -> ClockData:
        """Return plain data."""
        return {
            "period_ticks": round(self.period_ticks, 4),
            "period_us": round(self.period_us, 5),
            "offset_ppm": round(self.offset_ppm, 3),
            "mean_jitter_us": round(self.jitter_us, 3),
            "missing_edges": self.missing,
            "false_edges": self.false,
        }


def read(board: Board, inputs: Mapping[str, int]) -> ClockState | None:
    """Return what a board has measured, by its input registers and its settings.

    None before it has seen enough edges, and of a board without the registers.
    """
    measured = inputs["status"] >> regs.STATUS_MEASURED & 1
    if not measured or not inputs.get("clock_period_ticks"):
        return None
    tick_hz = board.tick_hz()
    return ClockState(
        inputs["clock_period_ticks"] + inputs["clock_period_fraction"] / 0x10000,
        float(tick_hz / settings.clock_hz(board)),
        inputs["clock_jitter"] / 16,
        inputs["clock_missing"],
        inputs["clock_glitches"],
        tick_hz,
    )
