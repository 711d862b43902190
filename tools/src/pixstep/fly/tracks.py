# SPDX-License-Identifier: MIT
"""Where one axis was expected and was, pixel by pixel, by its records.

A board that cannot send the record of each pixel in time keeps every Nth, and besides each whose
position is not the expected one. So an axis without the record of a pixel was where it was expected
to be, unless records were overwritten before they were read; and where it was expected its line
says.

The records are the motor's, with the steps that take up play. Positions of a scan's line are those
of its load, so that the play is left out: how much a line takes up shows once it has its full
speed. Positions of other lines are the board's count of the motor's steps.

The axes that fly: where each is, what its line is, and where its load is in which unit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING

from pixstep.api.motion import AxisRecords
from pixstep.api.motions import MotionLine
from pixstep.api.running import Lines, by_axis
from pixstep.errors import RefusedError
from pixstep.fly.scan_line import ScanLine
from pixstep.lazy import np, npt

if TYPE_CHECKING:
    Whole = npt.NDArray[np.int64]
    Known = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class FlownAxis:
    """An axis of a board with its line."""

    unit: int
    """Address of the board."""
    axis: int
    name: str
    """What keys of documents call it."""
    line: MotionLine

    @property
    def source(self) -> str:
        """Where its data come from, as documents say it."""
        return f"pixstep:board{self.unit}/axis{self.axis}"

    @property
    def steps_per_unit(self) -> float:
        """The motor's steps for one unit of its load, negative where the motor runs backwards."""
        motor = self.line.motor
        if isinstance(self.line, ScanLine):
            return self.line.steps_per_unit
        if motor is None:
            return 1.0
        scale = float(motor.steps_per_unit.steps_per_unit) if motor.steps_per_unit else 1.0
        return -scale if motor.negative else scale

    @property
    def length_unit(self) -> str:
        """`"mm"`, `"deg"`, or `"steps"` of a motor without a scale; of a scan's line its own."""
        motor = self.line.motor
        if isinstance(self.line, ScanLine):
            return self.line.unit
        scale = motor.steps_per_unit if motor else None
        return scale.length if scale else "steps"

    def origin(self, position_steps: int) -> float:
        """Return where an axis begins, by the motor's position before it flies.

        Of a scan's line that is where the load is to begin. Raises RefusedError if the motor is
        elsewhere, farther away than the play in which it may be beside its load.
        """
        here = position_steps / self.steps_per_unit
        if not isinstance(self.line, ScanLine):
            return here
        start = self.line.start
        motor = self.line.motor
        play = max(self.line.line.backlash, motor.backlash_steps if motor else 0)
        off_steps = round((start - here) * abs(self.steps_per_unit))
        if abs(off_steps) > play:
            unit = self.length_unit
            raise RefusedError(
                f"{self.name}: is at {here:.6g} {unit}, the scan's line begins at {start:.6g} "
                f"{unit}: move it there first, by {off_steps:+d} steps"
            )
        return start


def places_of(lines: Mapping[int, Lines]) -> list[FlownAxis]:
    """Return the axes of lines by the addresses of their boards.

    An axis is called by its motor, else by the axis of its scan, else `axis0`; with several boards
    `board1_axis0`.
    """
    found = []
    for unit, ours in lines.items():
        for axis, line in by_axis(ours).items():
            name = f"axis{axis}" if len(lines) == 1 else f"board{unit}_axis{axis}"
            if isinstance(line, ScanLine):
                name = line.scan_axis
            found.append(FlownAxis(unit, axis, line.motor.name if line.motor else name, line))
    names = [place.name for place in found]
    return [
        place
        if names.count(place.name) == 1
        else FlownAxis(place.unit, place.axis, f"board{place.unit}_{place.name}", place.line)
        for place in found
    ]


class FlightTrack:
    """An axis on its way; `origin` is where it is at line zero, in its unit."""

    def __init__(self, place: FlownAxis, origin: float) -> None:
        self.place, self._origin = place, origin
        line = place.line.line
        self.length = line.pixels
        direction = line.direction
        counts = (direction * count for count in line.counts)
        self._line = np.array([*accumulate(counts, initial=0)], dtype=np.int64)
        # From this pixel on all play is taken up that the line lacks.
        self._free = line.shifted_pixels
        self._all_play = direction * line.backlash
        self._play: int | None = None if line.backlash else 0

    def of(self, records: Sequence[AxisRecords]) -> AxisRecords | None:
        """Return this axis' records, if there are any yet."""
        for one in records:
            if (one.unit, one.axis) == (self.place.unit, self.place.axis) and len(one):
                return one
        return None

    def learn(self, records: AxisRecords, *, over: bool) -> bool:
        """Learn how much play the line takes up; True if positions can be told.

        Of a line that is over before its full speed all play is taken to be taken up.
        """
        if self._play is None:
            pixel = int(records.pixel[-1])
            if pixel >= self._free:
                self._play = int(records.expected_steps[-1]) - int(self._line[pixel])
            elif over:
                self._play = self._all_play
        return self._play is not None or not isinstance(self.place.line, ScanLine)

    def reached(self, records: AxisRecords) -> int:
        """Return the last pixel up to which the axis is known; one that has ended stays."""
        last = int(records.pixel[-1])
        return last if last < self.length else np.iinfo(np.int64).max

    def knows(self, pixels: Whole, records: AxisRecords) -> Known:
        """Return of which pixels the position is known."""
        recorded = np.isin(pixels, records.pixel)
        if records.missed:
            return recorded | (pixels > self.length)
        if self._play is None:
            return recorded
        # Until then the play that is taken up is known by records alone.
        return recorded | (pixels >= self._free)

    def steps(self, pixels: Whole, records: AxisRecords) -> tuple[Whole, Whole]:
        """Return where the motor was expected and was at the end of some pixels, from line zero."""
        expected = self._line[np.minimum(pixels, self.length)] + (self._play or 0)
        actual = expected.copy()
        found = np.searchsorted(records.pixel, pixels)
        found[found == len(records)] = 0
        recorded = records.pixel[found] == pixels
        expected[recorded] = records.expected_steps[found[recorded]]
        actual[recorded] = records.actual_steps[found[recorded]]
        ended = pixels > self.length  # it rests where its last pixel has it
        if ended.any() and records.pixel[-1] == self.length:
            actual[ended] = records.actual_steps[-1]
        return expected, actual

    def positions(self, steps: Whole) -> npt.NDArray[np.float64]:
        """Return positions in the axis' unit."""
        if isinstance(self.place.line, ScanLine):
            steps = steps - (self._play or 0)
        return self._origin + steps / self.place.steps_per_unit
