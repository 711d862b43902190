# SPDX-License-Identifier: MIT
"""Show what a line does."""

from __future__ import annotations

from pathlib import Path

from pixstep import formats
from pixstep.errors import UserError
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.lines.units import Quantity
from pixstep.operations import shared, showing
from pixstep.operations.clocks import OfClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, Pixels
from pixstep.operations.reading_lines import backlash_of
from pixstep.operations.request import argument, operation, option
from pixstep.operations.result import Result
from pixstep.operations.showing import ShownMotion
from pixstep.profiles.kinematics import LineDrawing


@operation("line show")
class LineShow(OfClock):
    """Show speed, acceleration, jerk and position of a line: a table, with --plot a drawing."""

    result = ShownMotion

    csv: Path = argument(FILE)
    decode: str = shared.decode()
    backlash: int = shared.backlash()
    raw: bool = shared.raw()
    lead_in: int | None = option(
        Pixels(0),
        "Constant pixels before the image, to mark its start. Default: the header's.",
    )
    needs_clock = False  # the header may say it

    max_speed: Quantity | None = shared.max_speed()
    max_acceleration: Quantity | None = shared.max_acceleration()
    max_jerk: Quantity | None = shared.max_jerk()
    plot: Path | None = shared.picture("-o", "--output")

    def run(self, desk: Desk) -> Result:
        """Read the line and show it."""
        read = formats.read_csv(self.csv, raw=self.raw)
        desk.say(read.notes)
        hz = showing.used_frequency(desk, self.pixel_hz, self.csv, read.header, self.edges)
        lead_in = self.lead_in
        if lead_in is None and read.header:
            lead_in = read.header.lead_in_px
        name = str(self.csv)
        play = backlash_of(desk, name, read.header, read.values, self.decode, self.backlash)
        line = Line(read.values, self.decode, play, name=name)
        _refuse_backlash(line)
        bounds = showing.limits(self, hz)
        image, scale = _image_pixel(line, lead_in), desk.facts.scale_if_known()
        return showing.shown(LineDrawing(line, self.csv.name, hz, bounds, image, scale), self.plot)


def _refuse_backlash(line: Line) -> None:
    """Refuse a backlash that the line cannot take up: there is nothing right to draw."""
    for item in line_check.check(line):
        if item.name.startswith("backlash"):
            raise UserError(f"{line.name}: {item.message}")


def _image_pixel(line: Line, lead_in: int | None) -> int | None:
    """Return the 1-based pixel where the image starts, None if the lead-in is not known.

    It lies `lead_in` pixels after the first one at the line's speed.
    """
    if lead_in is None or not line.line_speed:
        return None
    speeds = line.speeds if line.smooth else [abs(count) for count in line.counts]
    first = speeds.index(line.line_speed) + 1
    return first + lead_in if first + lead_in <= line.pixels else None
