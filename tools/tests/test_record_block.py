# SPDX-License-Identifier: MIT
"""The block of records in two requests: what comes out was there, whole and in its order."""

import random

import pytest

from pixstep.board import registers as regs
from pixstep.board import state
from pixstep.board.state import parse_records

CAPACITY, SHORT = 20, 76


class Ring:
    """The records of a board; `more` are made between two requests."""

    def __init__(self, made, more, start=0, every=1):
        self.made, self.more, self.start, self.every = made, more, start, every
        self.sizes = []

    def words(self):
        kept = range(max(1, self.made - CAPACITY + 1), self.made + 1)
        pixels = [self.start + self.every * number for number in kept]
        newest = pixels[-1] if pixels else 0
        words = [newest >> 16, newest & 0xFFFF, len(kept), self.made & 0xFFFF]
        for pixel in pixels:
            words += [pixel & 0xFFFF, 0, 3 * pixel & 0x7FFF, 0, 3 * pixel & 0x7FFF, pixel % 7]
        return words + [0] * (4 + 6 * CAPACITY - len(words))

    def read(self, first, count, more_follows):
        if self.sizes:
            self.made += self.more
        assert more_follows == (first == 0 and count <= SHORT)
        self.sizes.append(count)
        return self.words()[first : first + count]


@pytest.mark.parametrize("made", [0, 1, 11, 12, 13, 19, 20, 21, 500])
@pytest.mark.parametrize("more", range(4))
def test_two_requests_give_the_block_of_the_first(made, more):
    ring = Ring(made, more)
    wanted = parse_records(ring.words())
    assert state.read_records(ring.read, CAPACITY, SHORT) == wanted
    assert max(ring.sizes) <= SHORT and len(ring.sizes) == (1 if made <= 12 else 2)


@pytest.mark.parametrize("more", [4, 7, 20, 1000])
def test_what_does_not_fit_together_is_asked_for_as_a_whole(more):
    ring = Ring(60, more, start=65_500)
    found = state.read_records(ring.read, CAPACITY, SHORT)
    assert found == parse_records(ring.words()) and len(ring.sizes) == 7
    ring.sizes.clear()
    assert state.read_records_short(ring.read, CAPACITY, SHORT) is None
    assert max(ring.sizes) <= SHORT


def test_every_record_comes_once_however_fast_they_are_made():
    """As a log takes them: what is missing is counted, nothing comes twice or out of its order."""
    rng = random.Random(3)
    ring = Ring(1, 0, start=65_000, every=3)
    last, seen, missed = 0, 0, 0
    for _ in range(2000):
        ring.sizes, ring.more = [], rng.choice((0, 0, 1, 2, 3, 5, 30))
        block = state.read_records(ring.read, CAPACITY, SHORT)
        new = [record.pixel for record in block.records if record.pixel > last]
        assert new == sorted(new) and all((pixel - 65_000) % 3 == 0 for pixel in new)
        seen += len(new)
        missed += (block.made - seen - missed) % 0x10000
        last = new[-1] if new else last
        assert last == 65_000 + 3 * (seen + missed)
        ring.made += rng.randrange(12)
    assert seen > 5000


def test_records_of_the_line_before_do_not_count():
    """From arming to the first pixel's edge the block has the old records and pixel 0."""

    def read(first, count, _more, sizes=[]):  # noqa: B006 (it counts)
        sizes.append(count)
        rows = [[100 + n + 50 * len(sizes), 0, 0, 0, 0, 0] for n in range(CAPACITY)]
        words = [0, 0, CAPACITY, 0, *(word for row in rows for word in row)]
        return words[first : first + count]

    assert state.read_records(read, CAPACITY, SHORT).records == []


@pytest.mark.parametrize("most", [124, 125])
def test_one_request_where_it_may_be_long(most):
    ring = Ring(500, 9)
    assert state.read_records(ring.read, CAPACITY, most).made == 500
    assert ring.sizes == [regs.RECORD_HEAD + CAPACITY * regs.RECORD_REGISTERS]
