# SPDX-License-Identifier: MIT
"""What a table does on a machine, point by point, and how round its circle comes out."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, TypedDict

from pixstep.lazy import lazy
from pixstep.trajectories.circle import Circle
from pixstep.trajectories.table import AXES, Table

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")


@dataclass(frozen=True)
class Unit:
    """The unit in which lengths are told: so many counts are 1 of it."""

    name: str = "counts"
    counts: Fraction = Fraction(1)

    def of(self, counts: float) -> float:
        """Return a length in this unit."""
        return counts / float(self.counts)

    def text(self, counts: float, *, sign: bool = False) -> str:
        """Return a length as people read it: six places, or whole counts and a tenth."""
        places = 1 if self.counts == 1 else 6
        return f"{self.of(counts):{'+' if sign else ''}.{places}f} {self.name}"


COUNTS = Unit()


@dataclass(frozen=True)
class Trace:
    """One run: arrays of (records, 2) in counts, the time of each record in seconds."""

    name: str  # original or compensated
    command: Table
    ideal: np.ndarray
    motor: np.ndarray
    load: np.ndarray
    point_s: float

    @property
    def times_s(self) -> np.ndarray:
        """The time of each record."""
        return np.arange(len(self.ideal)) * self.point_s

    @property
    def following_errors(self) -> np.ndarray:
        """Motor less command."""
        errors: np.ndarray = self.motor - self.command.positions
        return errors

    @property
    def load_errors(self) -> np.ndarray:
        """Load less the original table."""
        errors: np.ndarray = self.load - self.ideal
        return errors

    def columns(self, circle: Circle | None = None) -> dict[str, np.ndarray]:
        """Return the measurement record: everything by record, with names for a table."""
        found = {"record": np.arange(1, len(self.ideal) + 1), "time_s": self.times_s}
        for axis in range(AXES):
            found |= {
                f"ideal{axis + 1}": self.ideal[:, axis],
                f"p{axis + 1}": self.command.positions[:, axis],
                f"v{axis + 1}": self.command.velocities[:, axis],
                f"motor{axis + 1}": self.motor[:, axis],
                f"following_error{axis + 1}": self.following_errors[:, axis],
                f"load{axis + 1}": self.load[:, axis],
            }
        if circle:
            found["angle_deg"] = (found["record"] - 1 - circle.start) * 360 / circle.points
            found["radius_error"] = radius_errors(self.load, circle)
        return found


class RoundnessData(TypedDict):
    """How round a circle is, as plain data; lengths without a unit in their name are in `unit`."""

    max_radius_error_counts: float
    max_radius_error: float
    highest_radius_error: float
    lowest_radius_error: float
    at_degrees: float
    unit: str
    places: int
    passes: int
    passes_apart_counts: float
    later_passes_apart_counts: float


@dataclass(frozen=True)
class Roundness:
    """The radius errors of a run in counts: at the points of each pass, and wherever seen.

    `angles` (radians, from 0 of the first pass on) and `errors` are of every place seen: all step
    events of a simulated board, the points of a model.
    """

    name: str
    circle: Circle
    passes: np.ndarray  # (revolutions, points)
    angles: np.ndarray = field(repr=False)
    errors: np.ndarray = field(repr=False)

    @property
    def worst(self) -> float:
        """The largest error, with its sign."""
        return float(self.errors[int(np.argmax(np.abs(self.errors)))])

    @property
    def worst_angle_deg(self) -> float:
        """Where that is, within a revolution."""
        return float(np.degrees(self.angles[int(np.argmax(np.abs(self.errors)))])) % 360

    def spread(self, first: int = 0) -> float:
        """Return how far apart the passes are at most at the same point, from pass `first` on."""
        chosen = self.passes[first:]
        return float(np.max(np.ptp(chosen, axis=0))) if len(chosen) > 1 else 0.0

    def summary(self, unit: Unit) -> RoundnessData:
        """Return plain data."""
        return {
            "max_radius_error_counts": round(abs(self.worst), 3),
            "max_radius_error": round(unit.of(abs(self.worst)), 9),
            "highest_radius_error": round(unit.of(float(np.max(self.errors))), 9),
            "lowest_radius_error": round(unit.of(float(np.min(self.errors))), 9),
            "at_degrees": round(self.worst_angle_deg, 3),
            "unit": unit.name,
            "places": len(self.errors),
            "passes": len(self.passes),
            "passes_apart_counts": round(self.spread(), 3),
            "later_passes_apart_counts": round(self.spread(1), 3),
        }


def radius_errors(places: np.ndarray, circle: Circle) -> np.ndarray:
    """Return how far places are outside of a circle."""
    errors: np.ndarray = np.hypot(places[:, 0], places[:, 1]) - circle.radius
    return errors


def of_points(trace: Trace, circle: Circle) -> Roundness:
    """Return the roundness at the points of a trace."""
    errors = radius_errors(trace.load[circle.start : circle.end + 1], circle)
    angles = np.arange(len(errors)) * 2 * np.pi / circle.points
    passes = errors[:-1].reshape(circle.revolutions, circle.points)
    return Roundness(trace.name, circle, passes, angles, errors)
