# SPDX-License-Identifier: MIT
"""The CSV acceleration profile of fast moves and homing: steps in each pixel, from rest upwards."""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate
from pathlib import Path

from pixstep import files
from pixstep.errors import UserError
from pixstep.linecheck import MAX_COUNT
from pixstep.rational import parse_hz

HEADER_ROWS = 4
BLOCK_ROWS = 2  # line number and number of values before the values of a block


@dataclass(frozen=True)
class Acceleration:
    """Steps in each pixel of an acceleration from rest: above 0, never falling.

    `haps` is how many leading entries homing may use (0: the file does not say), `made_for_hz` the
    pixel frequency its header names (None: it has no header).
    """

    counts: tuple[int, ...]
    haps: int = 0
    source: str = "profile"
    made_for_hz: Fraction | None = None
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
        return self._replaced((*lower, max_speed))

    def leading(self, entries: int) -> "Acceleration":
        """Return the first `entries` entries; raises UserError if that is none at all."""
        if entries < 1:
            raise UserError(f"HAPs {entries}: homing needs at least 1 entry of {self.source}")
        return self._replaced(self.counts[:entries])

    def stopping_sums(self) -> list[int]:
        """Return the steps of an acceleration through the first 0, 1, 2 ... entries."""
        return list(accumulate(self.counts, initial=0))

    def _replaced(self, counts: tuple[int, ...]) -> "Acceleration":
        return replace(self, counts=counts)

    def notes_at(self, pixel_hz: Fraction) -> list[str]:
        """Return what was tolerated on reading, and a pixel frequency other than the file's."""
        notes = list(self.notes)
        if self.made_for_hz not in (None, pixel_hz):
            notes.append(
                f"{self.source}: made for {float(self.made_for_hz):g} Hz, used at "
                f"{float(pixel_hz):g} Hz: its acceleration per second is another"
            )
        return notes


def read(path: Path, *, raw: bool = False, max_speed: int | None = None) -> Acceleration:
    """Read a CSV profile, bare or with the 40-column header, limited to `max_speed`.

    Raises UserError naming file and line for an entry of 0 or less, a falling one, and one that
    no pixel can hold.
    """
    found = files.read_csv(path, raw=raw)
    first = 1
    if found.header:
        first += HEADER_ROWS + (0 if raw else BLOCK_ROWS)
    check(found.values, str(path), first)
    haps = found.header.haps if found.header else 0
    hz = parse_hz(found.header.pixel_hz) if found.header else None
    profile = Acceleration(found.values, haps, str(path), hz, found.notes).limited(max_speed)
    _check_top(profile, first)
    return profile


def check(counts: tuple[int, ...], source: str, first_row: int = 1) -> None:
    """Refuse entries of 0 or less and falling ones, by file and row."""
    previous = 0
    for row, count in enumerate(counts, first_row):
        if count <= 0:
            raise UserError(
                f"{source}:{row}: {count} steps in a pixel: an acceleration profile's entries are "
                f"above 0"
            )
        if count < previous:
            raise UserError(
                f"{source}:{row}: the speed falls from {previous} to {count} steps/pixel"
            )
        previous = count


def _check_top(profile: Acceleration, first_row: int) -> None:
    """Refuse an entry beyond what a pixel can hold."""
    for row, count in enumerate(profile.counts, first_row):
        if count > MAX_COUNT:
            raise UserError(
                f"{profile.source}:{row}: {count} steps in a pixel, the board takes at most "
                f"{MAX_COUNT} (--max-speed limits it)"
            )
