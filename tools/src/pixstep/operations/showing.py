# SPDX-License-Identifier: MIT
"""A line or a profile shown: its figures as a table, and its drawing in a file."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from pixstep.formats import ProfileHeader
from pixstep.lines import units
from pixstep.lines.units import ACCELERATION, JERK, SPEED, Quantity
from pixstep.operations import reading_lines
from pixstep.operations.desk import Desk
from pixstep.operations.result import Page, Result
from pixstep.profiles import origin, page
from pixstep.profiles.kinematics import LineDrawing
from pixstep.profiles.page import MotionFigures


class ShownMotion(MotionFigures):
    """The figures of a line or profile; `image_pixel` is the pixel, from 1, of the image."""

    file: str
    drawing: str | None
    decode: str
    image_pixel: int | None


def limits(hz: Fraction | None, *given: Quantity | None, least: int = 1) -> dict[int, int]:
    """Return limits of speed, acceleration and jerk in whole steps and pixels, by their order."""
    return {
        order: units.whole_limit(limit, hz, least=least)
        for order, limit in zip((SPEED, ACCELERATION, JERK), given, strict=True)
        if limit is not None
    }


def used_frequency(
    desk: Desk,
    given: Fraction | None,
    path: Path,
    header: ProfileHeader | None,
    divider: int = 1,
) -> Fraction | None:
    """Return the frequency of pixels: the caller's, else that of the file, else the machine's.

    A pixel has `divider` edges of the clock. A file that was made for another frequency than is
    given gets a note.
    """
    desk.say(reading_lines.motor_notes(desk.facts, path, header))
    own = origin.frequency_of(path, header)
    if own is None or (given and not desk.by_machine("pixel_hz")):
        desk.say(origin.frequency_notes(path, header, given, divider=divider))
        return given
    return own


def shown(drawing: LineDrawing, output: Path | None) -> Result:
    """Write the drawing if a file is given; return the figures."""
    line, figures = drawing.line, drawing.figures
    if output is not None:
        from pixstep.profiles import figure  # matplotlib takes a second to load

        figure.save(drawing, output)
    data: ShownMotion = {
        "file": line.name,
        "drawing": str(output) if output else None,
        "decode": line.decode,
        "image_pixel": drawing.image_pixel,
        **page.figures_json(figures, drawing.pixel_hz),
    }

    def write(to: Page) -> None:
        to.tell(f"{line.name}: decoded as {line.decode}")
        to.draw(page.figures_table(figures, drawing.pixel_hz))
        if output is not None:
            to.tell(f"{output}: drawn")

    return Result(data, write, value=drawing)
