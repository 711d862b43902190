# SPDX-License-Identifier: MIT
"""The motors of a machine file as drives know them."""

from __future__ import annotations

from collections.abc import Mapping

from pixstep.machine.describe import limit_per_second
from pixstep.machine.model import MachineTables, MotorTable
from pixstep.motor_drive.starting import DrivenMotor


def motors_of(machine: MachineTables, units: Mapping[str, int]) -> list[DrivenMotor]:
    """Return the motors of some boards; `units` are the boards' addresses by name.

    Positions and directions of drives are the motor's, as the board counts them: `direction` of the
    machine file is left to the record's DIR or to the sign of its MRES.
    """
    return [
        _motor(machine, motor, units[machine.board_name(motor)])
        for motor in machine.motors.values()
        if machine.board_name(motor) in units
    ]


def _motor(machine: MachineTables, motor: MotorTable, unit: int) -> DrivenMotor:
    def limit(key: str) -> float | None:
        found = limit_per_second(motor, key, machine.pixel_hz)
        return None if found is None else float(found)

    return DrivenMotor(
        motor.name,
        unit,
        motor.axis,
        max_speed_steps_s=limit("max_speed"),
        max_acceleration_steps_s2=limit("max_acceleration"),
    )
