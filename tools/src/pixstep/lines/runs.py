# SPDX-License-Identifier: MIT
"""Lines travel as runs: (count, repeat) is `repeat` pixels of `count` steps each.

On the way an entry is packed into 1 to 4 bytes, as firmware/core/line/segment_pack.h has them: a
single pixel whose count is near that of the entry before takes one byte.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import groupby

from pixstep.errors import UserError
from pixstep.lines.line import Line

MAX_WORD = 0xFFFF
MAX_REPEAT = MAX_WORD
COUNT_RANGE = (-32_768, 32_767)

# The mark words of a queue: an entry whose repeat is 0.
MARK_START = 1
MARK_END = 2
MARK_DOWN = 3  # inside a seek line: the runs behind it slow down to rest
MARK_SMOOTH = 1 << 4
MARK_WAIT_FOR_EDGE = 1 << 5
MARK_NEGATIVE = 1 << 6
MARK_SEEK = 1 << 7
MARK_SEEK_OPEN = 1 << 8
MARK_DIVIDER = 1 << 9  # a third entry says how many clock edges a pixel of the line has
MARK_MORE = 1 << 10  # another line follows without a gap, on all axes whose lines say so or on none


@dataclass(frozen=True)
class Seek:
    """A line that ends early, by slowing down, when its axis's home switch closes or opens.

    `rising` are the signed counts of the acceleration; then `held` is made for `hold_px` pixels
    and the acceleration mirrored. The board may be anywhere in it when the switch comes: it slows
    down from the speed it has.

    plain   rising 4 12 20     held 20  falling 12 4
    smooth  rising 4 12 20     held 24  falling 20 12 4     boundary speeds 0 8 16 24 24 16 8 0
    """

    rising: tuple[int, ...]
    hold_px: int
    opens: bool = False  # seek the switch opening, else closing
    smooth: bool = False

    @property
    def held(self) -> int:
        """Signed count of the pixels between acceleration and deceleration: the speed reached."""
        if not self.smooth:
            return self.rising[-1]
        speed = 0
        for count in self.rising:
            speed = 2 * count - speed
        return speed

    @property
    def falling(self) -> tuple[int, ...]:
        """Signed counts of the deceleration; a plain line has made its last entry already."""
        return self.rising[::-1] if self.smooth else self.rising[-2::-1]

    @property
    def pixels(self) -> int:
        """Pixels of the whole line, if no switch comes."""
        return len(self.rising) + self.hold_px + len(self.falling)

    @property
    def steps(self) -> int:
        """Signed steps of the whole line, if no switch comes."""
        return sum(self.rising) + self.hold_px * self.held + sum(self.falling)


def encode(counts: Iterable[int]) -> list[tuple[int, int]]:
    """Return the shortest list of runs; a repeat above 65535 is split."""
    runs = []
    for count, group in groupby(counts):
        if not COUNT_RANGE[0] <= count <= COUNT_RANGE[1]:
            raise UserError(f"count {count} does not fit a 16-bit run")
        left = len([*group])
        while left:
            repeat = min(left, MAX_REPEAT)
            runs.append((count, repeat))
            left -= repeat
    return runs


def decode(runs: Iterable[tuple[int, int]]) -> list[int]:
    """Return the counts that `runs` stand for, one per pixel."""
    return [count for count, repeat in runs for _ in range(repeat)]


def head_entries(
    mark: int, parameter: tuple[int, int], divider: int | None
) -> list[tuple[int, int]]:
    """Return the entries in front of a line's runs, with its divider if it has one."""
    if divider is None:
        return [(mark, 0), parameter]
    return [(mark | MARK_DIVIDER, 0), parameter, (divider, 0)]


def queue_entries(
    line: Line, divider: int | None = None, *, more: bool = False
) -> list[tuple[int, int]]:
    """Return the queue entries of a line: start mark, its parameters, runs, end mark.

    The parameter entry is (backlash steps, line speed); the speed is 0 when there is no backlash.
    `divider` is how many clock edges a pixel has, for a board that takes it with the line. `more`
    says that another line follows without a gap.
    """
    mark = MARK_START | (MARK_MORE if more else 0)
    if line.clocked:
        mark |= MARK_WAIT_FOR_EDGE
    if line.smooth:
        mark |= MARK_SMOOTH
    if line.negative:
        mark |= MARK_NEGATIVE
    # What does not fit 16 bits is refused at its largest value too.
    backlash = min(line.backlash, MAX_WORD)
    speed = min(line.line_speed, MAX_WORD) if backlash else 0
    head = head_entries(mark, (backlash, speed), divider)
    return [*head, *encode(line.counts), (MARK_END, 0)]


def safe_entries(line: Line) -> list[tuple[int, int]]:
    """Return the queue entries of a line; counts that no entry can hold are refused as well."""
    low, high = COUNT_RANGE
    if all(low <= count <= high for count in line.counts):
        return queue_entries(line)
    kept = tuple(min(max(count, low), high) for count in line.counts)
    return queue_entries(replace(line, counts=kept))


def seek_entries(seek: Seek) -> list[tuple[int, int]]:
    """Return the queue entries of a seek line, with its mark where slowing down begins.

    The counts of a smooth line are unsigned, its mark has the direction.
    """
    mark = MARK_START | MARK_SEEK | (MARK_SEEK_OPEN if seek.opens else 0)
    sign = 1
    if seek.smooth:
        mark |= MARK_SMOOTH
        if seek.rising[0] < 0:
            mark |= MARK_NEGATIVE
            sign = -1
    up = encode(sign * count for count in seek.rising + (seek.held,) * seek.hold_px)
    down = encode(sign * count for count in seek.falling)
    return [(mark, 0), (0, 0), *up, (MARK_DOWN, 0), *down, (MARK_END, 0)]


MOST_BYTES = 4  # bytes of the longest entry
_NEAR = 56  # one byte: differences of -56..56, the byte of 0
_NEAR_LAST = 0x70
_SHORT_RUN, _SHORT_MOST = 0x6F, 7  # two bytes: repeat 2..7
_RUN = 0x77  # three bytes: repeat 0..255
_WIDE, _WIDE_ZERO = 0x400, 0x7C00  # two bytes: differences of -1024..1023
_FULL = 0x80
_FURTHEST = 0x4000  # 15 bits, signed: -16384..16383
_BYTE, _SHORT, _WORD = 0xFF, 0x80, 0xFFFF


def pack(entry: tuple[int, int], last: int | None = None) -> tuple[bytes, int]:
    """Return an entry's bytes, and the count that the next entry's difference goes from.

    `last` is that count of the entry before; without it the entry is in full, as the first ones of
    a line have to be. A pixel's count that 15 bits do not hold becomes the lowest that they do,
    which every board refuses as out of range too.
    """
    count, repeat = signed(entry[0], 15), entry[1]
    if last is not None:
        count = entry[0] if -_FURTHEST <= entry[0] < _FURTHEST else -_FURTHEST
        change = signed(count - last, 16)
        if repeat == 1 and -_NEAR <= change <= _NEAR:
            return bytes([change + _NEAR]), count
        if repeat == 1 and -_WIDE <= change < _WIDE:
            return (_WIDE_ZERO + change).to_bytes(2), count
        if 2 <= repeat <= _BYTE and -_SHORT <= change < _SHORT:
            return _packed_run(change & _BYTE, repeat), count
    return (count & _WORD | _FULL << 8).to_bytes(2) + repeat.to_bytes(2), count


def unpack(data: bytes, last: int = 0) -> list[tuple[int, int]]:
    """Return the entries of packed bytes; raises ValueError if they end inside one."""
    entries = []
    at = 0
    while at < len(data):
        first = data[at]
        more = data[at + 1 : at + entry_size(first)]
        if len(more) != entry_size(first) - 1:
            raise ValueError("the bytes end inside an entry")
        last, repeat = _entry(first, more, last)
        entries.append((last, repeat))
        at += entry_size(first)
    return entries


def entry_size(first: int) -> int:
    """Return how many bytes the entry with this first byte has."""
    if first <= _NEAR_LAST:
        return 1
    if first >= _FULL:
        return MOST_BYTES
    return 3 if first == _RUN else 2


def packed_entries(entries: Iterable[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Yield how many bytes each entry of a line takes, and its pixels; the first two in full."""
    last = None
    for index, entry in enumerate(entries):
        data, last = pack(entry, last if index >= 2 else None)
        yield len(data), entry[1] if index >= 2 else 0


def packed_size(entries: Iterable[tuple[int, int]]) -> int:
    """Return how many bytes the entries of a line take behind each other."""
    return sum(size for size, _ in packed_entries(entries))


def signed(value: int, bits: int) -> int:
    """Return the lowest bits of a number, the highest of them as its sign."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half


def _packed_run(change: int, repeat: int) -> bytes:
    if repeat <= _SHORT_MOST:
        return bytes([_SHORT_RUN + repeat, change])
    return bytes([_RUN, change, repeat])


def _entry(first: int, more: bytes, last: int) -> tuple[int, int]:
    """Return count and repeat of the entry with these bytes."""
    if first <= _NEAR_LAST:
        return signed(last + first - _NEAR, 16), 1
    word = first << 8 | more[0]
    if first >= _FULL:
        return signed(word, 15), int.from_bytes(more[1:])
    if first > _RUN:
        return signed(last + word - _WIDE_ZERO, 16), 1
    repeat = more[1] if first == _RUN else first - _SHORT_RUN
    return signed(last + signed(more[0], 8), 16), repeat
