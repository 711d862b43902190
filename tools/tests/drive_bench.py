# SPDX-License-Identifier: MIT
"""Drives of motors on simulated boards, and what they report; a motor record above one of them."""

import threading
from contextlib import contextmanager

import pixstep as px
from pixstep.motor_drive import BusDrives, DrivenMotor
from pixstep.motor_record import MotorRecord
from pixstep.motor_record.traffic import MotorCommand, Msta, Verb
from pixstep.simulation.logs import read_edges

NEAR_S = 1e-6  # simulated time passes in cycles


def speeds(speed, base=100, acceleration=20_000):
    """Return the commands with which a record sets its speeds, steps/s and steps/s2."""
    return (
        MotorCommand(Verb.SET_VELOCITY, speed),
        MotorCommand(Verb.SET_VEL_BASE, base),
        MotorCommand(Verb.SET_ACCEL, acceleration),
    )


def move(target, speed=4000, base=100, acceleration=20_000, *, verb=Verb.MOVE_ABS):
    """Return the commands of a move."""
    return (*speeds(speed, base, acceleration), MotorCommand(verb, target), MotorCommand(Verb.GO))


def home(verb, speed=2000):
    """Return the commands of a homing."""
    return (*speeds(speed), MotorCommand(verb), MotorCommand(Verb.GO))


def jog(velocity, base=100, acceleration=5000):
    """Return the commands of a jog."""
    return (*speeds(abs(velocity), base, acceleration)[1:], MotorCommand(Verb.JOG, velocity))


STOP = (MotorCommand(Verb.STOP_AXIS),)


class Watched:
    """A drive and the statuses that it has reported; `edges` counts the steps at the pins."""

    def __init__(self, bus, drive, count):
        self.bus, self.drive, self.edges = bus, drive, count
        self.seen, self.times = [], []
        drive.connect(self._on_status)

    def _on_status(self, status):
        self.seen.append(status)
        self.times.append(self.bus.time_s)

    @property
    def last(self):
        return self.seen[-1]

    @property
    def rests(self):
        return bool(self.seen) and Msta.DONE in self.last.flags

    def obey(self, commands, second_leg=()):
        """Give commands, and forget what was seen before."""
        self.seen.clear()
        self.times.clear()
        self.drive.obey(commands, second_leg)

    def settle(self, limit_s=60.0, slice_s=0.01):
        """Let time pass until a status says that the motor rests; return it."""
        end_s = self.bus.time_s + limit_s
        while not self.rests:
            assert self.bus.time_s < end_s, (self.seen[-3:], self.drive.problem)
            self.bus.let_pass(slice_s)
        return self.last

    def flags(self):
        """Return the flags of the last status without the direction."""
        return self.last.flags & ~Msta.DIRECTION


@contextmanager
def driven(kinds, axes, *, pixel_hz=30, edges=None, plants=None, **more):
    """Yield a bus of simulated boards, its drives, and them watched, by name "unit.axis"."""
    with px.simulated_bus(kinds, pixel_hz=pixel_hz, edges=edges, plants=plants) as bus:
        motors = [DrivenMotor(f"{unit}.{axis}", unit, axis, **more) for unit, axis in axes]
        with BusDrives(bus.link, motors) as drives:
            watched = {
                motor.name: Watched(bus, drives[motor.name], counter(bus, motor))
                for motor in motors
            }
            bus.let_pass(0.6)
            yield bus, drives, watched
        assert drives.failure is None


def counter(bus, motor):
    """Return what counts the steps at the pins of a motor."""
    return lambda: bus.made_steps(motor.unit, motor.axis)


def rising_s(path, board=0, axis=0, tick_hz=16_000_000):
    """Return the times of the STEP edges of an axis."""
    return read_edges(path).axis(board, axis).rising / tick_hz


class RecordAbove:
    """A motor record above a drive, as an IOC has it; `dmov` are the values of DMOV posted."""

    def __init__(self, bus, drive, count, fields):
        self.bus, self.drive, self.edges = bus, drive, count
        self.record, self.lock = MotorRecord(fields), threading.RLock()
        self.ready = False
        self.dmov, self.movn, self.asked, self.at_done = [], [], [], None
        self._delays = []
        drive.connect(self._on_status)

    def _on_status(self, status):
        with self.lock:
            if self.drive.overtaken(status):
                return
            take = self.record.update if self.ready else self.record.initialise
            self.ready = True
            self._carry(take(status))

    def _carry(self, outcome):
        for post in outcome.posts:
            if post.field == "DMOV":
                self.dmov.append(post.value)
                self.at_done = self.edges() if post.value else None
            if post.field == "MOVN":
                self.movn.append(post.value)
        if outcome.delay_s is not None:
            self._delays.append(self.bus.time_s + outcome.delay_s)
        self.asked += outcome.commands
        self.drive.obey(outcome.commands, outcome.second_leg)

    def put(self, field, value):
        """Write a field as a client does."""
        with self.lock:
            self._carry(self.record.put(field, value))

    def let_pass(self, seconds):
        """Let time pass, and delays end."""
        end_s = self.bus.time_s + seconds
        while self.bus.time_s < end_s - NEAR_S:
            self.bus.let_pass(min(0.02, end_s - self.bus.time_s))
            if self._delays and self._delays[0] <= self.bus.time_s:
                self._delays.pop(0)
                with self.lock:
                    self._carry(self.record.delay_over())

    def settle(self, limit_s=60.0):
        """Let time pass until DMOV is 1."""
        end_s = self.bus.time_s + limit_s
        while not (self.ready and self.record["DMOV"]):
            assert self.bus.time_s < end_s, (self.asked[-5:], self.drive.problem)
            self.let_pass(0.02)

    def clear(self):
        """Forget what was posted and asked."""
        self.dmov.clear()
        self.movn.clear()
        self.asked.clear()
