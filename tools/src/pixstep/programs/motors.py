# SPDX-License-Identifier: MIT
"""The motors of a program as the planner sees them: counts and milliseconds."""

from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.board import capability, settings
from pixstep.errors import RefusedError
from pixstep.lines.line_check import WHOLE_STEPS_PX2
from pixstep.machine.model import MachineTables, MotorTable
from pixstep.programs.language import AXIS_WORDS

SMOOTH_ROUNDING = 4  # steps/px2 that whole steps add to a smooth motor's planned acceleration
PLAIN_ROUNDING = WHOLE_STEPS_PX2  # and to a plain motor's
SMOOTH_SPEED_ROUNDING = 2  # steps/px
SMOOTH_JERK_ROUNDING = 8  # steps/px3 that whole steps add to a smooth motor's planned jerk
PLAIN_JERK_ROUNDING = 4  # and to a plain motor's
UNUSED_LIMITS = ("max_jerk", "start_stop")  # of a machine file: TA and TS form the acceleration
_LEAST_SMOOTH = SMOOTH_ROUNDING
MS = 1000


@dataclass(frozen=True)
class PlanMotor:
    """A motor: which word moves it, how far, and what it can do.

    Speeds are in counts/ms, accelerations in counts/ms2. `reversal_steps` is the highest count
    of a plain pixel right behind one of the other direction; None is no limit. `together` is the
    number of motors on its board that a program moves. `unused_limits` are those of the machine
    file that mode1 does not use, `max_jerk` among them, steps/px3, which lookahead keeps.
    """

    name: str
    word: str
    max_acceleration: float
    max_speed: float = 32.0
    counts_per_unit: float = 1.0
    smooth: bool = False
    reversal_steps: int | None = None
    unit: str = "steps"
    axis: int = 0
    negative: bool = False
    together: int = 1
    max_jerk: float | None = None
    unused_limits: tuple[str, ...] = ()

    @property
    def jerk_rounding(self) -> int:
        """What whole steps may add to the planned jerk, steps/px3."""
        return SMOOTH_JERK_ROUNDING if self.smooth else PLAIN_JERK_ROUNDING

    def planned_speed(self, pixel_ms: float) -> float:
        """Return the speed to plan with: an even speed may lie 2 steps/px above the planned one."""
        if not self.smooth:
            return self.max_speed
        return max(self.max_speed - SMOOTH_SPEED_ROUNDING / pixel_ms, self.max_speed / 2)

    def planned_acceleration(self, pixel_ms: float) -> float:
        """Return the acceleration to plan with, so that whole steps stay within the limit.

        Raises UserError for a smooth motor that no line can obey.
        """
        if not self.smooth:
            return self.max_acceleration
        per_pixel = self.max_acceleration * pixel_ms**2
        if per_pixel <= _LEAST_SMOOTH:
            longer = (_LEAST_SMOOTH / self.max_acceleration) ** 0.5
            raise RefusedError(
                f"motor {self.name}: {per_pixel:.6g} steps/px2 is too little acceleration for "
                f"smooth lines, whose speeds are even: more than {_LEAST_SMOOTH} steps/px2 = "
                f"{_LEAST_SMOOTH / pixel_ms**2:.6g} counts/ms2, or a pixel longer than "
                f"{longer:.6g} ms ({MS / longer:.6g} Hz), or kind plain"
            )
        return self.max_acceleration - SMOOTH_ROUNDING / pixel_ms**2


@dataclass(frozen=True)
class Setup:
    """Everything that a program does not say: the motors, the pixel clock, times.

    `pixel_hz` is the frequency of pixels, each of `divider` edges of the clock. `sync` is what the
    lines are to the clock, `gate_edges` how far behind a burst's first edge they begin,
    `clock_out_hz` the clock that the board makes itself; None leaves each to the board.
    `path_tolerance` and `arc_tolerance` are in steps, the latter in those of the finer motor of a
    circle.
    """

    motors: tuple[PlanMotor, ...]
    pixel_hz: Fraction
    feed_ms: float = 1000.0
    top_feed: float | None = None
    other_feed: float | None = None
    segment_ms: float = 0.0
    path_tolerance: float = 1.0
    arc_tolerance: float = 1.0
    divider: int = 1
    sync: str | None = None
    gate_edges: int | None = None
    clock_out_hz: int | None = None
    words: dict[str, int] = field(init=False)

    def __post_init__(self) -> None:
        """Note which word moves which motor."""
        words = {motor.word: index for index, motor in enumerate(self.motors)}
        object.__setattr__(self, "words", words)

    @property
    def clock(self) -> dict[str, int]:
        """The settings of a board that say what pixels and lines are to its clock."""
        return settings.of_clock(self.sync, self.divider)

    @property
    def smooth(self) -> bool:
        """Whether any motor is smooth: then the speeds of all are means around edges."""
        return any(motor.smooth for motor in self.motors)

    @property
    def pixel_ms(self) -> float:
        """The pixel period in milliseconds."""
        return float(MS / self.pixel_hz)


def of_machine(machine: MachineTables) -> Setup:
    """Return the setup of a machine file.

    Raises UserError naming the file and the key of what is missing.
    """
    hz = machine.pixel_hz
    given = machine.program
    chosen = [motor for motor in machine.motors.values() if _word(motor)]
    together = Counter(machine.board_name(motor) for motor in chosen)
    motors = tuple(_motor(machine, motor, together[machine.board_name(motor)]) for motor in chosen)
    if not motors:
        raise RefusedError(
            f"{machine.path}: no motor has a word for programs: name it X, Y, Z ... or set the "
            f"key word"
        )
    seen: dict[str, str] = {}
    for motor in motors:
        if motor.word in seen:
            raise RefusedError(
                f"{machine.path}: motors.{motor.name}.word = {motor.word!r}: motor "
                f"{seen[motor.word]} has this word"
            )
        seen[motor.word] = motor.name
    return Setup(
        motors,
        hz,
        float(given.feed_time * MS),
        given.top_feed,
        given.other_feed,
        float(given.segment_time * MS),
        divider=machine.clock.edges,
        sync=machine.clock.sync,
        gate_edges=machine.clock.gate_edges,
        clock_out_hz=machine.board_of(chosen[0]).clock_out_hz,
    )


def _word(motor: MotorTable) -> str | None:
    """Return the word that moves a motor: its own key, else its name, if that is a word."""
    name = motor.name.upper()
    return motor.word or (name if len(name) == 1 and name in AXIS_WORDS else None)


def _motor(machine: MachineTables, motor: MotorTable, together: int) -> PlanMotor:
    hz = machine.pixel_hz
    clock = settings.of_clock(machine.clock.sync, machine.clock.edges)
    able = capability.of(machine.board_of(motor).kind, hz, axes=together, clock=clock)
    top = float(able.top_speed(motor.kind) * hz / MS)
    scale = motor.steps_per_unit
    return PlanMotor(
        name=motor.name,
        word=_word(motor) or "",
        max_acceleration=_max_acceleration(machine, motor),
        max_speed=min(_per_ms(machine, motor, "max_speed") or top, top),
        counts_per_unit=float(scale.steps_per_unit) if scale else 1.0,
        smooth=motor.smooth,
        reversal_steps=None if motor.smooth else able.direct_reversal_speed,
        unit=scale.length if scale else "steps",
        axis=motor.axis,
        negative=motor.negative,
        together=together,
        max_jerk=_max_jerk(machine, motor),
        unused_limits=tuple(key for key in UNUSED_LIMITS if motor.limit(key) is not None),
    )


def _per_ms(machine: MachineTables, motor: MotorTable, key: str) -> float | None:
    """Return a motor's limit in counts and milliseconds; None if it has none."""
    limit, hz = motor.limit(key), machine.pixel_hz
    return None if limit is None else float(limit.per_pixel(hz) * (hz / MS) ** limit.order)


def _max_acceleration(machine: MachineTables, motor: MotorTable) -> float:
    """Return a motor's limit of the acceleration. Raises UserError if it has none."""
    found = _per_ms(machine, motor, "max_acceleration")
    if not found:
        raise RefusedError(
            f"{machine.path}: motors.{motor.name}.limits.max_acceleration: is missing; a program "
            f"needs it"
        )
    return found


def _max_jerk(machine: MachineTables, motor: MotorTable) -> float | None:
    """Return a motor's limit of the jerk in steps/px3. Raises UserError if it is 0."""
    jerk = motor.limit("max_jerk")
    if jerk is None:
        return None
    found = float(jerk.per_pixel(machine.pixel_hz))
    if found <= 0:
        raise RefusedError(
            f"{machine.path}: motors.{motor.name}.limits.max_jerk: is 0; a motor that moves needs "
            f"more, or leave it out"
        )
    return found
