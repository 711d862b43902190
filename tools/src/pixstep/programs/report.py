# SPDX-License-Identifier: MIT
"""What is known of a plan: time, peaks, ratios to the limits, slowed moves, violations."""

from collections import Counter, deque
from dataclasses import dataclass, field

import numpy as np

from pixstep.programs.blends import Timed
from pixstep.programs.motors import (
    PLAIN_ROUNDING,
    SMOOTH_ROUNDING,
    PlanMotor,
    Setup,
)
from pixstep.programs.pixels import Counts
from pixstep.programs.timelaw import Limits
from pixstep.programs.timeline import Timeline
from pixstep.programs.twomoves import Violation

MOST_LISTED = 1000
_AT_LIMIT = 0.99
_SAME_MS = 1e-6
_SLOWER = 1.001  # as programmed, but for the last digits


@dataclass(frozen=True)
class Slowed:
    """A move that takes longer than programmed, or whose blend does, and why."""

    line: int
    asked_ms: float
    ms: float
    why: str


@dataclass
class MotorReport:
    """What a motor does. Planned figures are before, counted ones after rounding to whole steps."""

    motor: PlanMotor
    pixel_ms: float
    keeps_jerk: bool = False
    steps: int = 0
    travel: int = 0
    planned_speed: float = 0.0
    planned_acceleration: float = 0.0
    planned_jerk: float = 0.0  # steps/px3, known if a limit of the jerk is kept
    counted_speed: int = 0  # steps/px
    counted_acceleration: int = 0  # steps/px2
    counted_jerk: int = 0  # steps/px3: the acceleration's change from pixel to pixel
    last: int = 0
    speed: int = 0
    acceleration: int = 0

    @property
    def limit(self) -> float:
        """The acceleration limit in steps/px2."""
        return self.motor.max_acceleration * self.pixel_ms**2

    @property
    def allowed(self) -> float:
        """What whole steps may make of the limit, steps/px2."""
        return self.limit + (0 if self.motor.smooth else PLAIN_ROUNDING)

    @property
    def planned_ratio(self) -> float:
        """Planned acceleration over the limit."""
        return self.planned_acceleration / self.motor.max_acceleration

    @property
    def counted_ratio(self) -> float:
        """Counted acceleration over the limit and what whole steps may add."""
        return self.counted_acceleration / self.allowed

    @property
    def speed_ratio(self) -> float:
        """Planned speed over the limit."""
        return self.planned_speed / self.motor.max_speed

    @property
    def jerk_limit(self) -> float | None:
        """The limit of the jerk that the plan keeps, steps/px3; None if it keeps none."""
        return self.motor.max_jerk if self.keeps_jerk else None

    @property
    def allowed_jerk(self) -> float | None:
        """What whole steps may make of it."""
        limit = self.jerk_limit
        return None if limit is None else limit + self.motor.jerk_rounding

    @property
    def unused_limits(self) -> list[str]:
        """The limits of the machine file that the plan does not use."""
        kept = [] if self.jerk_limit is None else ["max_jerk"]
        return [limit for limit in self.motor.unused_limits if limit not in kept]

    def add(self, counts: np.ndarray) -> None:
        """Take the counts of some pixels."""
        if not len(counts):
            return
        self.steps += int(counts.sum())
        self.travel += int(np.abs(counts).sum())
        if self.motor.smooth:
            self._add_smooth(np.abs(counts).tolist())
            return
        self.counted_speed = max(self.counted_speed, int(np.abs(counts).max()))
        self._add_accelerations(np.diff(counts, prepend=self.last))
        self.last = int(counts[-1])

    def _add_smooth(self, counts: list[int]) -> None:
        speeds = [self.speed]
        for count in counts:
            speeds.append(2 * count - speeds[-1])
        self._add_accelerations(np.diff(speeds))
        self.counted_speed = max(self.counted_speed, *speeds)
        self.speed = speeds[-1]

    def _add_accelerations(self, changes: np.ndarray) -> None:
        jerk = np.diff(changes, prepend=self.acceleration)
        self.counted_acceleration = max(self.counted_acceleration, int(np.abs(changes).max()))
        self.counted_jerk = max(self.counted_jerk, int(np.abs(jerk).max()))
        self.acceleration = int(changes[-1])

    def as_json(self) -> dict:
        """Return it as plain data."""
        motor, pixel = self.motor, self.pixel_ms
        return {
            "name": motor.name,
            "word": motor.word,
            "kind": "smooth" if motor.smooth else "plain",
            "steps": self.steps,
            "travel_steps": self.travel,
            "max_speed_counts_ms": motor.max_speed,
            "max_acceleration_counts_ms2": motor.max_acceleration,
            "max_acceleration_steps_px2": self.limit,
            "planned_speed_counts_ms": self.planned_speed,
            "planned_acceleration_counts_ms2": self.planned_acceleration,
            "speed_ratio": self.speed_ratio,
            "acceleration_ratio": self.planned_ratio,
            "counted_speed_steps_px": self.counted_speed,
            "counted_speed_counts_ms": self.counted_speed / pixel,
            "counted_acceleration_steps_px2": self.counted_acceleration,
            "rounding_steps_px2": SMOOTH_ROUNDING if motor.smooth else PLAIN_ROUNDING,
            "counted_ratio": self.counted_ratio,
            "counted_jerk_steps_px3": self.counted_jerk,
            "max_jerk_steps_px3": motor.max_jerk,
            "planned_jerk_steps_px3": self.planned_jerk if self.keeps_jerk else None,
            "jerk_ratio": self.planned_jerk / self.jerk_limit if self.jerk_limit else None,
            "allowed_jerk_steps_px3": self.allowed_jerk,
            "unused_limits": self.unused_limits,
        }


@dataclass
class Report:
    """What is known of a plan; complete when its last count is made."""

    setup: Setup
    limits: Limits
    motors: list[MotorReport]
    moves: int = 0
    pixels: int = 0
    total_ms: float = 0.0
    asked_ms: float = 0.0
    slowed: list[Slowed] = field(default_factory=list)
    slowed_moves: int = 0
    reasons: Counter = field(default_factory=Counter)
    violations: list[Violation] = field(default_factory=list)
    violated: int = 0
    begun: deque[Timed] = field(default_factory=deque)

    @classmethod
    def of(cls, setup: Setup, *, keeps_jerk: bool = False) -> "Report":
        """Return the report of a plan that has not begun."""
        motors = [MotorReport(motor, setup.pixel_ms, keeps_jerk) for motor in setup.motors]
        return cls(setup, Limits.of(setup), motors)

    @property
    def keeps_jerk(self) -> bool:
        """Whether the plan keeps limits of the jerk."""
        return any(motor.jerk_limit is not None for motor in self.motors)

    def add_jerks(self, jerks: np.ndarray) -> None:
        """Take the planned jerks of some pixels, steps/px3, a column for each motor."""
        for index, motor in enumerate(self.motors):
            motor.planned_jerk = max(motor.planned_jerk, float(np.abs(jerks[:, index]).max()))

    @property
    def whole(self) -> bool:
        """True if no limit is exceeded."""
        return not self.violated

    def add_time(self, line: Timeline) -> None:
        """Take a part of the plan in time."""
        speed = np.maximum(*(np.abs(one) for one in line.speeds()))
        acceleration = np.maximum(*(np.abs(one) for one in line.accelerations()))
        for index, motor in enumerate(self.motors):
            motor.planned_speed = max(motor.planned_speed, float(speed[:, index].max()))
            motor.planned_acceleration = max(
                motor.planned_acceleration, float(acceleration[:, index].max())
            )
        self.total_ms = line.end
        self._note_moves(line, speed / self.limits.speed, acceleration / self.limits.acceleration)

    def _note_moves(self, line: Timeline, speed: np.ndarray, acceleration: np.ndarray) -> None:
        """Note which moves take longer than programmed, and what keeps them."""
        moving = np.flatnonzero(~line.path.rest)
        if not len(moving):
            return
        move = line.path.move[moving]
        starts = np.flatnonzero(np.diff(move, prepend=move[0] - 1))
        ms = np.add.reduceat(line.ms[moving], starts)
        ratios = np.hstack([speed, acceleration])[moving]
        worst = np.maximum.reduceat(ratios, starts, axis=0)
        asked = np.add.reduceat(line.path.du[moving], starts)
        for time, own, ratio in zip(ms.tolist(), asked.tolist(), worst, strict=True):
            move_begun = self.begun.popleft()
            self.moves += 1
            self.asked_ms += move_begun.asked
            time += move_begun.tm - own  # neighbours share the time of a blend
            if move_begun.why or time > move_begun.asked * _SLOWER + _SAME_MS:
                self._slow(move_begun, time, ratio)

    def _slow(self, move: Timed, ms: float, ratio: np.ndarray) -> None:
        self.slowed_moves += 1
        why = move.why or self._reason(ratio)
        self.reasons[why] += 1
        if len(self.slowed) < MOST_LISTED:
            self.slowed.append(Slowed(move.line, move.asked, ms, why))

    def _reason(self, ratio: np.ndarray) -> str:
        """Return what is nearest to its limit in a move."""
        count = len(self.motors)
        index = int(np.argmax(ratio))
        if ratio[index] < _AT_LIMIT:
            return "jerk" if self.keeps_jerk else "path"
        what = "speed" if index < count else "acceleration"
        return f"{what} of {self.motors[index % count].motor.name}"

    def add_counts(self, counts: Counts) -> None:
        """Take the counts of some pixels."""
        self.pixels += len(counts)
        for index, motor in enumerate(self.motors):
            motor.add(counts[:, index])

    def as_json(self) -> dict:
        """Return everything as plain data."""
        return {
            "moves": self.moves,
            "pixels": self.pixels,
            "pixel_hz": str(self.setup.pixel_hz),
            "divider": self.setup.divider,
            "sync": self.setup.sync,
            "total_ms": self.total_ms,
            "programmed_ms": self.asked_ms,
            "motors": [motor.as_json() for motor in self.motors],
            "slowed_moves": self.slowed_moves,
            "reasons": dict(self.reasons.most_common()),
            "slowed": [vars(item) for item in self.slowed],
            "violated": self.violated,
            "violations": [item._asdict() for item in self.violations],
        }
