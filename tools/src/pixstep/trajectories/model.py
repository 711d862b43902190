# SPDX-License-Identifier: MIT
"""The machine on the host: a servo between command and motor, play between motor and load.

The servo is of second order with velocity feed-forward; its loop runs SUBSTEPS times in a point
(semi-implicit Euler) on a command that is straight from point to point. None is a motor that is
always where it should be, as a stepper is. Positions are counts at the points.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

SUBSTEPS = 20
_STABLE = 0.5  # radians of the natural frequency in a substep: far from where the loop swings up


@dataclass(frozen=True)
class Servo:
    """Natural frequency in Hz and damping of a position loop."""

    hz: float
    damping: float = 0.6


def follow(command: np.ndarray, point_s: float, servo: Servo | None) -> np.ndarray:
    """Return where a motor is at each point; it begins on the command, at the command's speed.

    Raises UserError for a loop too quick for points of this length.
    """
    if servo is None:
        return command.astype(np.float64)
    rate = 2 * pi * servo.hz
    if not 0 < rate * point_s / SUBSTEPS <= _STABLE or not 0 <= servo.damping <= 4:
        raise UserError(
            f"a servo of {servo.hz:g} Hz, damping {servo.damping:g}, cannot be followed in points "
            f"of {point_s:g} s: above 0 and at most {_STABLE * SUBSTEPS / (2 * pi * point_s):g} Hz"
        )
    speeds = np.diff(command) / point_s
    ahead = _point(1.0, 0.0, 0.0, point_s, servo)
    fast = _point(0.0, 1.0, 0.0, point_s, servo)
    pushed = _point(0.0, 0.0, 1.0, point_s, servo)
    lag, speed = 0.0, float(speeds[0])  # motor less command, motor's speed
    lags = [0.0]
    for wanted in speeds.tolist():
        lag, speed = (
            ahead[0] * lag + fast[0] * speed + pushed[0] * wanted,
            ahead[1] * lag + fast[1] * speed + pushed[1] * wanted,
        )
        lags.append(lag)
    motor: np.ndarray = command + np.array(lags)
    return motor


def _point(
    lag: float, speed: float, wanted: float, point_s: float, servo: Servo
) -> tuple[float, float]:
    """Return lag and speed of a motor one point on, the command moving at speed `wanted`."""
    rate, step = 2 * pi * servo.hz, point_s / SUBSTEPS
    for _ in range(SUBSTEPS):
        speed += step * (rate * rate * -lag + 2 * servo.damping * rate * (wanted - speed))
        lag += step * (speed - wanted)
    return lag, speed


def load(motor: np.ndarray, play: float, taken_up: int) -> np.ndarray:
    """Return where the load is at each point; at first it is on the motor, pushed `taken_up`."""
    low = 0.0 if taken_up > 0 else -play
    high = low + play
    place = float(motor[0])
    places = []
    for position in motor.tolist():
        place = min(max(place, position + low), position + high)
        places.append(place)
    return np.array(places)
