# SPDX-License-Identifier: MIT
"""The acceleration profile of fast moves and homing, CSV or CSB: steps in each pixel, from rest."""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate, pairwise
from pathlib import Path

from pixstep import formats
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.formats.header import HEADER_LINES
from pixstep.formats.motion import BLOCKS, CSB_KIND
from pixstep.lines.line import SMOOTH, Line
from pixstep.lines.line_check import MAX_COUNT
from pixstep.profiles import origin

CSV_WIDTH = 6
BLOCK_ROWS = 2  # line number and number of values before the values of a block


@dataclass(frozen=True)
class Acceleration:
    """Steps in each pixel of an acceleration from rest: above 0, never falling.

    `haps` is how many leading entries homing may use (0: the file does not say), `made_for_hz` the
    pixel frequency that its header, else its name tells (None: neither does).
    """

    counts: tuple[int, ...]
    haps: int = 0
    source: str = "profile"
    made_for_hz: Fraction | None = None
    header: formats.ProfileHeader | None = None
    notes: tuple[str, ...] = ()

    @property
    def top(self) -> int:
        """The highest speed, steps/pixel."""
        return self.counts[-1]

    def limited(self, max_speed: int | None) -> "Acceleration":
        """Return the part below `max_speed` steps/pixel, which becomes its last entry.

        A profile that stays at or below it is returned as it is. Raises UserError below 1.
        """
        if max_speed is None or self.top <= max_speed:
            return self
        if max_speed < 1:
            raise UserError(f"maximum speed {max_speed}: at least 1 step/pixel")
        lower = tuple(count for count in self.counts if count < max_speed)
        return replace(self, counts=(*lower, max_speed))

    def leading(self, entries: int) -> "Acceleration":
        """Return the first `entries` entries; raises UserError if that is none at all."""
        if entries < 1:
            raise UserError(f"HAPs {entries}: homing needs at least 1 entry of {self.source}")
        return replace(self, counts=self.counts[:entries])

    def speeds(self, decode: str) -> tuple[int, ...]:
        """Return the speed at the end of each entry, steps/pixel.

        Plain, an entry is its own speed; smooth, the speed changes inside it: v' = 2n - v.
        """
        return Line(self.counts).speeds[1:] if decode == SMOOTH else self.counts

    def stopping_sums(self) -> list[int]:
        """Return the steps of an acceleration through the first 0, 1, 2 ... entries."""
        return list(accumulate(self.counts, initial=0))

    def notes_at(self, pixel_hz: Fraction, *, refuse: bool = False) -> list[str]:
        """Return what was tolerated on reading, and a pixel frequency other than the file's.

        Raises UserError on `refuse` if that frequency is higher.
        """
        other = origin.frequency_notes(Path(self.source), self.header, pixel_hz, refuse=refuse)
        return [*self.notes, *other]


def read(
    path: Path, *, raw: bool = False, number: int | None = None, max_speed: int | None = None
) -> Acceleration:
    """Read a CSV or CSB profile, bare or with the 40-column header, limited to `max_speed`.

    `number` chooses a line, from 1; without it the file must hold only one. Raises UserError naming
    the place of an entry of 0 or less, of a falling one, and of one that no pixel can hold.
    """
    found = formats.read_motion(path, raw=raw)
    counts = found.line(number).values
    for index, (before, count) in enumerate(pairwise((0, *counts))):
        if count <= 0:
            raise RefusedError(
                f"{_place(found, number or 1, index)}: {count} steps in a pixel: an acceleration "
                f"profile's entries are above 0"
            )
        if count < before:
            raise RefusedError(
                f"{_place(found, number or 1, index)}: the speed falls from {before} to {count} "
                f"steps/pixel"
            )
    haps = found.header.haps if found.header else 0
    hz = origin.frequency_of(path, found.header)
    profile = Acceleration(counts, haps, str(path), hz, found.header, found.notes)
    profile = profile.limited(max_speed)
    for index, count in enumerate(profile.counts):
        if count > MAX_COUNT:
            raise RefusedError(AskedText(
                "{place}: {count} steps in a pixel, the board takes at most {most} ({max_speed} "
                "limits it)",
                place=_place(found, number or 1, index), count=count, most=MAX_COUNT,
            ))  # fmt: skip
    return profile


def _place(file: formats.MotionFile, number: int, index: int) -> str:
    """Return where the value at `index` of a line is: file, row and column; in a CSB its entry."""
    if file.kind == CSB_KIND:
        return f"{file.path}: line {number}, entry {index + 1}"
    before = [len(block.values) for block in file.blocks[: number - 1]]
    row = 1 + index + (HEADER_LINES if file.header else 0)
    if file.reading == BLOCKS:
        row += sum(before) + BLOCK_ROWS * number
    value = str(file.blocks[number - 1].values[index])
    return f"{file.path}:{row}:{CSV_WIDTH + 1 - len(value)}"
