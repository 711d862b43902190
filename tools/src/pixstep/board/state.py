# SPDX-License-Identifier: MIT
"""What a board tells besides single registers: records, switches, seeks, events, its clock.

The block of an axis' newest records is read in one request or, on a shared bus, in two. Between the
two the board may make records, and those in the block move forward by as many places. The second
request therefore begins some records before the first one ends: by these the two fit together, and
what comes out is the block as it was at the first request.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import registers as regs
from pixstep.board.errors import BoardError

EVENT_RESET = 0x0100  # codes of the event log from here on: a reset, its cause in the low byte


@dataclass(frozen=True)
class Record:
    """One per-pixel record of the board."""

    pixel: int
    expected_steps: int
    actual_steps: int
    edge_error_ticks: int


@dataclass(frozen=True)
class NewestRecords:
    """The newest per-pixel records of an axis, oldest first.

    `made` is how many its line has made so far, modulo 65536.
    """

    made: int
    records: list[Record]


TRIP_NONE, TRIP_CLOSED, TRIP_OPENED, TRIP_ALREADY = range(4)


@dataclass(frozen=True)
class Trip:
    """How the last seek line ended: the edge of a home switch, as the hardware captured it.

    `code` is TRIP_CLOSED or TRIP_OPENED; TRIP_NONE if the line went to its end or still runs,
    TRIP_ALREADY if the switch was as sought from the start: no edge then. `position_steps` is the
    axis' position at the edge (the steps whose STEP edge lies at or before it), `ticks` when it was
    since the board's timers started, modulo 2^32.
    """

    code: int
    axis: int
    position_steps: int
    ticks: int


@dataclass(frozen=True)
class Switches:
    """The filtered switches of one axis; True is tripped."""

    home: bool
    limit_minus: bool
    limit_plus: bool


@dataclass(frozen=True)
class Event:
    """One entry of the event log: a fault, or a reset (code EVENT_RESET + cause)."""

    number: int
    code: int
    axis: int
    argument: int
    pixel: int
    time_ms: int

    @property
    def name(self) -> str:
        """The fault's name, or "reset"."""
        if self.code >= EVENT_RESET:
            return "reset"
        return regs.code_name(regs.faults(), self.code)

    @property
    def text(self) -> str:
        """What it means."""
        if self.code >= EVENT_RESET:
            cause = regs.register_map().input("reset_cause")
            return regs.words(cause, self.code - EVENT_RESET)
        faults = regs.faults()
        return faults[self.code].text if self.code in faults else "unknown to this tool"


def parse_records(words: list[int]) -> NewestRecords:
    """Decode the record block; each record holds only the low 16 bits of its pixel.

    From arming to a line's first pixel edge the block still has records of the line before: those
    are left out.
    """
    newest = words[0] << 16 | words[1]
    records = []
    for index in range(min(words[2], regs.MAX_RECORDS)):
        start = regs.RECORD_HEAD + index * regs.RECORD_REGISTERS
        low, *rest = words[start : start + regs.RECORD_REGISTERS]
        pixel = newest - ((newest - low) & 0xFFFF)
        error = rest[4] - 0x10000 if rest[4] & 0x8000 else rest[4]
        if pixel > 0:
            records.append(Record(pixel, _signed32(rest[0:2]), _signed32(rest[2:4]), error))
    return NewestRecords(words[3], records)


def parse_events(words: list[int], total: int) -> list[Event]:
    """Decode the entries of the event log, of which the first `total` are filled."""
    rows = [
        words[start : start + regs.EVENT_WORDS] for start in range(0, len(words), regs.EVENT_WORDS)
    ]
    return [
        Event(a, b, c, d, high << 16 | low, upper << 16 | lower)
        for a, b, c, d, high, low, upper, lower in rows[:total]
    ]


def _signed32(words: list[int]) -> int:
    value = words[0] << 16 | words[1]
    return value - (1 << 32) if value >> 31 else value


_HEAD, _WIDTH = regs.RECORD_HEAD, regs.RECORD_REGISTERS
_NUMBER = 2  # place in the head
_TRIES = 3

# From a place of the block, so many words; whether another request follows at once.
ReadBlock = Callable[[int, int, bool], list[int]]
_RecordWords = list[int]


def read_records(read_words: ReadBlock, capacity: int, most_words: int) -> NewestRecords:
    """Return the records of a block, no request for more than `most_words`.

    Only if they do not fit together time and again, one request asks for the whole block.
    """
    found = read_records_short(read_words, capacity, most_words)
    return found or parse_records(read_words(0, _HEAD + capacity * _WIDTH, False))


def read_records_short(
    read_words: ReadBlock, capacity: int, most_words: int
) -> NewestRecords | None:
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


def _made_between(before: list[_RecordWords], after: list[_RecordWords]) -> int | None:
    """Return by how many places records have moved between two requests; None for too many.

    `before` is what the first one has of that with which the second one begins.
    """
    for made in range(len(before)):
        if before[made:] == after[: len(before) - made]:
            return made
    return None


def _rows(words: list[int]) -> list[_RecordWords]:
    return [words[at : at + _WIDTH] for at in range(0, len(words), _WIDTH)]


def _flat(rows: list[_RecordWords]) -> list[int]:
    return [word for row in rows for word in row]


_INTERVAL_TICKS = 256  # unit of register clock_interval and of the faults' arguments
_TIMED_FAULTS = ("pixel_clock_off", "clock_drifted")
CLOCK_FAULTS = (*_TIMED_FAULTS, "pixel_clock_missing", "clock_hold_over")


def set_hz(numerator: int, denominator: int) -> Fraction:
    """Return the frequency that a board is set to; raises BoardError if it is none."""
    if not (numerator and denominator):
        raise BoardError(f"the pixel frequency is set to {numerator}/{denominator} Hz")
    return Fraction(numerator, denominator)


def interval_hz(interval: int, tick_hz: int) -> float | None:
    """Return the frequency of a clock by register clock_interval; None if it is the one set."""
    return tick_hz / (_INTERVAL_TICKS * interval) if interval else None


def fault_hz(name: str, argument: int, tick_hz: int) -> float | None:
    """Return the frequency that the argument of a clock's fault tells, if it does."""
    return interval_hz(argument, tick_hz) if name in _TIMED_FAULTS else None


def beside_set(measured_hz: float | None, set_hz: float) -> str:
    """Return in words what is measured beside what is set."""
    measured = f"measured {measured_hz:.4g} Hz, " if measured_hz else ""
    return f"{measured}set to {set_hz:.6g} Hz"
