# SPDX-License-Identifier: MIT
"""The ideal stepper: no ramps, no mistakes, time by ticks of 20 ms.

The traces were recorded above it, so that its habits are part of what they say.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final

from pixstep.motor_record import MotorCommand, Msta, Status, Verb

TICK_S: Final = 0.02
FAR: Final = 1e9
HOME_WITHIN_STEPS: Final = 0.5


class StepperMotion(Enum):
    """What the motor does."""

    REST = auto()
    TO_TARGET = auto()
    JOG = auto()
    HOME = auto()


@dataclass
class Stepper:
    """One motor, its switches and perhaps an encoder. Positions are steps, not whole ones."""

    ratio: float | None = None
    """Counts of the encoder per step; None: there is no encoder."""
    lo: float = -FAR
    hi: float = FAR
    home: float = 0.0
    slip: float = 0.0
    """Steps that the encoder sees and the motor did not make."""
    comm: float = 0.0
    problem: float = 0.0
    stuck: float = 0.0
    """Not 0: ticks pass and nothing moves."""

    position: float = 0.0
    target: float = 0.0
    speed: float = 0.0
    motion: StepperMotion = StepperMotion.REST
    forwards: bool = True
    status_wanted: bool = False
    _noted: MotorCommand | None = field(default=None, repr=False)

    def obey(self, commands: Sequence[MotorCommand]) -> None:
        """Take commands, in order."""
        for command in commands:
            deed = _DEEDS.get(command.verb)
            if deed is not None:
                deed(self, command)
            self.status_wanted = self.status_wanted or command.verb in _WANT_STATUS

    def turn(self, knob: str, value: float) -> None:
        """Change the motor's world."""
        if knob not in KNOBS:
            raise KeyError(knob)
        setattr(self, knob, value)
        self.status_wanted = True

    def tick(self) -> Status | None:
        """Let one tick pass. Return a status, if the driver of this motor would report one."""
        moved = self.motion is not StepperMotion.REST
        if moved and not self.stuck:
            self._advance()
        if not moved and not self.status_wanted:
            return None
        self.status_wanted = False
        return self.status()

    @property
    def at_rest(self) -> bool:
        """True if the motor rests."""
        return self.motion is StepperMotion.REST

    @property
    def quiet(self) -> bool:
        """True if the motor rests and no status is pending."""
        return self.at_rest and not self.status_wanted

    def status(self) -> Status:
        """Return what the driver would say now."""
        counts = 0
        if self.ratio is not None:
            counts = math.floor((self.position + self.slip) * self.ratio + 0.5)
        return Status(math.floor(self.position + 0.5), counts, self._flags(), self.speed)

    def _flags(self) -> Msta:
        conditions = {
            Msta.DIRECTION: self.forwards,
            Msta.DONE: self.motion is StepperMotion.REST,
            Msta.MOVING: self.motion is not StepperMotion.REST,
            Msta.PLUS_LS: self.position >= self.hi,
            Msta.MINUS_LS: self.position <= self.lo,
            Msta.HOME: abs(self.position - self.home) <= HOME_WITHIN_STEPS,
            Msta.EA_PRESENT: self.ratio is not None,
            Msta.COMM_ERR: bool(self.comm),
            Msta.PROBLEM: bool(self.problem),
        }
        return Msta(sum(flag.value for flag, is_so in conditions.items() if is_so))

    def _advance(self) -> None:
        step = abs(self.speed) * TICK_S
        aim = self._aim()
        if aim is not None and abs(aim - self.position) <= step:
            self._rest_at(aim)
        else:
            self.position += step if self.forwards else -step
        if self.forwards and self.position >= self.hi:
            self._rest_at(self.hi)
        elif not self.forwards and self.position <= self.lo:
            self._rest_at(self.lo)

    def _aim(self) -> float | None:
        """Return where the motor will rest, if it is on its way to such a place."""
        if self.motion is StepperMotion.TO_TARGET:
            return self.target
        ahead = self.home > self.position if self.forwards else self.home < self.position
        return self.home if self.motion is StepperMotion.HOME and ahead else None

    def _rest_at(self, position: float) -> None:
        self.position = position
        self.motion = StepperMotion.REST

    # --- commands ------------------------------------------------------------------------------

    def _note(self, command: MotorCommand) -> None:
        self._noted = command

    def _set_speed(self, command: MotorCommand) -> None:
        self.speed = _given(command)

    def _go(self, _command: MotorCommand) -> None:
        noted = self._noted
        if noted is None:
            return
        if noted.verb in (Verb.HOME_FOR, Verb.HOME_REV):
            self.forwards = noted.verb is Verb.HOME_FOR
            self.motion = StepperMotion.HOME
            return
        way = math.floor(_given(noted) + 0.5)
        self.target = way if noted.verb is Verb.MOVE_ABS else self.position + way
        if self.target != self.position:
            self.forwards = self.target > self.position
        self.motion = StepperMotion.TO_TARGET

    def _jog(self, command: MotorCommand) -> None:
        self.speed = _given(command)
        if self.speed:
            self.forwards = self.speed > 0
        self.motion = StepperMotion.JOG

    def _stop(self, _command: MotorCommand) -> None:
        self._rest_at(math.floor(self.position + 0.5))

    def _load(self, command: MotorCommand) -> None:
        self.position = _given(command)
        self.slip = 0.0


def _given(command: MotorCommand) -> float:
    if command.argument is None:
        raise ValueError(f"{command} has no argument")
    return command.argument


KNOBS: Final = ("lo", "hi", "home", "slip", "comm", "problem", "stuck")
_WANT_STATUS: Final = (Verb.GET_INFO, Verb.GO, Verb.STOP_AXIS, Verb.JOG, Verb.LOAD_POS)
_DEEDS: Final[Mapping[Verb, Callable[[Stepper, MotorCommand], None]]] = {
    Verb.SET_VELOCITY: Stepper._set_speed,
    Verb.MOVE_ABS: Stepper._note,
    Verb.MOVE_REL: Stepper._note,
    Verb.HOME_FOR: Stepper._note,
    Verb.HOME_REV: Stepper._note,
    Verb.GO: Stepper._go,
    Verb.JOG: Stepper._jog,
    Verb.JOG_VELOCITY: Stepper._jog,
    Verb.STOP_AXIS: Stepper._stop,
    Verb.LOAD_POS: Stepper._load,
}
