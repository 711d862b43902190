# SPDX-License-Identifier: MIT
"""A line as the controller sees it: one count per pixel and how to decode it."""

from dataclasses import dataclass, field
from functools import cached_property

SMOOTH = "smooth"
PLAIN = "plain"


@dataclass(frozen=True)
class Line:
    """Counts per pixel (steps), the decode rule and the backlash to take up (steps).

    A smooth line holds unsigned counts and may run in the negative direction as a whole; a plain
    line's counts are signed. A line that is not `clocked` starts as soon as it is armed, without
    waiting for the pixel clock. Nothing is checked here: see `line_check`.
    """

    counts: tuple[int, ...]
    decode: str = SMOOTH
    backlash: int = 0
    negative: bool = False
    clocked: bool = True
    name: str = field(default="line", compare=False)

    @property
    def smooth(self) -> bool:
        """True if the acceleration is constant inside each pixel."""
        return self.decode == SMOOTH

    @property
    def pixels(self) -> int:
        """Number of pixels, the zero pixels included."""
        return len(self.counts)

    @cached_property
    def speeds(self) -> tuple[int, ...]:
        """Boundary speeds v_0..v_N of a smooth line in steps/pixel: v_k = 2 n_k - v_(k-1)."""
        speeds = [0]
        for count in self.counts:
            speeds.append(2 * count - speeds[-1])
        return tuple(speeds)

    @cached_property
    def line_speed(self) -> int:
        """V: the highest boundary speed of a smooth line, the largest count of a plain one."""
        if self.smooth:
            return max(self.speeds)
        return max((abs(count) for count in self.counts), default=0)

    @cached_property
    def shifted_pixels(self) -> int:
        """Pixels before the backlash insertion, the leading zero included; 0 without backlash.

        They are the pixels up to the first boundary whose speed is the line speed; each runs
        backlash/line_speed of a pixel early.
        """
        if not (self.smooth and self.backlash > 0 and self.line_speed > 0):
            return 0
        return self.speeds.index(self.line_speed)

    @cached_property
    def total_steps(self) -> int:
        """Step pulses made over the whole line, the backlash included."""
        return sum(abs(count) for count in self.counts) + self.backlash

    @property
    def turns(self) -> bool:
        """True if the counts go both ways, as those of a plain line may."""
        return min(self.counts) < 0 < max(self.counts)

    @property
    def direction(self) -> int:
        """+1, or -1 for a smooth line that runs in the negative direction."""
        return -1 if self.negative else 1
