# SPDX-License-Identifier: MIT
"""Play taken up at reversals: a transition of some points is laid over the motion of an axis.

The offset of the motor is 0 in the direction in which the play is taken up at the start and `play`
counts against that direction in the other. At a reversal it begins to change in the first point
that has moved the new way, by the same share of the play in every point: `steps` points take all of
it. A second reversal inside of a transition turns the offset back from where it is. Whole counts
are cut from the exact line, so that they never add up wrong; the velocities get the very
differences of the offsets, up to the point before the last.

    position       .-----        offset          ______       velocity    ----.
             -.   /                         ____/             added           |
               '-'                       __/                          --------'
                 reversal                  steps points

How many points a transition should have says a model of the machine: a servo of second order with
velocity feed-forward between command and motor, play between motor and load. The servo's loop runs
SUBSTEPS times in a point (semi-implicit Euler) on a command that is straight from point to point.
No servo is a motor that is always where it should be, as a stepper is. Too few points make the
servo overshoot, too many leave slack.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, pi

from pixstep.errors import UserError
from pixstep.lazy import np
from pixstep.reversals.compensate import directions
from pixstep.trajectories import table
from pixstep.trajectories.table import AXES, TwoAxisTable

SUBSTEPS = 20
_STABLE = 0.5  # radians of the natural frequency in a substep: far from where the loop swings up


@dataclass(frozen=True)
class Servo:
    """Natural frequency in Hz and damping of a position loop."""

    hz: float
    damping: float = 0.6


def follow(command: np.ndarray, point_s: float, servo: Servo | None) -> np.ndarray:
    """Return where a motor is at each point; it begins on the command, at the command's speed.

    Raises UserError for a loop too quick for points of this length.
    """
    if servo is None:
        return command.astype(np.float64)
    rate = 2 * pi * servo.hz
    if not 0 < rate * point_s / SUBSTEPS <= _STABLE or not 0 <= servo.damping <= 4:
        raise UserError(
            f"a servo of {servo.hz:g} Hz, damping {servo.damping:g}, cannot be followed in points "
            f"of {point_s:g} s: above 0 and at most {_STABLE * SUBSTEPS / (2 * pi * point_s):g} Hz"
        )
    speeds = np.diff(command) / point_s
    ahead, fast, pushed = (_one_point(point_s, servo, *unit) for unit in np.eye(3).tolist())
    lag, speed = 0.0, float(speeds[0])  # motor less command, motor's speed
    lags = [0.0]
    for wanted in speeds.tolist():
        lag, speed = (
            ahead[0] * lag + fast[0] * speed + pushed[0] * wanted,
            ahead[1] * lag + fast[1] * speed + pushed[1] * wanted,
        )
        lags.append(lag)
    motor: np.ndarray = command + np.array(lags)
    return motor


def _one_point(
    point_s: float, servo: Servo, lag: float, speed: float, wanted: float
) -> tuple[float, float]:
    """Return lag and speed of a motor one point on, the command moving at speed `wanted`."""
    rate, step = 2 * pi * servo.hz, point_s / SUBSTEPS
    for _ in range(SUBSTEPS):
        speed += step * (rate * rate * -lag + 2 * servo.damping * rate * (wanted - speed))
        lag += step * (speed - wanted)
    return lag, speed


def loads(motor: np.ndarray, play: float, taken_up: int) -> np.ndarray:
    """Return where the load is at each point; at first it is on the motor, pushed `taken_up`."""
    low = 0.0 if taken_up > 0 else -play
    high = low + play
    place = float(motor[0])
    places = []
    for position in motor.tolist():
        place = min(max(place, position + low), position + high)
        places.append(place)
    return np.array(places)


@dataclass(frozen=True)
class TablePlay:
    """The play of an axis in counts, and the points of a transition."""

    play: int
    steps: int = 64


@dataclass(frozen=True)
class Transition:
    """What happens at one reversal: records count from 0."""

    axis: int
    record: int  # the last one of the old direction
    direction: int
    points: int  # in which the offset changes
    counts: int  # by which it changes, signed
    missing: int  # of the play, because the next reversal came first


@dataclass(frozen=True)
class TakenUpTable:
    """The motors' table, the offsets in it, and its transitions."""

    table: TwoAxisTable
    original: TwoAxisTable
    offsets: np.ndarray
    transitions: tuple[Transition, ...]
    taken_up: tuple[int, ...]  # by axis: the direction in which the play is taken up at the start


def initial_direction(made: TwoAxisTable, axis: int) -> int:
    """Return the direction of an axis' first motion; +1 for one that never moves."""
    counts = made.counts(axis)
    moving = np.flatnonzero(counts)
    return int(np.sign(counts[moving[0]])) if len(moving) else 1


def compensate(original: TwoAxisTable, plays: tuple[TablePlay, ...]) -> TakenUpTable:
    """Return the motors' table for the load's.

    Raises UserError for a transition of less than a point, RefusedError naming the record in which
    a motor would have to move further than a pixel can hold.
    """
    for axis, item in enumerate(plays):
        if item.steps < 1 or item.play < 0:
            raise UserError(
                f"axis {axis + 1}: a transition of {item.steps} points for a play of {item.play} "
                f"counts: at least 1 point and 0 counts"
            )
    taken_up = tuple(initial_direction(original, axis) for axis in range(AXES))
    offsets = np.zeros_like(original.positions)
    transitions: list[Transition] = []
    for axis, item in enumerate(plays):
        ways = np.array(directions(original.counts(axis).tolist()), dtype=np.int64)
        offsets[:, axis], found = _axis(ways, item, taken_up[axis], axis)
        transitions += found
    added = np.zeros_like(offsets)
    added[:-1] = np.diff(offsets, axis=0)
    made = table.made(
        original.positions + offsets, original.velocities + added, f"{original.name}, compensated"
    )
    ordered = sorted(transitions, key=lambda item: (item.record, item.axis))
    return TakenUpTable(made, original, offsets, tuple(ordered), taken_up)


def _axis(
    ways: np.ndarray, item: TablePlay, taken_up: int, axis: int
) -> tuple[np.ndarray, list[Transition]]:
    """Return an axis' offsets at every record, and its transitions.

    `ways` are the directions from each record to the next.
    """
    offsets = np.zeros(len(ways) + 1, dtype=np.int64)
    turns = np.flatnonzero(np.diff(np.concatenate([[taken_up], ways])))
    if not item.play or not np.any(ways):
        return offsets, []
    found = []
    for turn, following in pairwise([*turns.tolist(), len(ways)]):
        begin, end = turn + 1, min(following + 1, len(ways))
        goal = 0 if ways[turn] == taken_up else -taken_up * item.play
        ramp = _ramp(int(offsets[begin]), goal, item, end - begin)
        offsets[begin : end + 1] = ramp
        offsets[end + 1 :] = ramp[-1]
        last, points = int(ramp[-1]), int(np.argmax(ramp == ramp[-1]))
        way, moved, missing = int(ways[turn]), last - int(ramp[0]), abs(goal - last)
        found.append(Transition(axis, turn, way, points, moved, missing))
    return offsets, found


def _ramp(start: int, goal: int, item: TablePlay, points: int) -> np.ndarray:
    """Return the offsets of a record and of `points` behind it, on the way to a goal."""
    away = np.arange(points + 1, dtype=np.int64) * item.play // item.steps
    offsets: np.ndarray = start + np.sign(goal - start) * np.minimum(away, abs(goal - start))
    return offsets


BETWEEN = 8  # places in a point at which the radius is looked at
_BEFORE = 8  # points before the crest
_SETTLED = 7.0  # time constants of the servo
_GRID = 40


@dataclass(frozen=True)
class Crest:
    """Where an axis of a circle reverses: radius and play in counts, points of a revolution."""

    radius: int
    points: int
    play: int
    point_s: float
    servo: Servo | None = None


@dataclass(frozen=True)
class ChosenSteps:
    """The number of points chosen, and the largest radius error that it makes, in counts."""

    steps: int
    error: float


def predicted_error(crest: Crest, steps: int, places: int = BETWEEN) -> float:
    """Return the largest radius error, in counts, around a reversal of so many points.

    The radius is looked at at so many `places` of each point, in which motors move evenly. With 1
    it is that at the points alone, less than the truth by what the circle falls back in one of
    them.
    """
    behind = min(2 * steps + _settling(crest), crest.points // 4)
    point = np.arange(-_BEFORE, behind + 1)
    angle = 2 * pi * point / crest.points
    ramp = np.clip((point - 1) / steps, 0, 1) * crest.play  # begins in the first point moved back
    command = crest.radius * np.cos(angle) - ramp
    motor = follow(command, crest.point_s, crest.servo)
    fine = np.arange((len(point) - 1) * places + 1) / places
    motor, beside = (
        np.interp(fine, point + _BEFORE, one) for one in (motor, crest.radius * np.sin(angle))
    )
    distance = np.hypot(loads(motor, crest.play, 1), beside)
    return float(np.max(np.abs(distance - crest.radius)))


def choose(crest: Crest, least: int = 1) -> ChosenSteps:
    """Return the number of points, at least `least`, with the smallest error.

    Raises UserError if not even an eighth of a revolution has so many.
    """
    most = crest.points // 8
    if least > most:
        raise UserError(
            f"a transition of at least {least} points for {crest.play} counts: longer than the "
            f"{most} points of an eighth of a revolution"
        )
    if crest.servo is None or not crest.play:
        return ChosenSteps(least, predicted_error(crest, least) if crest.play else 0.0)
    grid = sorted({round(value) for value in np.geomspace(least, most, _GRID)})
    best = min(grid, key=lambda steps: predicted_error(crest, steps))
    beside = [(low, high) for low, high in pairwise(grid) if best in (low, high)]
    near = range(beside[0][0], beside[-1][1] + 1) if beside else [best]
    steps = min(near, key=lambda one: predicted_error(crest, one))
    return ChosenSteps(steps, predicted_error(crest, steps))


def least_steps(play: int, most_a_point: int) -> int:
    """Return the fewest points in which at most so many counts are added to any."""
    return max(1, ceil(play / most_a_point)) if most_a_point > 0 else play + 1


def _settling(crest: Crest) -> int:
    if crest.servo is None:
        return 0
    rate = 2 * pi * crest.servo.hz * max(crest.servo.damping, 0.05)
    return ceil(_SETTLED / (rate * crest.point_s))
