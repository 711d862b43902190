# SPDX-License-Identifier: MIT
"""What is known of a plan: time, peaks, ratios to the limits, slowed moves, violations."""

from collections import Counter, deque
from dataclasses import dataclass, field

import numpy as np

from pixstep.profiles.ramps import decoded
from pixstep.programs.blends import Timed
from pixstep.programs.motors import (
    PLAIN_ROUNDING,
    SMOOTH_ROUNDING,
    PlanMotor,
    Setup,
)
from pixstep.programs.pixels import Counts, Timeline
from pixstep.programs.plan_data import ExceededLimit, MotorFigures, PlanFigures, SlowedMove
from pixstep.programs.time_law import MotorLimits

MOST_LISTED = 1000
_AT_LIMIT = 0.99
_SAME_MS = 1e-6
_SLOWER = 1.001  # as programmed, but for the last digits


@dataclass
class _MoveTime:
    """A move's time as programmed and as planned; `why` is that of the part that loses the most."""

    line: int
    asked: float = 0.0
    ms: float = 0.0
    why: str = ""
    _lost: float = 0.0

    def add(self, asked: float, ms: float, why: str) -> None:
        """Add a segment, or all of a move that has none."""
        self.asked += asked
        self.ms += ms
        if ms - asked > self._lost:
            self._lost, self.why = ms - asked, why


@dataclass
class _Begun:
    """A move whose time is not known yet; `first` begins at rest, `last` ends so."""

    move: Timed
    first: bool
    last: bool = False

    def shared(self, following: "_Begun | None") -> float:
        """What its blends add to its own intervals, which have the one before and not the next.

        Of a start and a stop their programmed half acceleration times are none of its own.
        """
        move = self.move
        before = 0.0 if self.first else move.ta / 2
        behind = 0.0 if self.last or following is None else following.move.ta / 2
        return behind - before - (self.first + self.last) * move.asked_ta / 2


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
            self._add_smooth(tuple(np.abs(counts).tolist()))
            return
        self.counted_speed = max(self.counted_speed, int(np.abs(counts).max()))
        self._add_accelerations(np.diff(counts, prepend=self.last))
        self.last = int(counts[-1])

    def _add_smooth(self, counts: tuple[int, ...]) -> None:
        speeds = [self.speed, *decoded(self.speed, counts)]
        self._add_accelerations(np.diff(speeds))
        self.counted_speed = max(self.counted_speed, *speeds)
        self.speed = speeds[-1]

    def _add_accelerations(self, changes: np.ndarray) -> None:
        jerk = np.diff(changes, prepend=self.acceleration)
        self.counted_acceleration = max(self.counted_acceleration, int(np.abs(changes).max()))
        self.counted_jerk = max(self.counted_jerk, int(np.abs(jerk).max()))
        self.acceleration = int(changes[-1])

    def as_json(self) -> MotorFigures:
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
    """What is known of a plan; complete when its last count is made.

    `arc_off_steps` is how far an arc leaves its circle at most because its numbers are rounded, in
    steps of the finer motor.
    """

    setup: Setup
    limits: MotorLimits
    motors: list[MotorReport]
    moves: int = 0
    pixels: int = 0
    total_ms: float = 0.0
    moves_ms: float = 0.0  # as programmed
    stops_ms: float = 0.0  # half an acceleration time for each start and each stop
    dwells_ms: float = 0.0
    off_path: float = 0.0  # steps: positions at pixel edges from the path, at most
    slowed: list[SlowedMove] = field(default_factory=list)
    slowed_moves: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    violations: list[ExceededLimit] = field(default_factory=list)
    violated: int = 0
    clipped: int = 0  # blends that rule 3 shortens
    arc_off_steps: float = 0.0
    _begun: deque[_Begun] = field(default_factory=deque)
    _moving: _Begun | None = None
    _noted: "_MoveTime | None" = None  # the move of which parts are known

    @classmethod
    def of(cls, setup: Setup, *, keeps_jerk: bool = False) -> "Report":
        """Return the report of a plan that has not begun."""
        motors = [MotorReport(motor, setup.pixel_ms, keeps_jerk) for motor in setup.motors]
        return cls(setup, MotorLimits.of(setup), motors)

    @property
    def keeps_jerk(self) -> bool:
        """Whether the plan keeps limits of the jerk."""
        return any(motor.jerk_limit is not None for motor in self.motors)

    @property
    def ways(self) -> list[int]:
        """The direction in which each motor moves on the whole: all that a smooth one does."""
        return [(motor.steps > 0) - (motor.steps < 0) for motor in self.motors]

    @property
    def programmed_ms(self) -> float:
        """The time of the program without limits and without its rules."""
        return self.moves_ms + self.stops_ms + self.dwells_ms

    def add_move(self, move: Timed) -> None:
        """Take a move, or a circle's segment, before it is planned."""
        self._moving = _Begun(move, first=self._moving is None)
        self._begun.append(self._moving)
        self.moves_ms += move.asked
        self.clipped += move.clipped and move.segment == 0
        if self._moving.first:
            self.stops_ms += move.asked_ta / 2

    def add_stop(self, dwell_ms: float = 0.0) -> None:
        """Take the end of a move, and how long the motors are to rest then."""
        self.dwells_ms += dwell_ms
        if self._moving is not None:
            self._moving.last = True
            self.stops_ms += self._moving.move.asked_ta / 2
        self._moving = None

    @property
    def waiting(self) -> int:
        """Moves whose time is not known yet."""
        return len(self._begun)

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
        tops = speed.max(axis=0).tolist(), acceleration.max(axis=0).tolist()
        for motor, fastest, most in zip(self.motors, *tops, strict=True):
            motor.planned_speed = max(motor.planned_speed, fastest)
            motor.planned_acceleration = max(motor.planned_acceleration, most)
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
        for time, ratio in zip(ms.tolist(), worst, strict=True):
            begun = self._begun.popleft()
            if begun.move.segment == 0:
                self.note_move()
                self._noted = _MoveTime(begun.move.line)
            assert self._noted is not None  # a circle has a first segment
            time += begun.shared(self._begun[0] if self._begun else None)
            self._noted.add(begun.move.asked, time, begun.move.why or self._reason(ratio))

    def note_move(self) -> None:
        """Note the move whose parts are all known: the last one at the plan's end."""
        move, self._noted = self._noted, None
        if move is None:
            return
        self.moves += 1
        if move.ms <= move.asked * _SLOWER + _SAME_MS:
            return
        self.slowed_moves += 1
        self.reasons[move.why] += 1
        if len(self.slowed) < MOST_LISTED:
            self.slowed.append(
                {"line": move.line, "asked_ms": move.asked, "ms": move.ms, "why": move.why}
            )

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

    def as_json(self) -> PlanFigures:
        """Return everything as plain data."""
        return {
            "moves": self.moves,
            "pixels": self.pixels,
            "pixel_hz": str(self.setup.pixel_hz),
            "divider": self.setup.divider,
            "sync": self.setup.sync,
            "total_ms": self.total_ms,
            "programmed_ms": self.programmed_ms,
            "moves_ms": self.moves_ms,
            "stops_ms": self.stops_ms,
            "dwells_ms": self.dwells_ms,
            "off_path_steps": self.off_path,
            "motors": [motor.as_json() for motor in self.motors],
            "slowed_moves": self.slowed_moves,
            "clipped_blends": self.clipped,
            "reasons": dict(self.reasons.most_common()),
            "slowed": self.slowed,
            "arc_off_steps": self.arc_off_steps,
            "violated": self.violated,
            "violations": self.violations,
        }
