# SPDX-License-Identifier: MIT
"""Circles as segments that are blended over their whole length."""

import math
from collections.abc import Iterator
from typing import NamedTuple

MOST_OFF_STEPS = 0.5  # that segments may leave a circle by, whatever the tolerance of corners
_NOISE = 1e-9  # of the radius: ends that are nearer than this are one place


class Arc(NamedTuple):
    """A part of a circle: centre, radii at both ends, first angle and signed angle to the end.

    The radius runs linearly over the angle from the one to the other. `off` is how far the arc
    leaves the circle that the program asks for.
    """

    centre: tuple[float, float]
    radius: float
    last_radius: float
    first: float
    angle: float
    end: tuple[float, float]
    off: float

    @property
    def length(self) -> float:
        """How long it is, but for the square of the small difference between the radii."""
        return (self.radius + self.last_radius) / 2 * abs(self.angle)

    def point(self, share: float, stretch: float = 1.0) -> tuple[float, float]:
        """Return the place at a share of the angle, the radius there multiplied by `stretch`."""
        radius = (self.radius + (self.last_radius - self.radius) * share) * stretch
        angle = self.first + self.angle * share
        return (
            self.centre[0] + radius * math.cos(angle),
            self.centre[1] + radius * math.sin(angle),
        )


class ArcRequest(NamedTuple):
    """What a line says of a circle: `way` is 1 counterclockwise, -1 clockwise.

    A program has its places in a few decimals, so that no circle leads exactly through both ends:
    `tolerance` is how far the path may leave a circle for that, in the program's unit `unit`.
    """

    begin: tuple[float, float]
    end: tuple[float, float]
    way: int
    values: dict[str, float]
    tolerance: float
    unit: str

    def solved(self) -> Arc:
        """Return the circle. Raises ValueError saying what is wrong with it."""
        if "R" in self.values and self.values.keys() & {"I", "J"}:
            raise ValueError("a circle has a radius R or a centre I, J, not both")
        centre = self._by_radius() if "R" in self.values else self._by_centre()
        first = math.atan2(self.begin[1] - centre[1], self.begin[0] - centre[0])
        last = math.atan2(self.end[1] - centre[1], self.end[0] - centre[0])
        radius, last_radius = math.dist(self.begin, centre), math.dist(self.end, centre)
        angle = (last - first) * self.way % math.tau
        if math.dist(self.begin, self.end) <= _NOISE * radius or angle == 0:
            angle = math.tau
        off = abs(last_radius - radius) / 2
        if "R" in self.values:
            off = abs(radius - abs(self.values["R"]))
        return Arc(centre, radius, last_radius, first, angle * self.way, self.end, off)

    def _by_centre(self) -> tuple[float, float]:
        if not self.values.keys() & {"I", "J"}:
            raise ValueError("a circle needs a radius R or a centre I, J (from where it begins)")
        centre = (
            self.begin[0] + self.values.get("I", 0.0),
            self.begin[1] + self.values.get("J", 0.0),
        )
        radius, other = math.dist(self.begin, centre), math.dist(self.end, centre)
        if radius == 0:
            raise ValueError("the radius of the circle is 0")
        self._require(
            abs(other - radius) / 2,
            radius,
            f"the circle begins at radius {radius:.9g} and ends at radius {other:.9g}",
        )
        return centre

    def _by_radius(self) -> tuple[float, float]:
        """Return the centre: of R above 0 for the shorter way, below 0 for the longer one."""
        radius, chord = self.values["R"], math.dist(self.begin, self.end)
        if chord == 0:
            raise ValueError("a whole circle needs a centre I, J")
        if abs(radius) < chord / 2:
            self._require(
                chord / 2 - abs(radius),
                chord,
                f"radius {radius:.9g} is too short: the ends are {chord:.9g} apart",
            )
        high = math.sqrt(max(0.0, radius**2 - chord**2 / 4)) * self.way
        side = high if radius > 0 else -high
        (x0, y0), (x1, y1) = self.begin, self.end
        return (
            (x0 + x1) / 2 - side * (y1 - y0) / chord,
            (y0 + y1) / 2 + side * (x1 - x0) / chord,
        )

    def _require(self, off: float, size: float, text: str) -> None:
        """Raise ValueError if a path has to leave a circle of some size by too much."""
        if off <= max(self.tolerance, _NOISE * size):
            return
        digit = 10.0 ** (math.floor(math.log10(off)) - 1)
        enough = math.ceil(off / digit) * digit
        raise ValueError(
            f"{text}, {off:.3g} {self.unit} off a circle, and {self.tolerance:.3g} {self.unit} "
            f"are allowed: --arc-tolerance {enough:.2g}{self.unit} takes it"
        )


def segments_of(arc: Arc, scale: float, most: float, at_least: float) -> int:
    """Return into how many segments an arc is divided, so that they leave it by `most` steps.

    `scale` is steps for its unit. They leave it at both ends. The first one has its second corner
    outside and begins on the circle: its line cuts off an arc of 3/4 of its angle, which is 9/32 of
    the radius times the square of half a segment high. A single one cuts off all of its angle.
    """
    bend = max(arc.radius, arc.last_radius) * scale * arc.angle**2
    if at_least <= 1 and bend <= 8 * most:
        return 1
    angle = abs(arc.angle)
    return math.ceil(max(at_least, math.sqrt(bend * 9 / 128 / most), angle / _WIDEST, 2))


def arc_points(arc: Arc, segments: int) -> Iterator[tuple[float, float]]:
    """Yield the corners of the segments, the last of them the circle's end.

    Segments that are blended over their whole length make parabolas, which pass a corner at an
    eighth of its bend. Corners that lie 1/cos(half a segment) outside put the parabolas on the
    circle, but for the fourth power of the angle.
    """
    stretch = 1 / math.cos(arc.angle / segments / 2)
    for number in range(1, segments):
        yield arc.point(number / segments, stretch)
    yield arc.end


_WIDEST = math.radians(15)
