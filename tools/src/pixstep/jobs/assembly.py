# SPDX-License-Identifier: MIT
"""From what each motor makes in each line to a job: shapes, places, the files that decided it."""

from __future__ import annotations

import datetime
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.errors import UserError
from pixstep.jobs import header, job
from pixstep.jobs.header import JobHeader, JobLineTable, JobMotorTable, SourceTable
from pixstep.jobs.job import Job
from pixstep.jobs.shapes import IMAGE, MINUS, NONE, PLUS, MotorRun, Shape, key_of
from pixstep.lines.line import SMOOTH
from pixstep.machine.files import MachineFile

Counts = tuple[int, ...]
_FARTHEST = 2**31 - 1  # that a board's registers hold
_EPOCH = "SOURCE_DATE_EPOCH"  # https://reproducible-builds.org/specs/source-date-epoch


@dataclass(frozen=True)
class MotorStroke:
    """What a motor makes in a line: counts, of a smooth line with their direction."""

    counts: Counts
    negative: bool = False


@dataclass(frozen=True)
class ImagePlace:
    """Where the image begins in a line, from pixel 1, 0 without one; what the line is for."""

    image_pixel: int
    purpose: str = IMAGE


@dataclass(frozen=True)
class MotorPart:
    """A motor of a job: what its lines were made with, a stroke a line, where it begins."""

    about: JobMotorTable
    strokes: Sequence[MotorStroke]
    start_steps: int = 0


@dataclass
class Copies:
    """The files of the user's that a job carries along, byte for byte."""

    members: dict[str, bytes] = field(default_factory=dict)

    @classmethod
    def of_machine(cls, machine: MachineFile) -> Copies:
        """Return the copy of a machine file."""
        return cls({job.MACHINE: _bytes(machine.path)})

    def add(self, folder: str, path: Path, name: str | None = None) -> str:
        """Copy a file; return the member. Two files of one name get different ones."""
        data = _bytes(path)
        wanted = Path(name or path.name)
        for number in range(1, len(self.members) + 2):
            more = "" if number == 1 else f"-{number}"
            member = f"{folder}{wanted.stem}{more}{wanted.suffix}"
            if self.members.setdefault(member, data) == data:
                return member
        raise AssertionError("one of so many names is free")

    def profiles(self, machine: MachineFile, name: str, own: Path | None = None) -> dict[str, str]:
        """Copy the profiles of a motor, and one of its `own` for lines; return members by use.

        One that is not there yet is left out.
        """
        paths = {use: machine.profile(machine[name], use) for use in ("line", "move", "home")}
        paths["own"] = own
        return {
            use: self.add(job.PROFILES, path)
            for use, path in paths.items()
            if path is not None and path.is_file()
        }


@dataclass(frozen=True)
class Common:
    """What a job has beside its motors."""

    line: JobLineTable
    source: SourceTable
    copies: Copies
    resumable: bool = True
    settings: Mapping[str, str] = field(default_factory=dict)


def assemble(parts: Mapping[str, MotorPart], places: Sequence[ImagePlace], common: Common) -> Job:
    """Return the job. Raises UserError if the motors' lines have different lengths."""
    shapes: dict[bytes, Shape] = {}
    rows = [[*_runs(name, part, places, shapes)] for name, part in parts.items()]
    runs = tuple(run for line in zip(*rows, strict=True) for run in line)
    _refuse_lengths(runs)
    line = common.line.model_copy(
        update={"lines": len(places), "pixels": runs[0].pixels if runs else 0}
    )
    about = JobHeader(
        schema=header.SCHEMA,
        id=job.id_of(runs),
        resumable=common.resumable,
        made=header.made_now(_now()),
        source=common.source,
        line=line,
        motors={name: part.about for name, part in parts.items()},
        settings=dict(common.settings),
    )
    return Job(about, common.copies.members, runs, shapes)


def _runs(
    name: str, part: MotorPart, places: Sequence[ImagePlace], shapes: dict[bytes, Shape]
) -> Iterable[MotorRun]:
    """Yield a motor's lines, each from where the one before ends."""
    where, decode, backlash = part.start_steps, part.about.decode, part.about.backlash
    side = _first_side(part)
    for number, (stroke, place) in enumerate(zip(part.strokes, places, strict=True), 1):
        key = key_of(stroke.counts, decode, backlash if decode == SMOOTH else 0)
        if key not in shapes:
            shapes[key] = Shape.of(stroke.counts, decode, backlash)
        shape = shapes[key]
        yield MotorRun(
            number, name, key, stroke.negative, where, side, place.image_pixel,
            len(stroke.counts), place.purpose,
        )  # fmt: skip
        where += -shape.travel if stroke.negative else shape.travel
        if abs(where) > _FARTHEST:
            raise UserError(
                f"line {number} of motor {name} ends at {where} steps: positions are "
                f"{-_FARTHEST} to {_FARTHEST}"
            )
        side = _last_side(stroke) or side


def _first_side(part: MotorPart) -> str:
    """Return the direction in which a motor has to come to where it begins.

    One that takes up play comes from its first line's direction, another one in it.
    """
    moving = (stroke for stroke in part.strokes if any(stroke.counts))
    first = next(moving, None)
    if first is None:
        return NONE
    side = _side(next(filter(None, first.counts)), first.negative)
    taken_up = part.about.decode == SMOOTH and part.about.backlash
    return {PLUS: MINUS, MINUS: PLUS}[side] if taken_up else side


def _last_side(stroke: MotorStroke) -> str:
    last = next(filter(None, reversed(stroke.counts)), 0)
    return _side(last, stroke.negative) if last else NONE


def _side(count: int, negative: bool) -> str:
    return MINUS if (count < 0) != negative else PLUS


def _refuse_lengths(runs: Sequence[MotorRun]) -> None:
    if not runs:
        raise UserError("a job has a line and a motor at least")
    first = runs[0]
    for run in runs:
        if run.pixels != first.pixels:
            raise UserError(
                f"line {run.line} of motor {run.motor} has {run.pixels} pixels, line {first.line} "
                f"of motor {first.motor} {first.pixels}: all lines of a job are equally long"
            )


def _now() -> datetime.datetime:
    """Return the time, or the one that a reproducible build is given."""
    given = os.environ.get(_EPOCH, "")
    if given.isdecimal():
        return datetime.datetime.fromtimestamp(int(given), datetime.UTC)
    return datetime.datetime.now(datetime.UTC)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
