# SPDX-License-Identifier: MIT
"""An ideal stepper in real time behind the drive of a motor record: what it is asked for, it does.

It makes no ramps. It notes each step with its time, so that a test can tell when it was made.
"""

import contextlib
import math
import threading
import time
from dataclasses import dataclass, field

from pixstep.motor_record import Msta, Status, Verb

TICK_S = 0.005
NO_FAULTS = Msta(0)
REST, TO_TARGET, JOG, HOME = range(4)


@dataclass
class Stepper:
    """The motor: positions are steps, `home` is where its home switch is."""

    position: float = 0.0
    target: float = 0.0
    speed: float = 1000.0
    state: int = REST
    direction: int = 1
    lowest: float = -1e9
    highest: float = 1e9
    home: float = 0.0
    faults: Msta = NO_FAULTS
    edges: list[tuple[float, int]] = field(default_factory=list)

    @property
    def steps(self) -> int:
        """The position in whole steps."""
        return math.floor(self.position + 0.5)

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        before = self.steps
        if self.state != REST:
            self._move(self.speed * seconds)
        if self.steps != before:
            self.edges.append((time.time(), self.steps))

    def _move(self, distance: float) -> None:
        position = self.position + self.direction * distance
        if self.state == TO_TARGET and abs(self.target - self.position) <= distance:
            position, self.state = self.target, REST
        if (
            self.state == HOME
            and min(self.position, position) <= self.home <= max(self.position, position)
            and self.position != self.home
        ):
            position, self.state = self.home, REST
        if self.direction > 0 and position >= self.highest:
            position, self.state = self.highest, REST
        if self.direction < 0 and position <= self.lowest:
            position, self.state = self.lowest, REST
        self.position = position

    def status(self) -> Status:
        """Return the status as a driver reports it."""
        flags = self.faults
        flags |= Msta.DIRECTION if self.direction > 0 else Msta(0)
        flags |= Msta.DONE if self.state == REST else Msta.MOVING
        flags |= Msta.PLUS_LS if self.position >= self.highest else Msta(0)
        flags |= Msta.MINUS_LS if self.position <= self.lowest else Msta(0)
        flags |= Msta.HOME if abs(self.position - self.home) < 0.5 else Msta(0)
        speed = 0.0 if self.state == REST else self.speed
        return Status(self.steps, 0, flags, speed)


class IdealDrive:
    """The drive of one stepper."""

    problem = ""
    stopped_elsewhere = False

    def __init__(self, stepper: Stepper | None = None) -> None:
        self.motor = stepper or Stepper()
        self.is_closed = False
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._wants_status = False
        self._orders = 0
        self.offset_steps = 0
        self._reported: dict[int, int] = {}
        self._noted: tuple[int, float] = (REST, 0.0)
        self._report = None
        self._thread = threading.Thread(target=self._run, daemon=True)

    def connect(self, on_status):
        """Begin to report."""
        self._report = on_status
        self._thread.start()

    def obey(self, commands, second_leg=()):
        """Take commands."""
        del second_leg
        with self._lock:
            self._orders += 1
            for command in commands:
                self._obey(command.verb, command.argument)

    def overtaken(self, status):
        """Whether a status is older than the newest commands."""
        with self._lock:
            return self._reported.pop(id(status), self._orders) < self._orders

    def add_offset(self, steps):
        """Count from elsewhere."""
        with self._lock:
            self.offset_steps += steps
            self.motor.position += steps
            self.motor.target += steps

    def close(self):
        """Stop the motor and leave."""
        self._over.set()
        with self._lock:
            self.motor.state, self.is_closed = REST, True

    def set(self, **values):
        """Change the world: limits, faults, the home switch."""
        with self._lock:
            for name, value in values.items():
                setattr(self.motor, name, value)
            self._wants_status = True

    def _obey(self, verb, argument):
        motor = self.motor
        if verb is Verb.SET_VELOCITY:
            motor.speed = argument
            return
        if verb in (Verb.SET_VEL_BASE, Verb.SET_ACCEL):
            return
        if verb is Verb.MOVE_ABS:
            self._noted = (TO_TARGET, math.floor(argument + 0.5))
            return
        if verb is Verb.MOVE_REL:
            self._noted = (TO_TARGET, math.floor(motor.position + argument + 0.5))
            return
        if verb in (Verb.HOME_FOR, Verb.HOME_REV):
            self._noted = (HOME, 1 if verb is Verb.HOME_FOR else -1)
            return
        self._wants_status = True
        self._at_once(verb, argument)

    def _at_once(self, verb, argument):
        motor = self.motor
        if verb is Verb.GO:
            motor.state, value = self._noted
            if motor.state == TO_TARGET:
                motor.target = value
                if value != motor.position:
                    motor.direction = 1 if value > motor.position else -1
            else:
                motor.direction = int(value)
        elif verb in (Verb.JOG, Verb.JOG_VELOCITY):
            motor.state, motor.speed = JOG, abs(argument)
            motor.direction = 1 if argument >= 0 else -1
        elif verb is Verb.STOP_AXIS:
            motor.state, motor.position = REST, motor.steps
        elif verb is Verb.LOAD_POS:
            self.offset_steps += math.floor(argument + 0.5) - motor.steps
            motor.position = argument

    def _run(self):
        last_s = time.monotonic()
        while not self._over.wait(TICK_S):
            now_s = time.monotonic()
            with self._lock:
                moved = self.motor.state != REST
                self.motor.advance(now_s - last_s)
                tells = moved or self._wants_status
                self._wants_status = False
                status = self.motor.status()
                if tells:
                    self._reported[id(status)] = self._orders
            last_s = now_s
            if tells:
                with contextlib.suppress(RuntimeError):
                    self._report(status)
