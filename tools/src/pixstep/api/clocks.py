# SPDX-License-Identifier: MIT
"""The pixel clock of a run: how a simulated one strays, and how lines kept to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Self

from pixstep import arguments
from pixstep.api.shown import Facts, Shown, Ticks, count, frame
from pixstep.errors import UserError
from pixstep.lazy import np, npt
from pixstep.simulation.pixel_clock import (
    MOST_JITTER_US,
    MOST_PPM,
    MOST_REST_MS,
    ClockFlaws,
)
from pixstep.simulation.small_pickle import SmallPickle

if TYPE_CHECKING:
    from pixstep.simulation.clock_judge import ClockKeeping
    from pixstep.simulation.job import LineExperiment

_RANGES = {
    "ppm": (-MOST_PPM, MOST_PPM),
    "jitter_us": (0, MOST_JITTER_US),
    "wander_ppm": (0, MOST_PPM),
    "step_ppm": (-MOST_PPM, MOST_PPM),
    "gate_rest_ms": (0, MOST_REST_MS),
}
_COUNTS = ("step_edge", "drop", "double", "gate_edges")


@dataclass(frozen=True)
class PixelClock:
    """A simulated pixel clock and what is wrong with it; by default nothing."""

    ppm: float = 0.0
    """Its frequency is so much higher than nominal."""
    jitter_us: float = 0.0
    """Standard deviation of each edge's own displacement."""
    wander_ppm: float = 0.0
    """The frequency swings so far to either side, once in 1,000 edges."""
    step_ppm: float = 0.0
    """The frequency is so much higher from edge `step_edge` on."""
    step_edge: int = 0
    """Where it steps: an edge from 1 on, counted from the start of the simulation."""
    drop: int = 0
    """One edge of so many is missing, of 2 at least; 0 is none."""
    double: int = 0
    """One edge of so many is followed by a false one; 0 is none."""
    gate_edges: int = 0
    """After so many edges the clock rests, and so on; 0 is no gate."""
    gate_rest_ms: float = 0.0
    """How long it rests, besides the period."""

    def __post_init__(self) -> None:
        """Raise UserError for a value that no simulated clock can have."""
        for name, (low, high) in _RANGES.items():
            value = arguments.finite(f"PixelClock: {name}", getattr(self, name), low, high)
            object.__setattr__(self, name, value)
        for name in _COUNTS:
            count = arguments.whole(f"PixelClock: {name}", getattr(self, name))
            object.__setattr__(self, name, count)
        if self.drop == 1:
            self._refuse("drop", "2 or more, or 0")
        if self.step_ppm and not self.step_edge:
            self._refuse("step_edge", "1 or more, as there is a step_ppm")

    def _refuse(self, name: str, expected: str) -> None:
        raise UserError(f"PixelClock: {name} {getattr(self, name)!r}: expected {expected}")

    @property
    def flaws(self) -> ClockFlaws:
        """All but the error of its frequency, as the simulator takes it."""
        return ClockFlaws(
            self.jitter_us,
            self.wander_ppm,
            self.step_ppm,
            self.step_edge,
            self.drop,
            self.double,
            self.gate_edges,
            self.gate_rest_ms,
        )


@dataclass(frozen=True, repr=False)
class ClockFigures(Shown):
    """What the pixel clock of a run did, and what the board measured of it.

    The board's figures are None if it had seen too few edges to measure.
    """

    clock_hz: Fraction
    """Nominal frequency of its edges in Hz."""
    divider: int
    """Edges of a pixel."""
    sync: str
    """What lines were to it: `"free"`, `"start"` or `"lock"`."""
    true_edges: int
    """Edges that it should have made in the whole simulation."""
    missing_edges: int
    """Those of them that it did not make."""
    false_edges: int
    """Edges that it made besides."""
    board_missing: int | None
    """Missing edges that the board counted from arming on."""
    board_glitches: int | None
    """False edges that the board counted, and dropped, from arming on."""
    board_period: Ticks | None
    """Its period as the board measured it."""
    board_offset_ppm: float | None
    """How much higher its frequency was, by that period, than nominal."""
    board_jitter: Ticks | None
    """Mean distance of its edges from where the board expected them."""

    def _headline(self) -> str:
        divided = f", {self.divider} edges a pixel" if self.divider > 1 else ""
        return f"{float(self.clock_hz):g} Hz{divided}, sync {self.sync}"

    def _facts(self) -> Facts:
        yield "edges", f"{self.true_edges:,}"
        yield "missing, by the board", f"{self.missing_edges}, {self.board_missing}"
        yield "false, by the board", f"{self.false_edges}, {self.board_glitches}"
        yield "period by the board", self.board_period
        yield "jitter by the board", self.board_jitter

    @classmethod
    def of(cls, job: LineExperiment, told: Mapping[str, Any]) -> Self:
        """Return the figures of a run's summary."""
        period, jitter = told.get("board_period_ticks"), told.get("board_jitter_ticks")
        return cls(
            clock_hz=job.pixel_hz,
            divider=job.divider,
            sync=job.sync,
            true_edges=told["true_edges"],
            missing_edges=told["missing_edges"],
            false_edges=told["false_edges"],
            board_missing=told.get("board_missing"),
            board_glitches=told.get("board_glitches"),
            board_period=Ticks(period, job.tick_hz) if period else None,
            board_offset_ppm=told.get("board_offset_ppm"),
            board_jitter=Ticks(jitter, job.tick_hz) if period and jitter is not None else None,
        )


@dataclass(frozen=True, eq=False, repr=False)
class ClockErrors(SmallPickle, Shown):
    """How an axis kept to the true edges of the pixel clock, locked to it or not."""

    pixels: npt.NDArray[np.int64]
    """The pixels, from 1, whose last step lies on their end: only these can be compared."""
    errors_ticks: npt.NDArray[np.float64]
    """How much later than the clock's true edge each of them ended, in ticks."""
    max_error: Ticks
    """The largest of these errors, without its sign."""
    rms_error: Ticks
    """Their root mean square."""
    drift: Ticks
    """How much more the last pixel was late than the first."""
    drift_steps: float
    """The same in steps at the line's speed."""
    max_position_error_steps: int
    """Largest difference, at a true edge of the clock, of steps made from steps due."""
    ripple: Ticks
    """Largest change of length from one pixel to the next."""

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas: a row a pixel."""
        return frame({"pixel": self.pixels, "error_ticks": self.errors_ticks})

    def _headline(self) -> str:
        pixels = count(len(self.pixels), "pixel")
        return f"{pixels} compared: rms {self.rms_error}, at most {self.max_error}"

    def _facts(self) -> Facts:
        yield "drift", self.drift
        yield "drift, steps", f"{self.drift_steps:.3g}"
        yield "largest position error, steps", self.max_position_error_steps
        yield "ripple", self.ripple

    @classmethod
    def of(cls, kept: ClockKeeping, tick_hz: int) -> Self:
        """Return what the judge has found of an axis."""

        def ticks(value: float) -> Ticks:
            return Ticks(value, tick_hz)

        return cls(
            pixels=kept.pixels,
            errors_ticks=kept.errors_ticks,
            max_error=ticks(float(np.max(np.abs(kept.errors_ticks)))),
            rms_error=ticks(kept.rms_ticks),
            drift=ticks(kept.drift_ticks),
            drift_steps=kept.drift_steps,
            max_position_error_steps=kept.max_off_steps,
            ripple=ticks(kept.ripple_ticks),
        )
