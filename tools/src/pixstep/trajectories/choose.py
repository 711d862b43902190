# SPDX-License-Identifier: MIT
"""How many points a transition should have: too few make the servo overshoot, too many leave slack.

Both errors come from the model of one crest, for a circle of the same radius.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, pi
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.trajectories import model
from pixstep.trajectories.model import Servo

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

BETWEEN = 8  # places in a point at which the radius is looked at
_BEFORE = 8  # points before the crest
_SETTLED = 7.0  # time constants of the servo
_GRID = 40


@dataclass(frozen=True)
class Crest:
    """Where an axis of a circle reverses: radius and play in counts, points of a revolution."""

    radius: int
    points: int
    play: int
    point_s: float
    servo: Servo | None = None


@dataclass(frozen=True)
class Choice:
    """The number of points chosen, and the largest radius error that it makes, in counts."""

    steps: int
    error: float


def predicted_error(crest: Crest, steps: int, places: int = BETWEEN) -> float:
    """Return the largest radius error, in counts, around a reversal of so many points.

    The radius is looked at at so many `places` of each point, in which motors move evenly. With 1
    it is that at the points alone, less than the truth by what the circle falls back in one of
    them.
    """
    behind = min(2 * steps + _settling(crest), crest.points // 4)
    point = np.arange(-_BEFORE, behind + 1)
    angle = 2 * pi * point / crest.points
    ramp = np.clip((point - 1) / steps, 0, 1) * crest.play  # begins in the first point moved back
    command = crest.radius * np.cos(angle) - ramp
    motor = model.follow(command, crest.point_s, crest.servo)
    fine = np.arange((len(point) - 1) * places + 1) / places
    motor, beside = (
        np.interp(fine, point + _BEFORE, one) for one in (motor, crest.radius * np.sin(angle))
    )
    distance = np.hypot(model.load(motor, crest.play, 1), beside)
    return float(np.max(np.abs(distance - crest.radius)))


def choose(crest: Crest, least: int = 1) -> Choice:
    """Return the number of points, at least `least`, with the smallest error.

    Raises UserError if not even an eighth of a revolution has so many.
    """
    most = crest.points // 8
    if least > most:
        raise UserError(
            f"a transition of at least {least} points for {crest.play} counts: longer than the "
            f"{most} points of an eighth of a revolution"
        )
    if crest.servo is None or not crest.play:
        return Choice(least, predicted_error(crest, least) if crest.play else 0.0)
    grid = sorted({round(value) for value in np.geomspace(least, most, _GRID)})
    best = min(grid, key=lambda steps: predicted_error(crest, steps))
    beside = [(low, high) for low, high in pairwise(grid) if best in (low, high)]
    near = range(beside[0][0], beside[-1][1] + 1) if beside else [best]
    steps = min(near, key=lambda one: predicted_error(crest, one))
    return Choice(steps, predicted_error(crest, steps))


def least_steps(play: int, most_a_point: int) -> int:
    """Return the fewest points in which at most so many counts are added to any."""
    return max(1, ceil(play / most_a_point)) if most_a_point > 0 else play + 1


def _settling(crest: Crest) -> int:
    """Return the points in which the servo comes to rest."""
    if crest.servo is None:
        return 0
    rate = 2 * pi * crest.servo.hz * max(crest.servo.damping, 0.05)
    return ceil(_SETTLED / (rate * crest.point_s))
