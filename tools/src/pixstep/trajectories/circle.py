# SPDX-License-Identifier: MIT
"""Circles: made as the recovered program made them, recognised in a table, and how round they are.

Counter-clockwise from angle 0, centre 0: axis 1 is A cos, axis 2 is A sin, cut off towards zero.
Before it hold records at rest; with a lead-in both axes come up to speed along the circle, so that
angle 0 is passed at full speed, and slow down after it in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypedDict

from pixstep.errors import RefusedError, UserError
from pixstep.lazy import np
from pixstep.lines.line_check import MAX_COUNT
from pixstep.trajectories import table
from pixstep.trajectories.table import AXES, MOST_RECORDS, TwoAxisTable

HOLDS = 1024
_MISSED = 1e-7  # counts by which floating point may miss a whole number
_OFF_CIRCLE = 2.0  # counts that a record may be off its circle


@dataclass(frozen=True)
class CircleRequest:
    """What circle to make: radius in counts, points of a revolution, revolutions."""

    radius: int
    points: int = 8192
    revolutions: int = 3
    holds: int = HOLDS
    lead_in: int = 0  # points in which the speed comes up, and as many in which it goes down


@dataclass(frozen=True)
class Circle:
    """The circle that a table holds: record `start` (from 0) is angle 0 at full speed."""

    radius: int
    points: int
    start: int
    revolutions: int

    @property
    def end(self) -> int:
        """The record in which the last revolution ends."""
        return self.start + self.points * self.revolutions


def make(request: CircleRequest) -> TwoAxisTable:
    """Return the table of a circle. Raises UserError for one that no table or no pixel holds."""
    _refuse(request)
    point, share = _path(request)
    angle = 2 * np.pi * point / request.points
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    speed = share * 2 * np.pi / request.points
    along = np.column_stack([-unit[:, 1], unit[:, 0]]) * speed[:, None]
    positions, velocities = (_cut(request.radius * item) for item in (unit, along))
    still = np.zeros((request.holds, AXES), dtype=np.int64)
    return table.made(
        np.vstack([still + positions[0], positions]), np.vstack([still, velocities]), "circle"
    )


def find(made: TwoAxisTable) -> Circle:
    """Return the circle of a table. Raises UserError if it holds none around 0."""
    place = made.positions.astype(np.float64)
    distance = np.hypot(*place.T)
    radius = int(np.max(np.abs(made.positions)))
    if radius == 0 or np.any(np.abs(distance - radius) > _OFF_CIRCLE):
        row = int(np.argmax(np.abs(distance - radius)))
        raise RefusedError(
            f"{made.name}: not a circle around 0: record {row + 1} is {distance[row]:.1f} counts "
            f"from it, the furthest are {radius}"
        )
    angle = np.unwrap(np.arctan2(place[:, 1], place[:, 0]))
    moving = np.diff(angle)
    moving = moving[moving != 0]
    step = float(np.median(moving)) if len(moving) else 0.0
    passed = np.flatnonzero(angle > step / 4)
    start = int(passed[0]) - 1 if len(passed) else 0
    revolutions = int((angle[-1] + step / 4) // (2 * np.pi))
    if step <= 0 or start < 0 or revolutions < 1:
        raise RefusedError(f"{made.name}: not a counter-clockwise revolution from angle 0 on")
    points = int(np.argmin(np.abs(angle - 2 * np.pi))) - start
    return Circle(radius, points, start, revolutions)


def _refuse(request: CircleRequest) -> None:
    records = request.points * request.revolutions + request.holds + 2 * request.lead_in + 1
    if records > MOST_RECORDS:
        raise UserError(f"a circle of {records} records: at most {MOST_RECORDS}")
    speed = request.radius * 2 * np.pi / request.points
    if speed >= MAX_COUNT:
        least = int(request.radius * 2 * np.pi / MAX_COUNT) + 1
        raise UserError(
            f"a radius of {request.radius} counts in {request.points} points moves {speed:.0f} "
            f"counts a point, a pixel holds at most {MAX_COUNT}: at least {least} points"
        )


def _path(request: CircleRequest) -> tuple[np.ndarray, np.ndarray]:
    """Return where each record is, in points from angle 0, and its share of the full speed."""
    whole = np.arange(request.points * request.revolutions + 1, dtype=np.float64)
    full = np.ones(len(whole))
    if not request.lead_in:
        return whole, full
    ramp = np.arange(request.lead_in, dtype=np.float64)
    rising = ramp**2 / (2 * request.lead_in) - request.lead_in / 2
    share = ramp / request.lead_in
    return (
        np.concatenate([rising, whole, whole[-1] - rising[::-1]]),
        np.concatenate([share, full, share[::-1]]),
    )


def _cut(values: np.ndarray) -> np.ndarray:
    """Cut off towards zero; a whole number that floating point has just missed stays whole."""
    near = np.round(values)
    return np.where(np.abs(values - near) < _MISSED, near, np.trunc(values)).astype(np.int64)


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
class TableTrace:
    """One run: arrays of (records, 2) in counts, the time of each record in seconds."""

    name: str  # original or compensated
    command: TwoAxisTable
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


def roundness_of(trace: TableTrace, circle: Circle) -> Roundness:
    """Return the roundness at the points of a trace."""
    errors = radius_errors(trace.load[circle.start : circle.end + 1], circle)
    angles = np.arange(len(errors)) * 2 * np.pi / circle.points
    passes = errors[:-1].reshape(circle.revolutions, circle.points)
    return Roundness(trace.name, circle, passes, angles, errors)
