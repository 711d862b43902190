# SPDX-License-Identifier: MIT
"""What a machine's motors and boards say of a job's lines: each shape is judged once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards, capability, guarantee, settings
from pixstep.board.capability import BoardCapability
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.jobs.job import Job
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.lines.line_check import ERROR, Finding
from pixstep.lines.runs import MOST_BYTES, packed_size, queue_entries
from pixstep.machine import line_limits
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable
from pixstep.progress import Progress, unseen

_SLOW_EDGES_HZ = 60  # so few edges are all seen before any board fixes the next one
_LEAST_AHEAD_STEPS = 200  # of a pixel, that any board decodes ahead


@dataclass(frozen=True)
class MotorFindings:
    """What is said of a motor's lines: the first that is refused, and all that gets a warning."""

    refusal: str = ""
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Room:
    """What the longest line of a motor takes in the queue of its axis, and how large that is.

    A line that fits whole needs no host while it moves.
    """

    longest_bytes: int
    queue_bytes: int

    @property
    def safe(self) -> bool:
        """True if every line fits."""
        return self.longest_bytes <= self.queue_bytes


def room(job: Job, machine: MachineFile, name: str) -> Room:
    """Return what a motor's lines take in the queue of its axis."""
    kind = boards.load(machine.board_of(machine[name]).kind)
    longest = max((packed_size(queue_entries(line)) for _, line in _lines(job, name)), default=0)
    return Room(longest, kind.queue_entries * MOST_BYTES)


def judge(
    job: Job,
    machine: MachineFile,
    path_of: Callable[[str], Path],
    show: Progress = unseen,
    *,
    refuse: bool = True,
) -> list[str]:
    """Return the warnings of all lines. Raises RefusedError for the first that is refused.

    Without `refuse` that one is a warning too. `path_of` returns the file that says a motor's
    lines.
    """
    said: list[str] = []
    for number, name in enumerate(job.motors, 1):
        found = of_motor(job, machine, name)
        if found.refusal and refuse:
            raise RefusedError(AskedText(
                "{path}: {refusal} ({no_check} writes it all the same)",
                path=path_of(name), refusal=found.refusal,
            ))  # fmt: skip
        if found.refusal:
            said.append(found.refusal)
        said += found.warnings
        show(number / len(job.motors))
    return said


def of_motor(
    job: Job, machine: MachineFile, name: str, limits: BoardCapability | None = None
) -> MotorFindings:
    """Return what a machine says of a motor's lines; `limits` are those of a connected board."""
    motor = machine[name]
    try:
        bounds = limits or _limits(job, machine, name)
        found = _Findings(motor, bounds, machine.pixel_hz)
        return found.of(_lines(job, name))
    except UserError as error:
        return MotorFindings(f"motor {name}: {error}")


def of_board(job: Job, machine: MachineFile, name: str) -> MotorFindings:
    """Return whether a board is guaranteed to follow the lines that its motors run together."""
    board = machine.boards[name]
    motors = [
        one for one in job.motors
        if one in machine.motors and machine.board_of(machine[one]) is board
    ]  # fmt: skip
    clock = settings.of_clock(machine.clock.sync, machine.clock.edges)
    try:
        world = guarantee.world(board.kind, machine.pixel_hz, clock)
        for number in _different(job, motors):
            lines = job.line(number)
            if text := guarantee.refusal([lines[one] for one in motors if one in lines], world):
                return MotorFindings(text)
    except UserError as error:
        return MotorFindings(f"board {name}: {error}")
    return MotorFindings()


def apart(job: Job, machine: MachineFile) -> Iterator[str]:
    """Yield what keeps boards on one clock from ending their pixels within 2 ticks (CLOCK.md).

    A board decodes no more single steps ahead than its ring holds: of denser pixels it fixes an
    edge later than another board, by newer edges of the clock.
    """
    there = [name for name in job.motors if name in machine.motors]
    names = {machine.board_name(machine[name]) for name in there}
    locked = settings.locks(settings.of_clock(machine.clock.sync, machine.clock.edges))
    if len(names) < 2 or not locked or machine.clock_hz <= _SLOW_EDGES_HZ:
        return
    for name in there:
        for first, line in _lines(job, name):
            steps = max(map(abs, line.counts))
            if steps > _LEAST_AHEAD_STEPS:
                pixel = [abs(count) for count in line.counts].index(steps) + 1
                yield (
                    f"line {first} of motor {name}: {steps} steps at pixel {pixel}: with more than "
                    f"{_LEAST_AHEAD_STEPS}, and more than {_SLOW_EDGES_HZ} edges of the clock a "
                    f"second, boards may end pixels more than 2 ticks apart if the clock jitters"
                )
                break


def _different(job: Job, motors: list[str]) -> Iterator[int]:
    """Yield the number of each line of which no earlier one has the same shapes for the motors."""
    seen: set[frozenset[tuple[str, bytes, bool]]] = set()
    for number in range(1, job.lines + 1):
        runs = job.runs_of(number)
        shapes = frozenset(
            (one, runs[one].shape, runs[one].negative) for one in motors if one in runs
        )
        if shapes and shapes not in seen:
            seen.add(shapes)
            yield number


@dataclass(frozen=True)
class _Findings:
    """The limits of a motor and its board, at a frequency of pixels."""

    motor: MotorTable
    board: BoardCapability
    hz: Fraction

    def of(self, lines: Iterable[tuple[int, Line]]) -> MotorFindings:
        """Judge lines, each with the number of the first one like it."""
        refusal, warnings = "", []
        for first, line in lines:
            for one in self._check(line):
                told = f"line {first} of motor {self.motor.name}: {one.name} at pixel {one.pixel}: "
                told += one.message
                if one.severity != ERROR:
                    warnings.append(told)
                elif not refusal:
                    refusal = told
        return MotorFindings(refusal, tuple(warnings))

    def _check(self, line: Line) -> list[Finding]:
        motor = line_limits.of_motor(self.motor, line, self.hz)
        found = line_check.check(line, self.board.of(line).lower(motor))
        still = not any(line.counts)
        return [] if still else line_check.without_idle_pixel(found)


def _limits(job: Job, machine: MachineFile, name: str) -> BoardCapability:
    """Return the limits of a motor's board while all of its motors in the job move."""
    board = machine.board_of(machine[name])
    beside = [
        one for one in job.motors
        if one in machine.motors and machine.board_of(machine[one]) is board
    ]  # fmt: skip
    clock = settings.of_clock(machine.clock.sync, machine.clock.edges)
    return capability.named_limits(board.kind, machine.pixel_hz, axes=len(beside), clock=clock)


def _lines(job: Job, name: str) -> Iterator[tuple[int, Line]]:
    """Yield every different line of a motor, with the number of the first like it."""
    for (key, negative), first in job.shapes_of(name).items():
        yield first, job.shapes[key].line(negative=negative)
