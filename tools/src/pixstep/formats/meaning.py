# SPDX-License-Identifier: MIT
"""What the numbers and header fields of a file mean: it depends on the file and on the motor."""

from typing import NotRequired, TypedDict

from pixstep.formats.header import ProfileHeader
from pixstep.formats.motion import CSB_KIND, CSV_KIND, Block
from pixstep.formats.prn import KIND as PRN_KIND

_STEPS = "steps moved in the pixel"

# kind: meaning for a smooth motor (M39), for a plain one (all others)
VALUES = {
    PRN_KIND: ("speed at the end of the pixel, steps/pixel", f"{_STEPS}, which is its speed"),
    CSV_KIND: (_STEPS, _STEPS),
    CSB_KIND: (_STEPS, _STEPS),
}

FIELDS = {
    "timestamp": "when the file was written",
    "name": "profile name",
    "Lines": "lines in the file",
    "HAPs": "homing acceleration pixels: leading entries usable in homing",
    "LeadIn": "constant-speed pixels before the first image pixel; 0: as configured",
    "Pixel Frequency": "pixel clock, Hz",
}


class LineFigures(TypedDict):
    """Figures of one line as plain data; the steps of a PRN's depend on the motor."""

    line: int
    values: int
    announced: int
    minimum: int
    maximum: int
    steps: NotRequired[int]
    steps_smooth: NotRequired[int | None]
    steps_plain: NotRequired[int]


def header_fields(header: ProfileHeader) -> dict[str, str | int]:
    """Return the fields of a header by the names of FIELDS."""
    return dict(zip(FIELDS, vars(header).values(), strict=True))


def smooth_steps(speeds: tuple[int, ...]) -> int | None:
    """Return the steps that a smooth motor makes along a PRN; None if a speed is odd."""
    if any(speed % 2 for speed in speeds):
        return None
    return sum((start + end) // 2 for start, end in zip((0, *speeds[:-1]), speeds, strict=True))


def line_figures(number: int, block: Block) -> LineFigures:
    """Return the figures of one line: number of values, extremes, steps in both directions."""
    return {
        "line": number,
        "values": len(block.values),
        "announced": block.declared,
        "minimum": min(block.values),
        "maximum": max(block.values),
        "steps": sum(abs(value) for value in block.values),
    }
