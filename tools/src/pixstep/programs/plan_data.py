# SPDX-License-Identifier: MIT
"""What a planner is told and what it tells, as plain data; cheap to import."""

from dataclasses import dataclass
from typing import NotRequired, TypedDict

from pixstep.lines.line_check import FindingFacts

MODE1, LOOKAHEAD = "mode1", "lookahead"
MODES = (MODE1, LOOKAHEAD)
WINDOW = 1024  # moves
MOST_WINDOW = 1_000_000
SEGMENT_MS = (0, 255)  # of a circle: the shortest, 0 for none, and the longest


@dataclass(frozen=True)
class PlanOptions:
    """`window` is for lookahead, in moves; `assume_last` for mode1."""

    mode: str = LOOKAHEAD
    window: int = WINDOW
    assume_last: bool = True


class MotorFigures(TypedDict):
    """What is known of a motor, as plain data; a limit that it has not is None."""

    name: str
    word: str
    kind: str
    steps: int
    travel_steps: int
    max_speed_counts_ms: float
    max_acceleration_counts_ms2: float
    max_acceleration_steps_px2: float
    planned_speed_counts_ms: float
    planned_acceleration_counts_ms2: float
    speed_ratio: float
    acceleration_ratio: float
    counted_speed_steps_px: int
    counted_speed_counts_ms: float
    counted_acceleration_steps_px2: int
    rounding_steps_px2: int
    counted_ratio: float
    counted_jerk_steps_px3: int
    max_jerk_steps_px3: float | None
    planned_jerk_steps_px3: float | None
    jerk_ratio: float | None
    allowed_jerk_steps_px3: float | None
    unused_limits: list[str]


class SlowedMove(TypedDict):
    """A move that takes longer than programmed."""

    # All segments of a circle together. Times are from the middle of the move's blend to the middle
    # of the next one. What a start or a stop takes more than programmed is its move's.

    line: int
    asked_ms: float
    ms: float
    why: str


class ExceededLimit(TypedDict):
    """A move that exceeds a limit."""

    line: int
    motor: str
    limit: str
    ratio: float


def limit_text(exceeded: ExceededLimit) -> str:
    """Return "line: what is exceeded", without the program."""
    of, ratio = f"{exceeded['limit']} of {exceeded['motor']}", exceeded["ratio"]
    return f"{exceeded['line']}: exceeds the {of}: {ratio:.4g} x"


class _Figures(TypedDict):
    """What is known of a plan besides its motors."""

    moves: int
    pixels: int
    pixel_hz: str
    divider: int
    sync: str | None
    total_ms: float
    programmed_ms: float
    moves_ms: float
    stops_ms: float
    dwells_ms: float
    off_path_steps: float
    slowed_moves: int
    clipped_blends: int
    reasons: dict[str, int]
    slowed: list[SlowedMove]
    arc_off_steps: float
    violated: int
    violations: list[ExceededLimit]


class PlanFigures(_Figures):
    """What is known of a plan."""

    motors: list[MotorFigures]


class PlannedMotor(MotorFigures):
    """The same of a motor, its line, and why a board would refuse that."""

    file: str
    direction: str
    refused: list[FindingFacts]


class PlannedProgram(_Figures):
    """A program that was planned into a folder."""

    program: str
    mode: str
    window_moves: int
    verdict: str
    motors: list[PlannedMotor]
    plots: NotRequired[list[str]]
