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
_NUMBER, _MADE = 2, 3  # places of the head

Read = Callable[[int, int], list[int]]  # from a place of the block, so many words
Row = list[int]


def read(read_words: Read, capacity: int, most_words: int) -> Records:
    """Return the records of a block, no request for more than `most_words`.

    If they do not fit together, because too many were made meanwhile, the block is returned as it
    was some records earlier.
    """
    size = _HEAD + capacity * _WIDTH
    first, second = (most_words - _HEAD) // _WIDTH, most_words // _WIDTH
    begin = capacity - second
    if size <= most_words or begin >= first:
        return parse_records(read_words(0, size))
    words = read_words(0, _HEAD + first * _WIDTH)
    head, before = words[:_HEAD], _rows(words[_HEAD:])
    if head[_NUMBER] <= first:
        return parse_records(words)
    after = _rows(read_words(_HEAD + begin * _WIDTH, second * _WIDTH))
    made = _made_between(before[begin:], after)
    if made is None:
        return parse_records([*_earlier(head, before), *_flat(before)])
    return parse_records([*head, *_flat(before[: begin + made]), *_flat(after)])


def _made_between(before: list[Row], after: list[Row]) -> int | None:
    """Return by how many places records have moved between two requests; None for too many.

    `before` is what the first one has of that with which the second one begins.
    """
    for made in range(len(before)):
        if before[made:] == after[: len(before) - made]:
            return made
    return None


def _earlier(head: Row, rows: list[Row]) -> Row:
    """Return the head of the block when the last of some of its records was the newest one."""
    newest = head[0] << 16 | head[1]
    newest -= (newest - rows[-1][0]) & 0xFFFF
    if newest <= 0:  # all of them are of the line before
        return [0, 0, 0, head[_MADE]]
    made = (head[_MADE] - (head[_NUMBER] - len(rows))) & 0xFFFF
    return [newest >> 16 & 0xFFFF, newest & 0xFFFF, len(rows), made]


def _rows(words: list[int]) -> list[Row]:
    return [words[at : at + _WIDTH] for at in range(0, len(words), _WIDTH)]


def _flat(rows: list[Row]) -> list[int]:
    return [word for row in rows for word in row]
