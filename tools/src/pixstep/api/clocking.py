# SPDX-License-Identifier: MIT
"""What the lines of a run are to the pixel clock."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from pixstep.api import given
from pixstep.api.machines import Motor
from pixstep.api.motions import MotionLine
from pixstep.api.words import Sync
from pixstep.errors import UserError


@dataclass(frozen=True)
class Clocking:
    """What the lines of a run are to the pixel clock; None where nothing says so."""

    sync: Sync | None
    divider: int | None
    gate_edges: int | None = None

    @classmethod
    def of(
        cls,
        lines: Mapping[int, MotionLine],
        sync: str | None,
        divider: int | None,
        gate_edges: int | None = None,
    ) -> Self:
        """Return what is given, else what the machine of the lines has.

        Raises UserError for what no board knows, and for a divider by which the pixels of a line
        would not be edges of its machine's clock.
        """
        wanted, divider = given.sync(sync), given.divider(divider)
        gate_edges = given.gate_edges(gate_edges)
        for item in lines.values():
            motor = item.motor
            if item.divider is not None:
                divider = _agreed(item, item.divider, divider, "the clock")
            if motor is None:
                continue
            wanted = wanted or motor.sync
            gate_edges = motor.gate_edges if gate_edges is None else gate_edges
            if item.divider is None and _has_own_pixels(item, motor):
                divider = _agreed(item, motor.divider, divider, "its machine's clock")
        return cls(wanted, divider, gate_edges)


def _has_own_pixels(item: MotionLine, motor: Motor) -> bool:
    """True if the pixels of a line are those of its machine's clock."""
    return item.hz == motor.pixel_hz


def _agreed(item: MotionLine, own: int, other: int | None, clock: str) -> int:
    """Return the divider of a line. Raises UserError if the run has another one."""
    if other not in (None, own):
        edges = "one edge" if own == 1 else f"{own} edges"
        raise UserError(f"{item.line.name}: its pixels are {edges} of {clock}, the run has {other}")
    return own
