# SPDX-License-Identifier: MIT
"""A print job: lines of several motors, made once under one configuration that it carries along.

    job = Job.read(Path("print.pxjob"))
    job.lines, job.motors          1000, ("M39", "M40", "M41")
    job.line(7)["M39"]             what motor M39 makes in line 7
    job.expected(7, "M39")         where it is at each pixel edge

The file has the machine file and the profiles as they were, byte for byte (`header` has the rest).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass
from fractions import Fraction
from functools import cached_property
from itertools import zip_longest
from pathlib import Path

from pixstep import atomic
from pixstep.errors import RefusedError, UserError
from pixstep.jobs import archive, header
from pixstep.jobs.header import JobHeader
from pixstep.jobs.machine_copy import MachineCopy
from pixstep.jobs.shapes import MotorRun, Shape
from pixstep.lines.line import Line

SUFFIX = ".pxjob"
MACHINE, SHAPES, LINES = "machine.toml", "shapes.parquet", "lines.parquet"
PROFILES, SETTINGS = "profiles/", "settings/"


@dataclass(frozen=True, eq=False)
class Job:
    """A job that was made or read. `copies` are the members that are files of the user's.

    `runs` are line by line, the motors of each in their order.
    """

    header: JobHeader
    copies: Mapping[str, bytes]
    runs: tuple[MotorRun, ...]
    shapes: Mapping[bytes, Shape]
    path: Path = Path(f"job{SUFFIX}")

    @classmethod
    def read(cls, path: Path) -> Job:
        """Read a job. Raises RefusedError naming the member for one that is not as it was made."""
        members = archive.unpack(path, archive.load(path), header.NAME)
        about = header.read(path, members)
        for name in (MACHINE, SHAPES, LINES):
            if name not in members:
                raise RefusedError(f"{path}: member {name} is missing")
        try:
            runs = tuple(archive.unpack_runs(members.pop(LINES)))
            shapes = archive.ShapeTable(members.pop(SHAPES))
            members.pop(header.NAME)
            _refuse_strange(about, members, runs, shapes)
        except RefusedError as error:
            raise RefusedError(f"{path}: {error}") from None
        return cls(about, members, runs, shapes, path)

    def write(self, path: Path) -> int:
        """Write the job, whole or not at all; return its bytes."""
        data = self.packed()
        atomic.write_bytes(path, data)
        return len(data)

    def packed(self) -> bytes:
        """Return the bytes of the file."""
        used = dict.fromkeys(run.shape for run in self.runs)
        members = {
            **self.copies,
            SHAPES: archive.pack_shapes(self.shapes[key] for key in used),
            LINES: archive.pack_runs(self.runs),
        }
        about = self.header.model_copy(update={"sha256": header.sums(members)})
        return archive.pack({header.NAME: about.text().encode(), **members})

    @property
    def lines(self) -> int:
        """How many lines there are."""
        return self.header.line.lines

    @property
    def pixels(self) -> int:
        """Pixels of each line, the same for all motors."""
        return self.header.line.pixels

    @property
    def motors(self) -> tuple[str, ...]:
        """The motors, in the order of the machine file."""
        return tuple(self.header.motors)

    @cached_property
    def machine(self) -> MachineCopy:
        """The machine as it was when the job was made."""
        return MachineCopy.of(self.copies[MACHINE], Path(f"{self.path}:{MACHINE}"))

    @property
    def pixel_hz(self) -> Fraction:
        """The frequency of pixels that the job was made for."""
        return self.machine.tables.pixel_hz

    @property
    def seconds(self) -> float:
        """How long all lines take, one after the other without a gap."""
        return float(self.lines * self.pixels / self.pixel_hz)

    def line(self, number: int) -> dict[str, Line]:
        """Return what each motor makes in a line, from 1."""
        return {
            motor: self.shapes[run.shape].line(
                negative=run.negative, name=f"{self.path}: line {number} of motor {motor}"
            )
            for motor, run in self.runs_of(number).items()
        }

    def runs_of(self, number: int) -> dict[str, MotorRun]:
        """Return how each motor runs in a line, from 1. Raises UserError if there is no such."""
        if not 1 <= number <= self.lines:
            raise UserError(f"{self.path}: line {number}: there are lines 1 to {self.lines}")
        motors = len(self.motors)
        return {run.motor: run for run in self.runs[(number - 1) * motors : number * motors]}

    def expected(self, number: int, motor: str) -> tuple[int, ...]:
        """Return the motor's positions at the pixels' end edges of a line."""
        run = self.runs_of(number)[motor]
        sign = -1 if run.negative else 1
        return tuple(run.start_steps + sign * place for place in self.shapes[run.shape].expected)

    def shapes_of(self, motor: str) -> dict[tuple[bytes, bool], int]:
        """Return the shapes that a motor runs and whether backwards, each with its first line."""
        found: dict[tuple[bytes, bool], int] = {}
        for run in self.runs:
            if run.motor == motor:
                found.setdefault((run.shape, run.negative), run.line)
        return found


def _refuse_strange(
    about: JobHeader,
    copies: Mapping[str, bytes],
    runs: Sequence[MotorRun],
    shapes: Mapping[bytes, Shape],
) -> None:
    """Refuse a job whose members are right and do not fit each other: pixstep makes no such one."""
    motors = tuple(about.motors)
    wanted = ((line, name) for line in range(1, about.line.lines + 1) for name in motors)
    found = ((run.line, run.motor) for run in runs)
    if not runs or any(one != other for one, other in zip_longest(found, wanted)):
        raise RefusedError(f"{LINES}: not {about.line.lines} lines of {', '.join(motors)}")
    if any(run.shape not in shapes or run.pixels != about.line.pixels for run in runs):
        raise RefusedError(f"{LINES}: a line has a shape or a length that the job has not")
    named = [*about.settings.values()]
    named += [member for motor in about.motors.values() for member in motor.profiles.values()]
    lacking = next((member for member in named if member not in copies), None)
    if lacking is not None:
        raise RefusedError(f"member {lacking} is missing")


def id_of(runs: Iterable[MotorRun]) -> str:
    """Return what names a job by its lines: the same lines have the same."""
    content = hashlib.sha256()
    for run in runs:
        content.update(repr(astuple(run)).encode())
    return content.hexdigest()
