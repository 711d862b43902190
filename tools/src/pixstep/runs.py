# SPDX-License-Identifier: MIT
"""Lines travel as runs: (count, repeat) is `repeat` pixels of `count` steps each."""

from collections.abc import Iterable
from itertools import groupby

from pixstep.errors import UserError
from pixstep.line import Line

MAX_REPEAT = 0xFFFF
COUNT_RANGE = (-32_768, 32_767)

# The mark words of a queue: an entry whose repeat is 0.
MARK_START = 1
MARK_END = 2
MARK_SMOOTH = 1 << 4
MARK_WAIT_FOR_EDGE = 1 << 5
MARK_NEGATIVE = 1 << 6


def encode(counts: Iterable[int]) -> list[tuple[int, int]]:
    """Return the shortest list of runs; a repeat above 65535 is split."""
    runs = []
    for count, group in groupby(counts):
        if not COUNT_RANGE[0] <= count <= COUNT_RANGE[1]:
            raise UserError(f"count {count} does not fit a 16-bit run")
        left = sum(1 for _ in group)
        while left:
            repeat = min(left, MAX_REPEAT)
            runs.append((count, repeat))
            left -= repeat
    return runs


def decode(runs: Iterable[tuple[int, int]]) -> list[int]:
    """Return the counts that `runs` stand for, one per pixel."""
    return [count for count, repeat in runs for _ in range(repeat)]


def queue_entries(line: Line) -> list[tuple[int, int]]:
    """Return the queue entries of a line: start mark, its parameters, runs, end mark.

    The parameter entry is (backlash steps, line speed); the speed is 0 when there is no backlash.
    """
    mark = MARK_START | MARK_WAIT_FOR_EDGE
    if line.smooth:
        mark |= MARK_SMOOTH
    if line.negative:
        mark |= MARK_NEGATIVE
    speed = line.line_speed if line.backlash else 0
    return [(mark, 0), (line.backlash, speed), *encode(line.counts), (MARK_END, 0)]
