# SPDX-License-Identifier: MIT
"""A table run: on the modelled machine, or on a simulated board with its plants.

A run on a board is judged by its edges, and its loads are followed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards, capability
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import np
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import edge_tick
from pixstep.progress import Progress, unseen
from pixstep.simulation.experiment import run_and_judge
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import AxisPlant
from pixstep.simulation.summary import Summary
from pixstep.trajectories import transitions
from pixstep.trajectories.circle import Circle, Roundness, TableTrace, radius_errors, roundness_of
from pixstep.trajectories.table import AXES, TwoAxisTable
from pixstep.trajectories.transitions import Servo, TablePlay

ORIGINAL, COMPENSATED = "original", "compensated"


@dataclass(frozen=True)
class ModelledMachine:
    """Play by axis in counts, length of a point, servo of both axes (None: ideal)."""

    plays: tuple[int, ...]
    point_s: float
    servo: Servo | None = None


def command(original: TwoAxisTable, plays: tuple[TablePlay, ...], name: str) -> TwoAxisTable:
    """Return the table that is run: the original, or the compensated one made now."""
    if name == ORIGINAL:
        return original
    return transitions.compensate(original, plays).table


def run_modelled(
    original: TwoAxisTable, plays: tuple[TablePlay, ...], name: str, machine: ModelledMachine
) -> TableTrace:
    """Return what a table does: `plays` are what is compensated, the machine has its own."""
    made = command(original, plays, name)
    motors, loads = [], []
    for axis, play in zip(range(AXES), machine.plays, strict=True):
        motor = transitions.follow(made.positions[:, axis], machine.point_s, machine.servo)
        motors.append(motor)
        loads.append(transitions.loads(motor, play, transitions.initial_direction(original, axis)))
    motor, load = np.column_stack(motors), np.column_stack(loads)
    return TableTrace(name, made, original.positions, motor, load, machine.point_s)


_REST = 4  # pixels between directions: longer than any board's shortest reversal up to 1 kHz


@dataclass(frozen=True)
class BoardJob:
    """Where a table is run: board, axis of each of its two, clock, play of both plants in steps."""

    board: str
    pixel_hz: Fraction
    plays: tuple[int, ...]
    axes: tuple[int, ...] = tuple(range(AXES))
    image: Path | None = None
    seed: int = 1
    ways: tuple[int, ...] = (1,) * AXES  # -1: the load's positive direction is the motor's negative


@dataclass(frozen=True)
class SimulatedTable:
    """What a run has left: the verdict on its edges, its loads, and how round its circle is."""

    summary: Summary
    trace: TableTrace | None  # None if the board did not run to the end
    roundness: Roundness | None = None


def lines(made: TwoAxisTable) -> list[Line]:
    """Return the plain lines of a table's two axes: a pixel from each record to the next."""
    return [
        Line(tuple(made.counts(axis).tolist()), PLAIN, name=f"{made.name}, axis {axis + 1}")
        for axis in range(AXES)
    ]


def turned(found: list[Line], ways: tuple[int, ...]) -> list[Line]:
    """Return lines for motors that run forwards (1) or backwards (-1) for a table's forwards.

    Everything else reckons in the directions of the table.
    """
    return [
        replace(line, counts=tuple(way * count for count in line.counts))
        for line, way in zip(found, ways, strict=True)
    ]


def taking_up(
    made: TwoAxisTable, plays: tuple[TablePlay, ...], ways: tuple[int, ...]
) -> list[Line]:
    """Return a table's lines behind pixels that take up the play in each axis' first direction.

    Each motor goes back by the play and forth again, as fast as a transition adds: it ends where it
    was, and its load is pushed the way `ways` says.
    """
    found = []
    length = 2 * max(item.steps for item in plays) + 2 * _REST
    for line, item, way in zip(lines(made), plays, ways, strict=True):
        ramp = np.diff(np.arange(item.steps + 1, dtype=np.int64) * item.play // item.steps) * way
        rest = [0] * _REST
        before = [*(-ramp).tolist(), *rest, *ramp.tolist(), *rest]
        before = [0] * (length - len(before)) + before
        found.append(replace(line, counts=(*before, *line.counts)))
    return found


def check(made: TwoAxisTable, found: capability.BoardCapability) -> None:
    """Raise RefusedError for the first pixel that a board would refuse."""
    for line in lines(made):
        for item in line_check.check(line, found.of(line)):
            if item.severity == line_check.ERROR:
                raise RefusedError(
                    f"{line.name}: {item.name} after record {item.pixel}: {item.message}"
                )


def run_on_board(
    original: TwoAxisTable,
    plays: tuple[TablePlay, ...],
    name: str,
    job: BoardJob,
    folder: Path,
    progress: Progress = unseen,
    circle: Circle | None = None,
) -> SimulatedTable:
    """Run a table, the original or compensated, leave the run's logs in `folder`, and judge it.

    Raises RefusedError for what the board would refuse, UserError for a board with too few axes.
    """
    board = boards.load(job.board)
    if max(job.axes) >= board.axes:
        raise UserError(f"axis {max(job.axes)}: the {boards.axes_text(job.board)}")
    made = command(original, plays, name)
    check(made, capability.named_limits(job.board, job.pixel_hz, axes=AXES))
    result, judged, _ = run_and_judge(_job(job, made, original), folder, progress)
    zero = judged.summary["line_zero_cycle"]
    if zero is None or judged.summary["verdict"] != "pass":
        return SimulatedTable(judged.summary, None)
    period = result.job.period
    cycles = [zero + edge_tick(record, period) for record in range(made.records)]
    plants = [result.plants[0, axis] for axis in job.axes]
    trace = _table_run(name, made, original, plants, np.array(cycles), job)
    if circle is None:
        return SimulatedTable(judged.summary, trace)
    window = cycles[circle.start], cycles[circle.end]
    return SimulatedTable(
        judged.summary, trace, _roundness(trace, circle, plants, job.ways, window)
    )


def _job(job: BoardJob, made: TwoAxisTable, original: TwoAxisTable) -> LineExperiment:
    """Return the simulated run; each plant starts with its play taken up as the motion begins."""
    sides = [
        "minus" if way * transitions.initial_direction(original, index) < 0 else "plus"
        for index, way in enumerate(job.ways)
    ]
    return LineExperiment(
        board=job.board,
        lines=dict(zip(job.axes, turned(lines(made), job.ways), strict=True)),
        pixel_hz=job.pixel_hz,
        plants={
            axis: f"play={play},taken_up={side}"
            for axis, play, side in zip(job.axes, job.plays, sides, strict=True)
        },
        image=job.image,
        seed=job.seed,
    )


def _table_run(
    name: str, made: TwoAxisTable, original: TwoAxisTable, plants: list[AxisPlant],
    cycles: np.ndarray, job: BoardJob,
) -> TableTrace:  # fmt: skip
    """Return what motors and loads were at every record."""
    motors, loads = [], []
    for axis, plant in enumerate(plants):
        rows = np.maximum(np.searchsorted(plant.cycles, cycles, side="right") - 1, 0)
        first = original.positions[0, axis]
        way = job.ways[axis]
        motors.append(first + way * (plant.motor[rows] - plant.motor[0]))
        loads.append(first + way * plant.load_at(cycles))
    motor, load = np.column_stack(motors), np.column_stack(loads)
    return TableTrace(name, made, original.positions, motor, load, float(1 / job.pixel_hz))


def _roundness(
    trace: TableTrace,
    circle: Circle,
    plants: list[AxisPlant],
    ways: tuple[int, ...],
    window: tuple[int, int],
) -> Roundness:
    """Return the radius errors at every step of either motor, from angle 0 to the last pass."""
    events = np.sort(np.concatenate([plant.cycles for plant in plants]), kind="stable")
    events = events[np.flatnonzero(np.diff(events, prepend=-1))]
    events = events[(events >= window[0]) & (events <= window[1])]
    places = np.column_stack(
        [
            trace.ideal[0, axis] + way * plant.load_at(events)
            for axis, (plant, way) in enumerate(zip(plants, ways, strict=True))
        ]
    )
    turned = (events - window[0]) / (window[1] - window[0])
    angles = turned * 2 * np.pi * circle.revolutions
    errors = radius_errors(places, circle)
    return Roundness(trace.name, circle, roundness_of(trace, circle).passes, angles, errors)
