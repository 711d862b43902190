# SPDX-License-Identifier: MIT
"""The axes that fly: where each is, what its line is, and where its load is in which unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pixstep.api.motions import MotionLine
from pixstep.api.running import Lines, by_axis
from pixstep.errors import RefusedError
from pixstep.fly.scan_line import ScanLine


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
