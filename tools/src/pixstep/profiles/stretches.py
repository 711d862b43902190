# SPDX-License-Identifier: MIT
"""Counts cut into stretches of constant speed and the ramps between them."""

from dataclasses import dataclass
from itertools import groupby

LINE = "line"
START = "start"


@dataclass
class Stretch:
    """Pixels of constant speed; or the `free` end of an accelerating part, at any speed."""

    speed: int
    pixel: int
    counts: tuple[int, ...] = ()
    first: int = 0  # pixels that the ramp before takes
    last: int = 0  # pixels that the ramp behind takes
    free: bool = False

    @property
    def kept(self) -> tuple[int, ...]:
        """The pixels left."""
        return self.counts[self.first : len(self.counts) - self.last]

    @property
    def rests(self) -> bool:
        """True for pixels at rest."""
        return self.speed == 0 and not self.free


def split(counts: tuple[int, ...], part: str) -> tuple[list[Stretch], list[list[int]]]:
    """Return the stretches, rest at both ends included, and the counts between them."""
    stretches = [Stretch(0, 1)]
    between: list[list[int]] = [[]]
    pixel = 1
    for count, group in groupby(counts):
        length = len(list(group))
        if count == 0 and pixel == 1:
            stretches[0].counts = (0,) * length
        elif count == 0 or length > 1:
            speed = 2 if count == 1 else count // 2 * 2
            stretches.append(Stretch(speed, pixel, (count,) * length))
            between.append([])
        else:
            between[-1].append(count)
        pixel += length
    if between[-1] or (part == LINE and stretches[-1].speed):
        stretches.append(Stretch(0, pixel, free=part != LINE))
    return stretches, between


def consumed_pair(stretches: list[Stretch]) -> int | None:
    """Return the index of two equal counts that the ramps took and that need not be a stretch.

    Between moving stretches two equal counts are more likely an accident of a ramp.
    """
    for index in range(1, len(stretches) - 1):
        pair = stretches[index]
        beside_rest = stretches[index - 1].rests or stretches[index + 1].rests
        if len(pair.counts) == 2 and not pair.kept and not beside_rest:
            return index
    return None
