# SPDX-License-Identifier: MIT
"""The nearest line of a smooth motor to a motion that is none.

The speeds of a smooth line at the pixel edges are even and each count is the mean of two of them.
Counts of measured or rounded positions seldom are: an odd step is never forgotten, the speed swings
around it to the end. So the speeds are chosen anew, each near to that of the motion at its edge,
and half of the distance that is missing so far is made up for in the next one.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise


def fit(positions: Sequence[Fraction]) -> list[int]:
    """Return counts of a smooth line that goes along positions at the pixel edges, rising from 0.

    It begins and ends at rest; its steps may differ from those asked for by a few.
    """
    speeds, place = [0], Fraction(0)
    for k in range(1, len(positions) - 1):
        missing = positions[k - 1] - place
        wanted = (positions[k + 1] - positions[k - 1]) / 2 + missing / 2
        speeds.append(max(0, 2 * round(wanted / 2)))
        place += Fraction(speeds[-2] + speeds[-1], 2)
    speeds.append(0)
    return [(before + after) // 2 for before, after in pairwise(speeds)]


def largest_error(counts: Sequence[int], positions: Sequence[Fraction]) -> tuple[Fraction, int]:
    """Return how far a line is from positions, the first 0, at the worst pixel edge, and which."""
    place, worst, at = 0, Fraction(0), 0
    for pixel, (count, wanted) in enumerate(zip(counts, positions[1:], strict=True), 1):
        place += count
        error = abs(wanted - place)
        if error > worst:
            worst, at = error, pixel
    return worst, at
