# SPDX-License-Identifier: MIT
"""The lines of an image: motors that scan along them, step between them, turn inside, stand still.

    line forth   |0| up | lead-in | image ......... | lead-out | down |0|
    line back    |0| up | lead-out | image ........ | lead-in  | down |0|     the same counts

All scanning motors make the same counts forth and back, so that play and ramps cancel out: the
image of a line back begins where that of a line forth ends. An offset of `scan_offset_back` against
`scan_offset_forward` moves it. What is no whole number of pixels is made in every line's
deceleration, which a line back does not begin with.

Motors that step do so after the image; motors that turn do so in its middle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from pixstep.errors import UserError
from pixstep.formats.header import MOST_LINES
from pixstep.jobs.assembly import ImagePlace, MotorStroke
from pixstep.jobs.ramps import RampFromRest
from pixstep.jobs.shapes import RETURN
from pixstep.profiles import generator
from pixstep.profiles.generator import MOST_PIXELS


@dataclass(frozen=True)
class ImageGeometry:
    """What all lines have in common: lengths in pixels, offsets in steps of the scanning motor."""

    lines: int
    pixels: int
    lead_in: int = 0
    lead_out: int = 0
    alternate: bool = True
    offset_forward: int = 0
    offset_back: int = 0


@dataclass(frozen=True)
class ScanMotor:
    """A motor that moves along the lines. `negative`: forth is its negative direction."""

    motor: str
    ramp: RampFromRest
    plain: bool = False
    backlash: int = 0
    negative: bool = False

    @property
    def zeros(self) -> tuple[int, ...]:
        """The pixel without steps at either end, of a line that takes play up."""
        return (0,) if self.backlash else ()

    @property
    def head(self) -> int:
        """Pixels before it has its speed."""
        return self.ramp.pixels + len(self.zeros)

    def travel(self, pixels: int) -> int:
        """Return the steps of the load from line zero to where it has made so many pixels."""
        return sum(self.ramp.counts) + (pixels - self.head) * self.ramp.speed

    def stroke(self, total: int, rest: int, *, back: bool) -> MotorStroke:
        """Return a line of `total` pixels, `rest` steps of which are part of a pixel's."""
        down = self.ramp.falling(rest, plain=self.plain)
        constant = total - 2 * len(self.zeros) - self.ramp.pixels - len(down)
        speed = (self.ramp.speed,) * constant
        counts = (*self.zeros, *self.ramp.counts, *speed, *down, *self.zeros)
        negative = self.negative != back
        if self.plain and negative:
            return MotorStroke(tuple(-count for count in counts))
        return MotorStroke(counts, negative)


@dataclass(frozen=True)
class ImageMove:
    """A motor's move of exactly so many steps: between lines, or forth and back inside each.

    The counts of a smooth motor have no sign: `negative` says its direction.
    """

    motor: str
    ramp: RampFromRest
    negative: bool = False

    @property
    def counts(self) -> tuple[int, ...]:
        """Steps of each pixel."""
        return self.ramp.counts


@dataclass(frozen=True)
class ImageLayout:
    """Where the image is in the lines of some scanning motors; pixels count from 0."""

    image: ImageGeometry
    head: int
    shift: int = 0  # whole pixels that the image of a line back begins earlier
    rest: int = 0  # steps beside them

    @property
    def total(self) -> int:
        """Pixels of a line."""
        image = self.image
        inside = image.lead_in + image.pixels + image.lead_out
        return 2 * self.head + inside + (1 if self.rest else 0)

    def begin(self, *, back: bool) -> int:
        """Return the first pixel of the image in a line forth or back."""
        if back:
            return self.head + self.image.lead_out - self.shift
        return self.head + self.image.lead_in

    def end(self, *, back: bool) -> int:
        """Return the pixel after the image."""
        return self.begin(back=back) + self.image.pixels

    def after(self, *, back: bool) -> int:
        """Return how many pixels follow the image."""
        return self.total - self.end(back=back)


def layout(image: ImageGeometry, scans: Sequence[ScanMotor]) -> ImageLayout:
    """Return where the image is. Raises UserError for offsets that the lines cannot have."""
    head = max((scan.head for scan in scans), default=0)
    offset = image.offset_back - image.offset_forward
    if not offset or not image.alternate:
        return ImageLayout(image, head)
    if len(scans) != 1:
        raise UserError(f"scan offsets: of one scanning motor only, there are {len(scans)}")
    (scan,) = scans
    shift, rest = divmod(offset, scan.ramp.speed)
    if rest % 2 and not scan.plain:
        raise UserError(
            f"scan offset of {offset} steps between forth and back: a smooth line has an even "
            f"number of steps, nearest {offset - 1} and {offset + 1}"
        )
    made = ImageLayout(image, head, shift, rest)
    if made.begin(back=True) < head or made.after(back=True) < head:
        raise UserError(
            f"scan offset of {offset} steps between forth and back is {shift} pixels and {rest} "
            f"steps: make lead-in and lead-out {abs(shift)} pixels longer"
        )
    return made


def roomy(found: ImageLayout, moves: Sequence[ImageMove]) -> ImageLayout:
    """Return a layout with lead-ins and lead-outs in which the motors that step can do it."""
    longest = max((len(move.counts) for move in moves), default=0)
    image = found.image
    if not image.alternate:
        more = max(0, longest - found.total)
        return replace(found, image=replace(image, lead_out=image.lead_out + more))
    forth = max(0, longest - found.after(back=False))
    back = max(0, longest - found.after(back=True))
    longer = replace(image, lead_in=image.lead_in + back, lead_out=image.lead_out + forth)
    return replace(found, image=longer)


def places(found: ImageLayout) -> list[ImagePlace]:
    """Return where the image is in each line; between lines of one direction there are returns."""
    return [
        ImagePlace(0, RETURN) if is_return else ImagePlace(found.begin(back=back) + 1)
        for back, is_return in _order(found.image)
    ]


def scan_strokes(found: ImageLayout, scan: ScanMotor) -> list[MotorStroke]:
    """Return the lines of a motor that scans."""
    made = {back: scan.stroke(found.total, found.rest, back=back) for back in (False, True)}
    return [made[back] for back, _ in _order(found.image)]


def step_strokes(found: ImageLayout, move: ImageMove) -> list[MotorStroke]:
    """Return the lines of a motor that steps after each image but the last."""
    order = [*_order(found.image)]
    still = MotorStroke((0,) * found.total)
    strokes = [
        _stepping(found, move, back=back, is_return=is_return)
        if is_return or found.image.alternate
        else still
        for back, is_return in order
    ]
    return [*strokes[:-1], still]


def turn_strokes(found: ImageLayout, move: ImageMove, rest_px: int) -> list[MotorStroke]:
    """Return the lines of a motor that goes forth and back around the middle of each image."""
    made = {back: _turning(found, move, rest_px, back=back) for back in (False, True)}
    still = MotorStroke((0,) * found.total)
    return [still if is_return else made[back] for back, is_return in _order(found.image)]


def still_strokes(found: ImageLayout) -> list[MotorStroke]:
    """Return the lines of a motor that stands still."""
    return [MotorStroke((0,) * found.total)] * len(_order(found.image))


def _order(image: ImageGeometry) -> list[tuple[bool, bool]]:
    """Return of each line whether it goes back, and whether it is a return without an image."""
    if image.alternate:
        return [(number % 2 == 1, False) for number in range(image.lines)]
    return [(False, False), *[(True, True), (False, False)] * (image.lines - 1)]


def _stepping(found: ImageLayout, move: ImageMove, *, back: bool, is_return: bool) -> MotorStroke:
    begin = 0 if is_return else found.end(back=back)
    return _within(found, move, begin, move.counts)


def _turning(found: ImageLayout, move: ImageMove, rest_px: int, *, back: bool) -> MotorStroke:
    forth = move.counts
    counts = generator.forth_and_back(forth, rest_px)
    middle = found.begin(back=back) + found.image.pixels // 2
    begin = middle - len(forth) - rest_px // 2
    if begin < 0 or begin + len(counts) > found.total:
        raise UserError(
            f"motor {move.motor} turns in the middle of the image: {len(counts)} pixels forth and "
            f"back do not fit the line of {found.total} there: fewer steps, or a longer lead-in "
            f"and lead-out"
        )
    return _within(found, move, begin, counts)


def _within(
    found: ImageLayout, move: ImageMove, begin: int, counts: tuple[int, ...]
) -> MotorStroke:
    after = found.total - begin - len(counts)
    return MotorStroke((*(0,) * begin, *counts, *(0,) * after), move.negative)


def refuse_long(found: ImageLayout) -> None:
    """Raise UserError for lines that no file holds, and for more of them than a job may have."""
    if found.total > MOST_PIXELS:
        raise UserError(f"lines of {found.total} pixels: a line has {MOST_PIXELS} at most")
    if found.image.lines > MOST_LINES:
        raise UserError(f"{found.image.lines} lines: a job has {MOST_LINES} at most")


def strokes_of(
    found: ImageLayout, scans: Sequence[ScanMotor], steps: Sequence[ImageMove],
    turns: Mapping[str, ImageMove], rest_px: int, still: Sequence[str],
) -> dict[str, list[MotorStroke]]:  # fmt: skip
    """Return the lines of all motors. Raises UserError for lines that are too long or too many."""
    refuse_long(found)
    return {
        **{scan.motor: scan_strokes(found, scan) for scan in scans},
        **{move.motor: step_strokes(found, move) for move in steps},
        **{name: turn_strokes(found, move, rest_px) for name, move in turns.items()},
        **{name: still_strokes(found) for name in still},
    }
