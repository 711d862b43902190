# SPDX-License-Identifier: MIT
"""PRN acceleration profile: unsigned integers, right-aligned in 8 columns, CR LF, no header."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pixstep.formats.findings import Findings
from pixstep.formats.numbers import PRN_COLUMNS, number_texts, read_numbers
from pixstep.formats.records import (
    REGULAR,
    LineEnds,
    check_line_ends,
    find_line_ends,
    join_records,
    split_records,
)

KIND = "prn"


@dataclass(frozen=True)
class PrnFile:
    """A profile: one value an entry, how its lines end, and what was tolerated.

    A value is a speed at the end of the pixel (steps/pixel) for a smooth motor, and the steps made
    in the pixel for a plain one; 0..99999999. The file does not say which.
    """

    values: tuple[int, ...]
    ends: LineEnds = REGULAR
    notes: tuple[str, ...] = ()

    kind = KIND

    def encode(self, path: Path | str = KIND) -> bytes:
        """Return the bytes of the file. Raises UserError for a value that does not fit."""
        return join_records(number_texts(self.values, PRN_COLUMNS, path), self.ends)


def parse_prn(data: bytes, findings: Findings) -> PrnFile:
    """Read a profile; the result is right only if nothing is refused."""
    check_line_ends(data, findings)
    values = read_numbers(split_records(data), PRN_COLUMNS, findings)
    return PrnFile(tuple(values), find_line_ends(data))


def check_smooth(values: tuple[int, ...], findings: Findings) -> None:
    """Find what a smooth motor's profile may not have: an odd speed, zero, a decrease."""
    for number, name, message in _smooth_faults(values):
        column = PRN_COLUMNS.column(values[number - 1])
        findings.error(name, number, column, message)


def _smooth_faults(values: tuple[int, ...]) -> Iterator[tuple[int, str, str]]:
    """Yield entry, name and message."""
    previous = 0
    for number, value in enumerate(values, 1):
        if value == 0:
            yield number, "zero_speed", "speed 0: the speeds of a smooth motor are above 0"
        elif value % 2:
            legal = f"nearest legal {value - 1} and {value + 1}"
            yield number, "odd_speed", f"speed {value} of a smooth motor is odd, {legal}"
        if value < previous:
            yield number, "falling_speed", f"speed falls from {previous} to {value}"
        previous = value
