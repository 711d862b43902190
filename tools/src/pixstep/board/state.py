# SPDX-License-Identifier: MIT
"""What a board tells besides single registers: records, switches, a seek's end, its event log."""

from dataclasses import dataclass

from pixstep.board import registers as regs

EVENT_RESET = 0x0100  # codes of the event log from here on: a reset, its cause in the low byte


@dataclass(frozen=True)
class Record:
    """One per-pixel record of the board."""

    pixel: int
    expected_steps: int
    actual_steps: int
    edge_error_ticks: int


@dataclass(frozen=True)
class Records:
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


def parse_records(words: list[int]) -> Records:
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
    return Records(words[3], records)


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
