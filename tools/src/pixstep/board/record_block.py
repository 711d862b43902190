# SPDX-License-Identifier: MIT
"""The block of an axis' newest records, read in one request or, on a shared bus, in two.

Between the two requests the board may make records, and those in the block move forward by as many
places. The second request therefore begins some records before the first one ends: by these the two
fit together, and what comes out is the block as it was at the first request.
"""

from collections.abc import Callable

from pixstep.board import registers as regs
from pixstep.board.state import Records, parse_records

_HEAD, _WIDTH = regs.RECORD_HEAD, regs.RECORD_REGISTERS
_NUMBER = 2  # place in the head
_TRIES = 3

# From a place of the block, so many words; whether another request follows at once.
Read = Callable[[int, int, bool], list[int]]
Row = list[int]


def read(read_words: Read, capacity: int, most_words: int) -> Records:
    """Return the records of a block, no request for more than `most_words`.

    Only if they do not fit together time and again, one request asks for the whole block.
    """
    found = read_short(read_words, capacity, most_words)
    return found or parse_records(read_words(0, _HEAD + capacity * _WIDTH, False))


def read_short(read_words: Read, capacity: int, most_words: int) -> Records | None:
    """Return the same; None if too many records are made between two requests."""
    size = _HEAD + capacity * _WIDTH
    first, second = (most_words - _HEAD) // _WIDTH, most_words // _WIDTH
    begin = capacity - second
    if size <= most_words or begin >= first:
        return parse_records(read_words(0, size, False))
    for _ in range(_TRIES):
        words = read_words(0, _HEAD + first * _WIDTH, True)
        if words[_NUMBER] <= first:
            return parse_records(words)
        before = _rows(words[_HEAD:])
        after = _rows(read_words(_HEAD + begin * _WIDTH, second * _WIDTH, False))
        made = _made_between(before[begin:], after)
        if made is not None:
            return parse_records([*words[:_HEAD], *_flat(before[: begin + made]), *_flat(after)])
    return None


def _made_between(before: list[Row], after: list[Row]) -> int | None:
    """Return by how many places records have moved between two requests; None for too many.

    `before` is what the first one has of that with which the second one begins.
    """
    for made in range(len(before)):
        if before[made:] == after[: len(before) - made]:
            return made
    return None


def _rows(words: list[int]) -> list[Row]:
    return [words[at : at + _WIDTH] for at in range(0, len(words), _WIDTH)]


def _flat(rows: list[Row]) -> list[int]:
    return [word for row in rows for word in row]
