# SPDX-License-Identifier: MIT
"""From a record's command to the motion that an axis can make.

The motors of a machine file as drives know them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pixstep.board.errors import BoardError
from pixstep.machine.describe import limit_per_second
from pixstep.machine.model import MachineTables, MotorTable
from pixstep.motor_drive.homing import Home
from pixstep.motor_drive.motions import (
    DrivenMotion,
    DrivenMove,
    Jog,
    MotionLeg,
    PixelLimits,
    second_of,
)
from pixstep.motor_drive.watch import AxisLook, BoardWatch
from pixstep.motor_record.traffic import MotorCommand, Verb, whole
from pixstep.moves.fast import MAX_STEPS
from pixstep.moves.trapezoid import MoveKinematics


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


@dataclass(frozen=True)
class DrivenMotor:
    """A motor: its name, its place, and the limits that its machine has for it, if any.

    A leg of a homing gives up after `search_steps`.
    """

    name: str
    unit: int
    axis: int
    max_speed_steps_s: float | None = None
    max_acceleration_steps_s2: float | None = None
    search_steps: int = 1_000_000


@dataclass(frozen=True)
class MotionStart:
    """A motion that is to begin: MOVE_ABS, JOG or a homing, and what is to follow it."""

    command: MotorCommand
    announced: tuple[MotorCommand, ...] = ()


class Starting:
    """Makes motions by what the board and its motor can do."""

    def __init__(self, watch: BoardWatch, motor: DrivenMotor) -> None:
        self._watch, self._motor = watch, motor

    def motion(
        self, start: MotionStart, axis: AxisLook, offset_steps: int, wanted: MoveKinematics
    ) -> DrivenMotion | None:
        """Return the motion of an axis at rest; None for one of no steps, or against its switch.

        Raises BoardError for a motion that cannot be.
        """
        verb, value = start.command.verb, start.command.argument or 0.0
        if verb is Verb.JOG:
            direction = (value > 0) - (value < 0)
            if not direction or at_limit(axis, direction):
                return None
            return Jog(value, self.limited(replace(wanted, speed_steps_s=abs(value))), self.pixels)
        if not wanted.speed_steps_s > 0:
            raise BoardError("a motion at a speed of 0 does not end")
        if verb is not Verb.MOVE_ABS:
            return Home(1 if verb is Verb.HOME_FOR else -1)
        return self._move(start, axis, offset_steps, wanted)

    @property
    def pixels(self) -> PixelLimits:
        """What the board's pixels allow."""
        watch = self._watch
        return PixelLimits(
            watch.pixel_hz, watch.top_steps_px, watch.turns_below_steps_px, watch.rest_px
        )

    def limited(self, wanted: MoveKinematics) -> MoveKinematics:
        """Return what board and motor can do of kinematics."""
        most = self._motor.max_speed_steps_s or wanted.speed_steps_s
        wanted = replace(wanted, speed_steps_s=min(wanted.speed_steps_s, most))
        watch = self._watch
        return wanted.within(
            watch.top_steps_px, watch.pixel_hz, self._motor.max_acceleration_steps_s2
        )

    def _move(
        self, start: MotionStart, axis: AxisLook, offset_steps: int, wanted: MoveKinematics
    ) -> DrivenMove | None:
        here, target = axis.position_steps + offset_steps, whole(start.command.argument)
        if abs(target - offset_steps) > MAX_STEPS:
            raise BoardError(f"a target of {target} steps: a board counts to {MAX_STEPS}")
        if target == here or at_limit(axis, target - here):
            return None
        second = second_of(start.announced, wanted, target)
        if second is not None and second.target_steps == target:
            second = None
        if second is not None:
            second = MotionLeg(self.limited(second.kinematics), second.target_steps)
        first = MotionLeg(self.limited(wanted), target)
        return DrivenMove(here, first, second, start.announced, self.pixels)


def at_limit(axis: AxisLook, direction: int) -> bool:
    """Whether the limit switch in a direction is tripped."""
    return axis.switches.limit_plus if direction > 0 else axis.switches.limit_minus
