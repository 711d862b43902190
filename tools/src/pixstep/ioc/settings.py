# SPDX-License-Identifier: MIT
"""What a machine file says of a motor, as the fields of its record before a client writes any."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lines.units import STEP
from pixstep.machine.describe import limit_per_second
from pixstep.motor_record.field import WANTED, is_record_name

if TYPE_CHECKING:
    from pixstep.machine.model import MachineTables, MotorTable
    from pixstep.motor_record.field import Value

_LONGEST_TEXT = 40
_USUAL_SPEED_STEPS_S = 1000.0  # of a motor whose file has no max_speed
_USUAL_RAMP_S = 0.5  # of a motor whose file has no max_acceleration
_SHORTEST_RAMP_S = 0.001
_TWEAK_STEPS = 100
_MOST_DIGITS = 15


def fields_of(machine: MachineTables, motor: MotorTable) -> dict[str, Value]:
    """Return the fields of a motor's record, in its units: mm or deg, or steps without a scale."""
    scale = motor.steps_per_unit
    step = float(1 / scale.steps_per_unit) if scale else 1.0
    board = machine.board_name(motor)
    return {
        "DESC": f"{motor.name}: {board}, axis {motor.axis}"[:_LONGEST_TEXT],
        "EGU": scale.length if scale else STEP,
        "MRES": step,
        "PREC": _digits(step),
        "DIR": 1 if motor.negative else 0,
        "RDBD": step,
        "BDST": motor.backlash_steps * step,
        "TWV": _TWEAK_STEPS * step,
        "OUT": f"@pixstep({board},{motor.axis})"[:_LONGEST_TEXT],
        **_speeds(machine, motor, step),
        **motor.epics.fields,
    }


def _speeds(machine: MachineTables, motor: MotorTable, step: float) -> dict[str, Value]:
    """Return the fields of speeds and ramps, per second."""

    def limit(key: str) -> float | None:
        found = limit_per_second(motor, key, machine.pixel_hz)
        return None if found is None else float(found) * step

    most, ramp = limit("max_speed"), limit("max_acceleration")
    base = limit("start_stop") or 0.0
    speed = most or _USUAL_SPEED_STEPS_S * step
    base = min(base, speed)
    ramp_s = (speed - base) / ramp if ramp else _USUAL_RAMP_S
    ramp_s = max(ramp_s, _SHORTEST_RAMP_S)
    return {
        "VMAX": most or 0.0,
        "VBAS": base,
        "VELO": speed,
        "BVEL": speed,
        "JVEL": speed / 2,
        "HVEL": speed / 2,
        "ACCL": ramp_s,
        "BACC": ramp_s,
        "JAR": ramp or speed / ramp_s,
    }


def _digits(step: float) -> int:
    """Return how many digits after the point show a step."""
    return min(_MOST_DIGITS, max(0, math.ceil(-math.log10(step)) + (step < 1)))


def record_names(machine: MachineTables, prefix: str) -> dict[str, str]:
    """Return the names of the records by the names of the motors.

    Raises UserError for a name that no record can have.
    """
    names = {name: prefix + (motor.epics.name or name) for name, motor in machine.motors.items()}
    for motor, record in names.items():
        if not is_record_name(record):
            raise UserError(f"motor {motor}: no record can have the name {record!r}: {WANTED}")
    return names
