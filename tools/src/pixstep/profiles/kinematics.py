# SPDX-License-Identifier: MIT
"""Speed, acceleration, jerk and position of a line as arrays, and what is to be drawn of them.

Positions on the axis are pixel periods after line zero. Inside a smooth pixel the acceleration is
constant, the speed linear and the position quadratic; inside a plain pixel the speed is constant.
Changes at a boundary (all jerks, the accelerations of a plain line) are figures of that boundary.
The figure itself is a module apart, because matplotlib is slow to load.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from pixstep.lazy import np
from pixstep.lines import exact, units
from pixstep.lines.line import Line


@dataclass(frozen=True)
class LineMagnitudes:
    """Magnitudes of a line: steps/px, steps/px2, steps/px3; lengths in pixels and steps."""

    pixels: int
    steps: int
    peak_speed: int
    peak_acceleration: int
    peak_jerk: int


@dataclass(frozen=True)
class LineKinematics:
    """A line cut into its pieces: pixels, and the backlash take-up where there is one.

    `edges_px` has one entry more than there are pieces; the other arrays have one a piece. Speeds
    are signed by the direction, accelerations too. `going_on` is for a part of a line: a plain one
    then holds its last speed behind the end instead of coming to rest.
    """

    line: Line
    edges_px: np.ndarray
    begin_speeds: np.ndarray
    end_speeds: np.ndarray
    steps: np.ndarray
    going_on: bool = False

    @cached_property
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners of the speed: pixel periods and steps/px, two a piece."""
        speeds = np.column_stack([self.begin_speeds, self.end_speeds]).ravel()
        return np.repeat(self.edges_px, 2)[1:-1], speeds

    @cached_property
    def accelerations(self) -> np.ndarray:
        """Acceleration inside each piece of a smooth line, steps/px2."""
        changes: np.ndarray = self.end_speeds - self.begin_speeds
        return changes

    @cached_property
    def speed_changes(self) -> np.ndarray:
        """Change of the speed at every edge of a plain line, from rest and to rest, steps/px2."""
        behind = self.begin_speeds[-1:] if self.going_on else [0]
        return np.diff(np.concatenate([[0], self.begin_speeds, behind]))

    @cached_property
    def jerks(self) -> np.ndarray:
        """Change of the acceleration at every edge, from rest and to rest, steps/px3."""
        if self.line.smooth:
            return np.diff(np.concatenate([[0], self.accelerations, [0]]))
        return np.diff(np.concatenate([[0], self.speed_changes]))

    @cached_property
    def positions(self) -> np.ndarray:
        """Steps made at every edge."""
        return np.concatenate([[0], np.cumsum(self.steps)])

    def curve(self, points: int = 16) -> tuple[np.ndarray, np.ndarray]:
        """Return times in pixel periods and positions in steps, `points` a piece and the start.

        The last point of each piece is its end, where the position is a whole number.
        """
        share = np.arange(1, points + 1) / points
        lengths = np.diff(self.edges_px)
        times = self.edges_px[:-1, None] + lengths[:, None] * share
        slope = self.end_speeds - self.begin_speeds
        area = self.begin_speeds[:, None] * share + slope[:, None] * share**2 / 2
        inside = self.positions[:-1, None] + area * lengths[:, None]
        inside[:, -1] = self.positions[1:]
        start = self.edges_px[:1]
        return np.concatenate([start, times.ravel()]), np.concatenate([[0.0], inside.ravel()])


def of(line: Line, *, going_on: bool = False) -> LineKinematics:
    """Return the kinematics of a line, backlash take-up included."""
    pieces = list(exact.pieces(line))
    edges = np.array([float(piece.begin) for piece in pieces] + [float(line.pixels)])
    edges[0] = 0.0  # the leading zero pixel is shortened by the shift
    signs = np.array([piece.direction for piece in pieces], dtype=np.int64)
    begin = np.array([piece.speed for piece in pieces], dtype=np.int64)
    accel = np.array([piece.accel for piece in pieces], dtype=np.int64)
    steps = np.array([piece.steps for piece in pieces], dtype=np.int64)
    ends = signs * (begin + accel)
    return LineKinematics(line, edges, signs * begin, ends, signs * steps, going_on)


def figures(line: Line, *, going_on: bool = False) -> LineMagnitudes:
    """Return the peaks and lengths of a line: what needs no arrays."""
    pieces = list(exact.pieces(line))
    begin = [piece.direction * piece.speed for piece in pieces]
    end = [piece.direction * (piece.speed + piece.accel) for piece in pieces]
    if line.smooth:
        accelerations = [after - before for before, after in zip(begin, end, strict=True)]
        jerks = _changes([0, *accelerations, 0])
    else:
        behind = begin[-1:] if going_on else [0]
        accelerations = _changes([0, *begin, *behind])
        jerks = _changes([0, *accelerations])
    return LineMagnitudes(
        line.pixels, line.total_steps, _peak(begin + end), _peak(accelerations), _peak(jerks)
    )


def _changes(values: list[int]) -> list[int]:
    return [after - before for before, after in pairwise(values)]


def _peak(values: list[int]) -> int:
    return max(map(abs, values), default=0)


@dataclass(frozen=True)
class LineDrawing:
    """What to draw: limits in steps/px^order by order; `image_pixel` is 1-based, None: none."""

    line: Line
    title: str
    pixel_hz: Fraction | None = None
    limits: dict[int, int] = field(default_factory=dict)
    image_pixel: int | None = None
    scale: units.Scale | None = None  # of the motor, if a machine file gives it
    going_on: bool = False  # a part of a line: it does not come to rest

    @cached_property
    def motion(self) -> LineKinematics:
        """The arrays drawn."""
        return of(self.line, going_on=self.going_on)

    @cached_property
    def figures(self) -> LineMagnitudes:
        """Peaks and lengths."""
        return figures(self.line, going_on=self.going_on)

    @property
    def subtitle(self) -> str:
        """The figures in a line."""
        from pixstep.plotting import number

        figures, hz = self.figures, self.pixel_hz
        time = f" = {float(figures.pixels / hz):.4g} s at {float(hz):.7g} Hz" if hz else ""
        peaks = (
            f"{number(figures.peak_speed)} steps/px, "
            f"{number(figures.peak_acceleration)} steps/px², {number(figures.peak_jerk)} steps/px³"
        )
        return (
            f"{self.line.decode}, {number(figures.pixels)} px{time}, "
            f"{number(figures.steps)} steps; peak speed, acceleration, jerk: {peaks}"
        )
