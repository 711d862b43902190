# SPDX-License-Identifier: MIT
"""A record above the ideal stepper: writes, ticks and delays go in, what both did is noted."""

from dataclasses import dataclass, field
from typing import Final

from pixstep.motor_record import FIELDS, MotorCommand, MotorRecord, Outcome, PutRefusedError
from pixstep_trials.motor_traces.stepper import Stepper

SETTLE_TICKS: Final = 3000
QUIET_TICKS: Final = 3


@dataclass
class TraceBench:
    """One record above one stepper, and what was seen of them since the last look."""

    record: MotorRecord
    stepper: Stepper
    commands: list[MotorCommand] = field(default_factory=list)
    dmov: list[int] = field(default_factory=list)
    """Values of DMOV that were posted."""
    delay_s: float | None = None
    """The delay that runs."""
    delays: int = 0
    """How many delays have begun."""
    late: list[MotorCommand] = field(default_factory=list)
    """Asked for when a delay of 0 s ended: a recording has that or not, it was a race."""

    def take(self, outcome: Outcome) -> Outcome:
        """Carry out what the record asks for."""
        self.commands.extend(outcome.commands)
        self.dmov.extend(int(post.value) for post in outcome.posts if post.field == "DMOV")
        self.stepper.obey(outcome.commands)
        if outcome.delay_s is not None:
            self.delay_s = outcome.delay_s
            self.delays += 1
        return outcome

    def put(self, name: str, value: float | str) -> Outcome | None:
        """Write as a client does; None if the record does not take that."""
        try:
            return self.take(self.record.put(name, value))
        except PutRefusedError:
            return None

    def put_as_recorded(self, name: str, value: float | str) -> None:
        """Write, and let the record read a pending status as it processes, as the real one does."""
        pending = self.stepper.status() if self.stepper.status_wanted else None
        try:
            outcome = self.record.put(name, value, pending)
        except PutRefusedError:
            return
        if FIELDS[name].processes:
            self.stepper.status_wanted = False
        self.take(outcome)

    def tick(self) -> Outcome | None:
        """Let 20 ms of the motor's time pass."""
        status = self.stepper.tick()
        return None if status is None else self.take(self.record.update(status))

    def ticks(self, count: int) -> None:
        """Let some ticks pass."""
        for _ in range(count):
            self.tick()

    def end_delay(self) -> None:
        """Let the delay be over, if one runs."""
        if self.delay_s is not None:
            self.delay_s = None
            self.take(self.record.delay_over())

    def end_zero_delay(self) -> None:
        """Let a delay of 0 s be over: that is after the step which began it."""
        self.late = []
        if self.delay_s == 0:
            begun = len(self.commands)
            self.end_delay()
            self.late = self.commands[begun:]
            del self.commands[begun:]

    def settle(self) -> tuple[int, bool]:
        """Let time pass until all is at rest. Return the ticks, and whether that came."""
        quiet = 0
        for ticks in range(1, SETTLE_TICKS + 1):
            if self.stepper.at_rest and not self.record["DMOV"]:
                self.end_delay()  # more real time than that passes before the next tick
            self.tick()
            quiet = quiet + 1 if self.record["DMOV"] and self.stepper.quiet else 0
            if quiet == QUIET_TICKS:
                return ticks, True
        return SETTLE_TICKS, False

    def forget(self) -> None:
        """Begin a new look."""
        self.commands, self.dmov = [], []
