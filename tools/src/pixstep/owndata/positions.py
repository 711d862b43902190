# SPDX-License-Identifier: MIT
"""A line from positions at the pixel edges: whole steps, one direction of a smooth line, a fit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from pixstep.errors import UserError
from pixstep.lines.line import SMOOTH, Line
from pixstep.lines.line_check import MAX_COUNT
from pixstep.owndata.fitting import fit, largest_error

Refuse = Callable[[int, str], UserError]  # takes a pixel, from 0, and what is wrong with it


@dataclass(frozen=True)
class Made:
    """A line, and how far it is from its positions at the worst pixel edge."""

    line: Line
    fitted: bool
    largest_error_steps: Fraction
    worst_pixel: int


def line_of(
    positions: Sequence[Fraction], decode: str, name: str, refuse: Refuse, *, fitted: bool
) -> Made:
    """Return the line through positions in steps, from 0: rounded, so that errors never add up.

    `fitted` lets a smooth motor make the nearest line that it can; a plain one makes any counts.
    """
    counts = counts_of(positions, refuse)
    if decode != SMOOTH:
        return _made(Line(tuple(counts), decode, name=name), positions, fitted=False)
    negative = _is_negative(counts, refuse)
    if fitted:
        sign = -1 if negative else 1
        counts = fit([sign * place for place in positions])
    else:
        counts = [abs(count) for count in counts]
    line = Line(tuple(counts), SMOOTH, negative=negative, name=name)
    return _made(line, positions, fitted=fitted)


def counts_of(positions: Sequence[Fraction], refuse: Refuse) -> list[int]:
    """Return the steps of each pixel by rounded positions. Raises UserError for too many."""
    counts = [after - before for before, after in pairwise(map(round, positions))]
    for pixel, count in enumerate(counts):
        if abs(count) > MAX_COUNT:
            raise refuse(pixel, f"{count} steps in a pixel, the most are {MAX_COUNT}")
    return counts


def _made(line: Line, positions: Sequence[Fraction], *, fitted: bool) -> Made:
    counts = [line.direction * count for count in line.counts]
    return Made(line, fitted, *largest_error(counts, positions))


def _is_negative(counts: Sequence[int], refuse: Refuse) -> bool:
    """Return whether a smooth line runs backwards; raise UserError if it goes both ways."""
    signs = {1 if count > 0 else -1 for count in counts if count}
    if len(signs) > 1:
        first = next(1 if count > 0 else -1 for count in counts if count)
        pixel = next(k for k, count in enumerate(counts) if count * first < 0)
        raise refuse(pixel, "a smooth line has one direction: this pixel turns back")
    return signs == {-1}
