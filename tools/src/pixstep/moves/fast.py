# SPDX-License-Identifier: MIT
"""Fast move: exactly N steps in the fewest pixels that an acceleration profile allows.

With the profile's entries r1..rm, pixel k of K cannot be faster than r(min(k, K + 1 - k)): up
through the entries, held at the last one, down mirrored. K is the smallest number of pixels for
which these bounds add up to N or more. They seldom add up to N exactly, so the top is lowered,
like water that runs out of a hill upside down: every pixel above a level L gets L, and a few in
the middle L + 1.

    bound    |    .........          counts   |     .-----.        L + 1
             |  ..         ..                 |  .--       --.     L
             |..             ..               |..             ..
             +-----------------               +-----------------

No jump between neighbours is larger than the one of the profile that it lies within, the speed
rises and then falls, and of all moves as short as this one it has the lowest top speed.

The acceleration profile of fast moves and homing, CSV or CSB: steps in each pixel, from rest.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate, pairwise
from pathlib import Path

from pixstep import formats
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.formats.header import HEADER_LINES
from pixstep.formats.motion import BLOCKS, CSB_KIND
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import MAX_COUNT
from pixstep.lines.runs import decode
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


MAX_STEPS = 2**31 - 1  # the board's position is a signed 32-bit number
MAX_PIXELS = 5_000_000


@dataclass(frozen=True)
class FastMove:
    """A planned move: signed runs (steps in each pixel, pixels), their sum is `steps`."""

    runs: tuple[tuple[int, int], ...]
    steps: int

    @property
    def pixels(self) -> int:
        """Length, pixels."""
        return sum(repeat for _, repeat in self.runs)

    @property
    def top(self) -> int:
        """Highest speed, steps/pixel."""
        return max(abs(count) for count, _ in self.runs)

    @property
    def counts(self) -> tuple[int, ...]:
        """Signed steps in each pixel."""
        return tuple(decode(self.runs))

    def seconds(self, pixel_hz: Fraction) -> float:
        """Return how long the move takes."""
        return float(self.pixels / pixel_hz)

    def line(self, name: str = "move") -> Line:
        """Return the move as a line: plain, and started without the pixel clock."""
        return Line(self.counts, PLAIN, name=name, clocked=False)


def plan(profile: Acceleration, steps: int) -> FastMove:
    """Return the move of `steps` steps, signed.

    Raises UserError for 0 steps, more than MAX_STEPS, or a move longer than MAX_PIXELS.
    """
    if not 1 <= abs(steps) <= MAX_STEPS:
        raise UserError(f"a move of {steps} steps: 1 to {MAX_STEPS} in either direction")
    distance = abs(steps)
    pixels = fewest_pixels(profile, distance)
    if pixels > MAX_PIXELS:
        raise UserError(
            f"{distance} steps at no more than {profile.top} steps/pixel take {pixels} pixels, "
            f"more than {MAX_PIXELS}"
        )
    sign = 1 if steps > 0 else -1
    level, above = _level(profile, pixels, distance)
    runs = _runs(profile.counts, pixels, level, above)
    return FastMove(tuple((sign * count, repeat) for count, repeat in runs), steps)


def fewest_pixels(profile: Acceleration, distance: int) -> int:
    """Return the smallest number of pixels in which `distance` steps can be made."""
    reach = 0  # of k pixels: r1 + r1, + r2 + r2 ...; the middle one of an odd number counts once
    for index, count in enumerate(profile.counts):
        if reach + count >= distance:
            return 2 * index + 1
        reach += 2 * count
        if reach >= distance:
            return 2 * index + 2
    return 2 * len(profile.counts) + -(-(distance - reach) // profile.top)


def _level(profile: Acceleration, pixels: int, distance: int) -> tuple[int, int]:
    """Return the highest level whose clipped bounds sum to `distance` or less, and the rest."""

    def clipped_sum(level: int) -> int:
        ramp = _ramp(profile.counts, pixels, level)
        return 2 * sum(ramp) + level * (pixels - 2 * len(ramp))

    low, high = 1, profile.top
    while low < high:
        middle = (low + high + 1) // 2
        if clipped_sum(middle) <= distance:
            low = middle
        else:
            high = middle - 1
    return low, distance - clipped_sum(low)


def _ramp(counts: tuple[int, ...], pixels: int, level: int) -> list[int]:
    """Return the entries below `level` that one half of the move holds, the flat one less."""
    return [count for count in counts[: pixels // 2] if count < level]


def _runs(counts: tuple[int, ...], pixels: int, level: int, above: int) -> list[tuple[int, int]]:
    """Return ramp, level with `above` pixels of one step more in its middle, ramp mirrored."""
    rising = [(count, 1) for count in _ramp(counts, pixels, level)]
    flat = pixels - 2 * len(rising)
    before = (flat - above) // 2
    middle = [(level, before), (level + 1, above), (level, flat - above - before)]
    parts = [*rising, *(middle if above else [(level, flat)]), *reversed(rising)]
    return [(count, repeat) for count, repeat in parts if repeat]
