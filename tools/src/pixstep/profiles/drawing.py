# SPDX-License-Identifier: MIT
"""What is to be drawn of a line; apart from the figure, because matplotlib is slow to load."""

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from pixstep.lines import units
from pixstep.lines.line import Line
from pixstep.profiles import kinematics


@dataclass(frozen=True)
class Drawing:
    """What to draw: limits in steps/px^order by order; `image_pixel` is 1-based, None: none."""

    line: Line
    title: str
    pixel_hz: Fraction | None = None
    limits: dict[int, int] = field(default_factory=dict)
    image_pixel: int | None = None
    scale: units.Scale | None = None  # of the motor, if a machine file gives it
    going_on: bool = False  # a part of a line: it does not come to rest

    @cached_property
    def motion(self) -> kinematics.Kinematics:
        """The arrays drawn."""
        return kinematics.of(self.line, going_on=self.going_on)

    @cached_property
    def figures(self) -> kinematics.Figures:
        """Peaks and lengths."""
        return kinematics.figures(self.line, going_on=self.going_on)

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
