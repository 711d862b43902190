# SPDX-License-Identifier: MIT
"""The motors of a machine file as drives know them."""

from __future__ import annotations

from pixstep.machine.describe import limit_per_second
from pixstep.machine.model import MachineTables, MotorTable
from pixstep.motor_drive.starting import DrivenMotor


def motors_of(machine: MachineTables, port: str | None = None) -> list[DrivenMotor]:
    """Return the motors whose boards are on a port; those of all boards if it is None.

    Positions and directions of drives are the motor's, as the board counts them: `direction` of the
    machine file is left to the record's DIR or to the sign of its MRES.
    """
    return [
        _motor(machine, motor)
        for motor in machine.motors.values()
        if port is None or machine.board_of(motor).port == port
    ]


def _motor(machine: MachineTables, motor: MotorTable) -> DrivenMotor:
    def limit(key: str) -> float | None:
        found = limit_per_second(motor, key, machine.pixel_hz)
        return None if found is None else float(found)

    return DrivenMotor(
        motor.name,
        machine.board_of(motor).unit,
        motor.axis,
        max_speed_steps_s=limit("max_speed"),
        max_acceleration_steps_s2=limit("max_acceleration"),
    )
