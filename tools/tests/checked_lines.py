# SPDX-License-Identifier: MIT
"""Random queue entries for the test that host and boards judge lines alike."""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from hypothesis import strategies as st

from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import queue_entries

MOST_ENTRIES = 28  # of a line: the Uno's queue holds 32
_TOPS = (3, 40, 400, 4000, 17_000)  # steps a pixel
_LARGE_PX = 65_535
_FAR = 60  # counts so far apart take two bytes each, of an entry's four
_LONGEST_QUEUE = max(board.queue_entries for board in boards.all_boards())


@dataclass(frozen=True)
class World:
    """The settings of a board that a line is judged by."""

    hz: Fraction
    driver_us: int
    max_acceleration: int
    start_stop_steps: int


WORLDS = st.builds(
    World,
    st.sampled_from([Fraction(30), Fraction(10013, 100), Fraction(500), Fraction(15_000)]),
    st.sampled_from([1, 20, 300]),
    st.sampled_from([0, 0, 40, 1000]),
    st.sampled_from([0, 0, 4, 100]),
)


@st.composite
def smooth_counts(draw, top):
    """Counts of a line from rest to rest."""
    half = top // 2
    speeds = draw(st.lists(st.integers(0, half), min_size=1, max_size=10))
    if draw(st.booleans()):
        speeds = sorted(speeds) + sorted(speeds, reverse=True)
    even = [0, *(2 * speed for speed in speeds), 0]
    return [(low + high) // 2 for low, high in pairwise(even)]


@st.composite
def plain_counts(draw, top):
    """Counts that turn and rest, some of them in runs."""
    small = st.sampled_from([0, 0, 1, -1, 2, -2])
    values = draw(st.lists(st.one_of(small, st.integers(-top, top)), min_size=1, max_size=12))
    repeats = st.sampled_from([1, 1, 1, 2, 7])
    return [value for value in values for _ in range(draw(repeats))]


@st.composite
def spoilt(draw, counts):
    """Counts of which some are changed a little, or doubled."""
    counts = list(counts)
    for _ in range(draw(st.sampled_from([0, 0, 0, 1, 2]))):
        place = draw(st.integers(0, len(counts) - 1))
        if draw(st.booleans()):
            counts[place] += draw(st.sampled_from([-2, -1, 1, 2, 100]))
        else:
            counts.insert(place, counts[place])
    return counts


@st.composite
def entries(draw):
    """The entries of a line: most are nearly right, a few are nonsense."""
    smooth = draw(st.booleans())
    made = smooth_counts if smooth else plain_counts
    counts = draw(spoilt(draw(made(draw(st.sampled_from(_TOPS))))))
    backlash = 0
    if draw(st.sampled_from([False, False, False, True])):
        counts = [0] * draw(st.sampled_from([1, 1, 1, 0])) + counts
        backlash = draw(st.sampled_from([1, 2, max(map(abs, counts)), 40_000]))
    clocked, negative = draw(st.booleans()), draw(st.booleans())
    line = Line(tuple(counts), SMOOTH if smooth else PLAIN, backlash, negative, clocked)
    divider = draw(st.sampled_from([None] * 8 + [1, 3, 3, 0, 1001]))
    found = queue_entries(line, divider)[:MOST_ENTRIES]
    if draw(st.integers(0, 7)) == 0:
        place = draw(st.integers(0, len(found) - 1))
        count, repeat = found[place]
        found[place] = draw(
            st.sampled_from([
                (count, 0), (count, _LARGE_PX), (count ^ 1, repeat), (-count, repeat),
                (count ^ 0x80, repeat), (3, 0), (2, 0), (0, repeat), (count, repeat + 1),
            ])
        )  # fmt: skip
    return [(_signed(count), repeat & 0xFFFF) for count, repeat in found]


def _signed(word):
    """Return a count as 16 bits hold it."""
    return (word + 0x8000 & 0xFFFF) - 0x8000


@st.composite
def pieces(draw, of):
    """Split entries into blocks."""
    blocks, left = [], list(of)
    while left:
        size = draw(st.integers(1, len(left)))
        blocks.append(left[:size])
        left = left[size:]
    return blocks


@st.composite
def long_lines(draw):
    """Entries of a plain line that is longer than any queue, and may be wrong behind that."""
    start = draw(st.integers(2 * _LONGEST_QUEUE + 2, 2 * _LONGEST_QUEUE + 40))
    calm = [(1 + _FAR * (index % 2), 1) for index in range(start)]
    tail = draw(
        st.lists(
            st.tuples(st.sampled_from([1, 2, 3, -1, -2, -40, 300, 20_000, 0]), st.integers(1, 3)),
            max_size=6,
        )
    )
    mark, parameter = queue_entries(Line((), PLAIN, clocked=False))[:2]
    return [mark, parameter, *calm, *tail, (2, 0)]
