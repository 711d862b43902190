# SPDX-License-Identifier: MIT
"""Axes of boards as a program sees them: at rest, and while a motion goes on."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from pixstep.api.records import AxisRecords
from pixstep.board import run as running
from pixstep.board.device import Board as Device


@dataclass(frozen=True)
class AxisState:
    """An axis of a board at rest or in motion."""

    axis: int
    """Axis, from 0."""
    state: str
    """`"empty"`, `"loaded"`, `"armed"`, `"running"`, `"done"`, `"fault"` and so on."""
    position_steps: int
    """Its position in steps, as the board counts."""
    play_known: bool = True
    """False if its newest line with backlash began without knowing the play, as after a reset."""
    records: AxisRecords | None = field(default=None, repr=False, compare=False)
    """The per-pixel records of the line that a run has made; None of an axis at rest, of a board
    that keeps none, and without numpy."""


@dataclass(frozen=True)
class AxisProgress:
    """An axis of a motion on its way, as the board was last asked of it."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis, from 0."""
    state: str
    """`"loaded"`, `"armed"`, `"running"`, `"done"`, `"fault"` and so on."""
    position_steps: int
    """Its position in steps, as the board counts."""
    pixel: int
    """The pixel of its line that it is in, from 1; 0 before the first."""
    pixels: int | None
    """Pixels of its line; None where that is not known beforehand."""
    share: float
    """How much of its motion is done, 0 to 1."""


def states_of(device: Device, axes: Sequence[int]) -> tuple[AxisState, ...]:
    """Return what a board says of some axes."""
    wanted = list(axes)
    states = running.states(device, wanted)
    places = running.positions(device, wanted)
    unknown = running.play_unknown(device, wanted)
    return tuple(AxisState(axis, states[axis], places[axis], axis not in unknown) for axis in axes)
