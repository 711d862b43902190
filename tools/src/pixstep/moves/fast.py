# SPDX-License-Identifier: MIT
"""Fast move: exactly N steps in the fewest pixels that an acceleration profile allows.

With the profile's entries r1..rm, pixel k of K cannot be faster than r(min(k, K + 1 - k)): up
through the entries, held at the last one, down mirrored. K is the smallest number of pixels for
which these bounds add up to N or more. They seldom add up to N exactly, so the top is lowered,
like water that runs out of a hill upside down: every pixel above a level L gets L, and a few in
the middle L + 1.

    bound    |    .........          counts   |     .-----.        L + 1
             |  ..         ..                 |  .--       --.     L
             |..             ..               |..             ..
             +-----------------               +-----------------

No jump between neighbours is larger than the one of the profile that it lies within, the speed
rises and then falls, and of all moves as short as this one it has the lowest top speed.
"""

from dataclasses import dataclass
from fractions import Fraction

from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import decode
from pixstep.moves.accel import Acceleration

MAX_STEPS = 2**31 - 1  # the board's position is a signed 32-bit number
MAX_PIXELS = 5_000_000


@dataclass(frozen=True)
class FastMove:
    """A planned move: signed runs (steps in each pixel, pixels), their sum is `steps`."""

    runs: tuple[tuple[int, int], ...]
    steps: int

    @property
    def pixels(self) -> int:
        """Length, pixels."""
        return sum(repeat for _, repeat in self.runs)

    @property
    def top(self) -> int:
        """Highest speed, steps/pixel."""
        return max(abs(count) for count, _ in self.runs)

    @property
    def counts(self) -> tuple[int, ...]:
        """Signed steps in each pixel."""
        return tuple(decode(self.runs))

    def seconds(self, pixel_hz: Fraction) -> float:
        """Return how long the move takes."""
        return float(self.pixels / pixel_hz)

    def line(self, name: str = "move") -> Line:
        """Return the move as a line: plain, and started without the pixel clock."""
        return Line(self.counts, PLAIN, name=name, clocked=False)


def plan(profile: Acceleration, steps: int) -> FastMove:
    """Return the move of `steps` steps, signed.

    Raises UserError for 0 steps, more than MAX_STEPS, or a move longer than MAX_PIXELS.
    """
    if not 1 <= abs(steps) <= MAX_STEPS:
        raise UserError(f"a move of {steps} steps: 1 to {MAX_STEPS} in either direction")
    distance = abs(steps)
    pixels = fewest_pixels(profile, distance)
    if pixels > MAX_PIXELS:
        raise UserError(
            f"{distance} steps at no more than {profile.top} steps/pixel take {pixels} pixels, "
            f"more than {MAX_PIXELS}"
        )
    sign = 1 if steps > 0 else -1
    level, above = _level(profile, pixels, distance)
    runs = _runs(profile.counts, pixels, level, above)
    return FastMove(tuple((sign * count, repeat) for count, repeat in runs), steps)


def fewest_pixels(profile: Acceleration, distance: int) -> int:
    """Return the smallest number of pixels in which `distance` steps can be made."""
    reach = 0  # of k pixels: r1 + r1, + r2 + r2 ...; the middle one of an odd number counts once
    for index, count in enumerate(profile.counts):
        if reach + count >= distance:
            return 2 * index + 1
        reach += 2 * count
        if reach >= distance:
            return 2 * index + 2
    return 2 * len(profile.counts) + -(-(distance - reach) // profile.top)


def _level(profile: Acceleration, pixels: int, distance: int) -> tuple[int, int]:
    """Return the highest level whose clipped bounds sum to `distance` or less, and the rest."""

    def clipped_sum(level: int) -> int:
        ramp = _ramp(profile.counts, pixels, level)
        return 2 * sum(ramp) + level * (pixels - 2 * len(ramp))

    low, high = 1, profile.top
    while low < high:
        middle = (low + high + 1) // 2
        if clipped_sum(middle) <= distance:
            low = middle
        else:
            high = middle - 1
    return low, distance - clipped_sum(low)


def _ramp(counts: tuple[int, ...], pixels: int, level: int) -> list[int]:
    """Return the entries below `level` that one half of the move holds, the flat one less."""
    return [count for count in counts[: pixels // 2] if count < level]


def _runs(counts: tuple[int, ...], pixels: int, level: int, above: int) -> list[tuple[int, int]]:
    """Return ramp, level with `above` pixels of one step more in its middle, ramp mirrored."""
    rising = [(count, 1) for count in _ramp(counts, pixels, level)]
    flat = pixels - 2 * len(rising)
    before = (flat - above) // 2
    middle = [(level, before), (level + 1, above), (level, flat - above - before)]
    parts = [*rising, *(middle if above else [(level, flat)]), *reversed(rising)]
    return [(count, repeat) for count, repeat in parts if repeat]
