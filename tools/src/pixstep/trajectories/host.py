# SPDX-License-Identifier: MIT
"""A table on the modelled machine: what its load does without any board."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pixstep.lazy import lazy
from pixstep.trajectories import model, transitions
from pixstep.trajectories.model import Servo
from pixstep.trajectories.table import AXES, Table
from pixstep.trajectories.trace import Trace
from pixstep.trajectories.transitions import AxisPlay

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

ORIGINAL, COMPENSATED = "original", "compensated"


@dataclass(frozen=True)
class Machine:
    """Play by axis in counts, length of a point, servo of both axes (None: ideal)."""

    plays: tuple[int, ...]
    point_s: float
    servo: Servo | None = None


def command(original: Table, plays: tuple[AxisPlay, ...], name: str) -> Table:
    """Return the table that is run: the original, or the compensated one made now."""
    if name == ORIGINAL:
        return original
    return transitions.compensate(original, plays).table


def run(original: Table, plays: tuple[AxisPlay, ...], name: str, machine: Machine) -> Trace:
    """Return what a table does: `plays` are what is compensated, the machine has its own."""
    made = command(original, plays, name)
    motors, loads = [], []
    for axis, play in zip(range(AXES), machine.plays, strict=True):
        motor = model.follow(made.positions[:, axis], machine.point_s, machine.servo)
        motors.append(motor)
        loads.append(model.load(motor, play, transitions.initial_direction(original, axis)))
    return Trace(
        name,
        made,
        original.positions,
        np.column_stack(motors),
        np.column_stack(loads),
        machine.point_s,
    )
