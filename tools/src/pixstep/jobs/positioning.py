# SPDX-License-Identifier: MIT
"""Motors on their way to where a line begins, from the side on which the job had them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pixstep.board import run
from pixstep.board.link import World
from pixstep.errors import UserError
from pixstep.jobs import ramps
from pixstep.jobs.job import Job
from pixstep.jobs.shapes import MINUS, NONE
from pixstep.jobs.stations import Station
from pixstep.machine.files import MachineFile
from pixstep.moves import fast, on_board
from pixstep.moves.fast import Acceleration
from pixstep.moves.on_board import MotionClock


@dataclass(frozen=True)
class Off:
    """A motor beside where a line begins; `side` is the one from which it has to come there."""

    station: Station
    motor: str
    position_steps: int
    wanted_steps: int
    side: str

    @property
    def is_away(self) -> bool:
        """True unless it is there, though perhaps on the wrong side of its play."""
        return self.position_steps != self.wanted_steps

    def __str__(self) -> str:
        return (
            f"motor {self.motor} (board {self.station.name}) is at {self.position_steps}, the line "
            f"begins at {self.wanted_steps}"
        )


def off(job: Job, line: int, stations: Iterable[Station]) -> list[Off]:
    """Return the motors that are not where a line begins."""
    return [one for one in every(job, line, stations) if one.is_away]


def every(job: Job, line: int, stations: Iterable[Station]) -> list[Off]:
    """Return all motors: their positions are known, not from which side they came."""
    runs, found = job.runs_of(line), []
    for station in stations:
        run.look(station.lines)
        for name, at in station.positions.items():
            found.append(Off(station, name, at, runs[name].start_steps, runs[name].play_side))
    return found


def go(machine: MachineFile, job: Job, motors: Iterable[Off], world: World) -> list[str]:
    """Bring motors to where a line begins; return in words what was moved.

    Each comes from the side on which the job had it, by more than its play.
    """
    told = []
    for one in motors:
        lash = max(job.header.motors[one.motor].backlash, machine[one.motor].backlash_steps)
        before = one.wanted_steps
        if one.side != NONE and lash:
            before += (lash + 1) if one.side == MINUS else -(lash + 1)
        profile = _profile(machine, one.motor)
        at = one.position_steps
        for target in dict.fromkeys((before, one.wanted_steps)):
            if target != at:
                _move(one, machine, fast.plan(profile, target - at), world)
                at = target
        told.append(f"motor {one.motor} moved from {one.position_steps} to {one.wanted_steps}")
    return told


def _move(one: Off, machine: MachineFile, move: fast.FastMove, world: World) -> None:
    axis = one.station.motors[one.motor]
    ready = on_board.prepare_move(
        one.station.board, axis, move, MotionClock(machine.clock_hz, machine.clock.edges), "move"
    )
    with run.stopped_on_failure([ready.lines]):
        ready.make(world)


def _profile(machine: MachineFile, name: str) -> Acceleration:
    """Return how a motor moves fast: by its move profile, else by its limits."""
    motor = machine[name]
    path = machine.profile(motor, "move")
    if path is not None:
        limit = motor.limit("max_speed")
        top = None if limit is None else int(limit.per_pixel(machine.pixel_hz))
        return fast.read(path).limited(top)
    try:
        return ramps.by_limits(machine, motor)
    except UserError as error:
        raise UserError(f"{error} (`pixstep board move` can bring it there)") from None
