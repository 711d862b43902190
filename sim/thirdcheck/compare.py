# SPDX-License-Identifier: MIT
"""Two simulations of one run: the same periods of STEP, the same outputs, the same replies?"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise, zip_longest

# Between the first cycles of two bytes of one reply: 1,496, and some that handlers keep them.
REPLY_GAP_CYCLES = 4000
# Slave address and function: equal in every reply. What follows may be a reading of the moment.
HEAD_BYTES = 2


@dataclass
class Run:
    """What a simulation saw: cycles of rises, changes of other outputs, (cycle, byte) sent."""

    rises: list[int]
    changes: list[str]
    sent: list[tuple[int, int]]


def periods(rises: list[int]) -> list[int]:
    """Return the cycles from each rise to the next."""
    return [after - before for before, after in pairwise(rises)]


def replies(sent: Iterable[tuple[int, int]]) -> list[bytes]:
    """Return the bytes of each reply."""
    found: list[bytearray] = []
    last = None
    for cycle, byte in sent:
        if last is None or cycle - last > REPLY_GAP_CYCLES:
            found.append(bytearray())
        found[-1].append(byte)
        last = cycle
    return [bytes(reply) for reply in found]


def compare_periods(want: list[int], got: list[int], min_steps: int) -> list[str]:
    """Return what is wrong with the rises; a period may not be one cycle longer or shorter."""
    problems = []
    if len(want) < min_steps:
        problems.append(f"the recorded run has {len(want)} steps, not {min_steps} or more")
    if len(got) != len(want):
        problems.append(f"{len(got)} steps instead of {len(want)}")
    both = list(zip(periods(want), periods(got), strict=False))
    wrong = [at for at, (expected, found) in enumerate(both) if expected != found]
    if wrong:
        expected, found = both[wrong[0]]
        problems.append(
            f"{len(wrong)} of {len(both)} periods differ, first the one behind step "
            f"{wrong[0] + 1}: {found} cycles instead of {expected}"
        )
    return problems


def compare_replies(want: list[bytes], got: list[bytes]) -> list[str]:
    """Return what is wrong with the replies: number, lengths, heads."""
    pairs = zip_longest(want, got, fillvalue=b"")
    for number, (expected, found) in enumerate(pairs, start=1):
        if (len(expected), expected[:HEAD_BYTES]) != (len(found), found[:HEAD_BYTES]):
            return [f"reply {number}: {found.hex()} instead of {expected.hex()}"]
    return []


def compare(want: Run, got: Run, min_steps: int) -> tuple[list[str], str]:
    """Return the problems and a summary. Replies count that were over before the last step."""
    problems = compare_periods(want.rises, got.rises, min_steps)
    if want.changes != got.changes:
        problems.append(f"{', '.join(got.changes)} instead of {', '.join(want.changes)}")
    last = max(want.rises, default=0)
    expected = replies(item for item in want.sent if item[0] < last)[:-1]
    found = replies(got.sent)[: len(expected)]
    problems += compare_replies(expected, found)
    apart = [there - here for here, there in zip(want.rises, got.rises, strict=False)]
    same = sum(a == b for a, b in zip(b"".join(expected), b"".join(found), strict=False))
    summary = (
        f"{len(periods(got.rises))} periods at tolerance 0, edges "
        f"{max(map(abs, apart), default=0)} cycles apart at most, {len(got.changes)} changes of "
        f"DIR and ENABLE; {len(expected)} replies, {same} of their {sum(map(len, expected))} "
        "bytes the same"
    )
    return problems, summary
