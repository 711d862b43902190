# SPDX-License-Identifier: MIT
"""Make a job: of an image's size, of lines or positions that are there, of a specification.

Values that are said of a motor: NAME=VALUE, again for more motors.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar

from pixstep import arguments
from pixstep.errors import AskedText, UserError
from pixstep.jobs import judging, line_files, making
from pixstep.jobs.image import ImageGeometry
from pixstep.jobs.making import AskedImage, JobOptions, NewJob
from pixstep.lazy import require_package
from pixstep.lines import units
from pixstep.lines.units import DISTANCE, SPEED, Quantity, parse_pixels
from pixstep.machine.model import MachineTables
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, TEXT, Kind, Length, Parsed, Pixels
from pixstep.operations.request import Request, flag, operation, option, unless
from pixstep.operations.result import Result

if TYPE_CHECKING:
    from pixstep.machine.files import MachineFile


Value = TypeVar("Value")
Pair = tuple[str, Any]


class OfMotor(Kind):
    """A motor and a value of it."""

    python = "str | tuple[str, object]"

    def __init__(self, name: str, reader: Callable[[str], Any]):
        self.name, self._reader = name, reader

    def parse(self, text: str) -> Pair:
        """Return the motor and the value of a text."""
        divide = text.partition if self.name.endswith("FILE") else text.rpartition
        motor, _, value = divide("=")  # a motor's name may have the sign, or a file's
        if not motor or not value:
            raise UserError(f"{text!r}: expected {self.name}")
        return motor, self._reader(value)

    def judge(self, value: Any) -> Pair:
        """Return a pair that Python has: ("M39", 1000), ("M39", "12mm/s")."""
        if not isinstance(value, tuple) or len(value) != 2 or not isinstance(value[0], str):
            raise UserError(f"{arguments.shown(value)}: expected a text, {self.name}")
        motor, held = value
        plain = isinstance(held, (str, os.PathLike, int, float)) and not isinstance(held, bool)
        return motor, self._reader(str(held)) if plain else held


def _speed(text: str) -> Quantity:
    return units.parse(text, SPEED)


def _distance(text: str) -> Quantity:
    return units.parse(text, DISTANCE, signed=True)


SCAN = OfMotor("NAME=SPEED", _speed)
AXIS_OF = OfMotor("NAME=AXIS", str)
DISTANCE_OF = OfMotor("NAME=DISTANCE", _distance)
FILE_OF = OfMotor("NAME=FILE", Path)


def of_motors(kind: Kind, about: str, *names: str, **more: Any) -> Any:
    """Return the field of a value that several motors may have."""
    return option(kind, about, *names, many=True, shown=kind.name, **more)


def pairs(field: str, values: Iterable[tuple[str, Value]]) -> dict[str, Value]:
    """Return the values by motor. Raises UserError for a motor that is named twice."""
    found: dict[str, Value] = {}
    for name, value in values:
        if name in found:
            raise UserError(f"{field}: motor {name} is named twice")
        found[name] = value
    return found


def in_steps(machine: MachineTables, distances: dict[str, Quantity]) -> dict[str, int]:
    """Return distances as whole steps of their motors. Raises UserError naming the motor."""
    found = {}
    for name, distance in distances.items():
        try:
            found[name] = distance.in_steps(machine[name].steps_per_unit).whole_steps()
        except UserError as error:
            raise UserError(f"motor {name}: {error}") from None
    return found


_SOURCES = ("image_size", "lines_of", "table", "useq", "scanspec")
_MOTIONS = ("scan", "step", "turn", "still", "axis_of")
_UNUSED = {  # fields that say what a source says
    "image_size": ("axis_of",),
    "lines_of": _MOTIONS,
    "table": _MOTIONS,
    "useq": ("scan", "step", "start"),
    "scanspec": ("scan", "step", "start"),
}


class _Offset(Length):
    """A distance of either direction."""

    def parse(self, text: str) -> Quantity:
        """Return the distance of a text."""
        return units.parse(text, DISTANCE, signed=True)


def _size(text: str) -> tuple[int, int]:
    pixels, by, lines = text.lower().partition("x")
    if not by:
        raise UserError(f"{text!r}: expected PIXELSxLINES, as 450x1000")
    found = parse_pixels(pixels.strip()), parse_pixels(lines.strip())
    if min(found) < 1:
        raise UserError(f"{text!r}: a pixel and a line at least")
    return found


IMAGE_SIZE = Parsed("PIXELSxLINES", _size, "str | tuple[int, int]")


class MadeJob(TypedDict):
    """A job that was written; `bytes` is the size of its file, `shapes` how many lines differ."""

    file: str
    id: str
    bytes: int
    source: str
    lines: int
    pixels: int
    motors: list[str]
    shapes: int
    seconds: float


@operation("job make")
class JobMake(Request):
    """Make a job: a file of the lines of several motors and the configuration that made them.

    Lines come from the size of an image and what its motors do, from files of lines, from a table
    of positions, or from a scan specification (useq-schema, scanspec). All have equally many
    pixels. The machine file and the profiles of the motors go into the job as they are. What the
    limits of a motor or of its board refuse is not written.
    """

    result = MadeJob
    needs_machine = True

    image_size: tuple[int, int] | None = option(
        IMAGE_SIZE, "Size of an image: pixels of a line, lines.", shown="PIXELSxLINES"
    )
    lines_of: tuple[tuple[str, Path], ...] = of_motors(
        FILE_OF,
        "Instead: the lines of a motor, CSV or CSB; a file of one line serves for all lines.",
    )
    table: Path | None = option(
        FILE, "Instead: a table with each motor's position at each pixel edge, and lines' numbers."
    )
    useq: Path | None = option(FILE, "Instead: a useq-schema sequence, YAML or JSON.")
    scanspec: Path | None = option(FILE, "Instead: a scanspec specification, JSON.")
    scan: tuple[tuple[str, Any], ...] = of_motors(
        SCAN, "Motor along the lines, its speed: 1000 (steps/px), 30000steps/s or 12mm/s."
    )
    step: tuple[tuple[str, Any], ...] = of_motors(
        DISTANCE_OF, "Motor that goes on from line to line, the pitch: 40 (steps) or 0.1mm."
    )
    turn: tuple[tuple[str, Any], ...] = of_motors(
        DISTANCE_OF, "Plain motor that goes forth and back inside each line: 400 (steps) or 1mm."
    )
    still: tuple[str, ...] = option(
        TEXT, "Motor that stands still in all lines.", many=True, shown="NAME"
    )
    axis_of: tuple[tuple[str, str], ...] = of_motors(
        AXIS_OF, "Motor of an axis of a specification: M39=x. An axis that is not given has its "
                 "motor's name.",
    )  # fmt: skip
    alternate: bool = flag(
        "Print forth and back; else a return without an image follows each line, and smooth lines "
        "of files have one direction.",
        off="--one-way", default=True,
    )  # fmt: skip
    lead_in: int | None = option(
        Pixels(0), "Constant pixels before the image, at least.",
        default_text="LeadIn of the scanning motor's move profile, else line.lead_in",
    )  # fmt: skip
    lead_out: int | None = option(
        Pixels(0), "Constant pixels after the image, at least.",
        default_text="line.lead_out, else the lead-in",
    )  # fmt: skip
    scan_offset_forward: Quantity | None = option(
        _Offset(), "Shift the image of forward lines by this much, in the forward direction.",
        default_text="line.scan_offset_forward",
    )  # fmt: skip
    scan_offset_back: Quantity | None = option(
        _Offset(), "Shift the image of backward lines by this much, in the forward direction.",
        default_text="line.scan_offset_back",
    )  # fmt: skip
    profile: tuple[tuple[str, Path], ...] = of_motors(
        FILE_OF, "Line profile (PRN) of a motor.", default_text="motors.NAME.profiles.line"
    )
    backlash_of: tuple[tuple[str, Any], ...] = of_motors(
        DISTANCE_OF, "Play that a smooth motor's lines take up.",
        default_text="motors.NAME.backlash",
    )  # fmt: skip
    start: tuple[tuple[str, Any], ...] = of_motors(
        DISTANCE_OF, "Where a motor's load is when the first line begins.", default_text="0"
    )
    settings: tuple[tuple[str, Path], ...] = of_motors(
        FILE_OF, "Settings of a board of the machine file, as `board settings export` writes them: "
        "they go into the job, and `job check` compares the board with them.",
    )  # fmt: skip
    resumable: bool = flag(
        "A job that was broken off may be resumed; not with wet material.",
        off="--not-resumable", default=True,
    )  # fmt: skip
    check: bool = unless(
        "Also write lines that the limits of a motor or a board refuse.", "--no-check"
    )
    output: Path = option(OUTPUT, "Job to write: NAME.pxjob.", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Make the job and write it."""
        require_package("pyarrow")
        machine = desk.facts.machine
        source = self._source()
        made = self._made(machine, source)
        desk.say(made.notes)
        with desk.progress("checking") as show:
            path_of = self._path_of(machine)
            warned = judging.judge(made.job, machine, path_of, show, refuse=self.check)
        desk.say([*warned, *judging.apart(made.job, machine)])
        size = made.job.write(self.output)
        job = made.job
        data: MadeJob = {
            "file": str(self.output), "id": job.header.id, "bytes": size,
            "source": job.header.source.kind, "lines": job.lines, "pixels": job.pixels,
            "motors": list(job.motors), "shapes": len(job.shapes),
            "seconds": round(job.seconds, 3),
        }  # fmt: skip
        return Result(data, _text(data), value=job)

    def _source(self) -> str:
        """Return which field says where the lines come from."""
        given = [name for name in _SOURCES if getattr(self, name)]
        if len(given) != 1:
            raise AskedError("a job is made of one of {image_size}, {lines_of}, {table}, {useq}, "
                             "{scanspec}")  # fmt: skip
        alone = [name for name in _UNUSED.get(given[0], ()) if getattr(self, name)]
        if alone:
            raise AskedError(f"{{{alone[0]}}}: not with {{{given[0]}}}, which says that")
        return given[0]

    def _path_of(self, machine: MachineFile) -> Callable[[str], Path]:
        """Return what says which file a motor's lines come from; an image has only the machine."""
        lines = pairs("lines_of", self.lines_of)
        source = self.table or self.useq or self.scanspec or machine.path
        return lambda name: lines.get(name, source)

    def _made(self, machine: MachineFile, source: str) -> NewJob:
        asked = self._asked(machine)
        if source == "lines_of":
            paths = pairs("lines_of", self.lines_of)
            return line_files.of_files(
                machine, paths, asked, alternate=self.alternate, refuse_faster=self.check
            )
        if source == "table":
            pass

            assert self.table is not None
            return line_files.of_table(machine, self.table, asked)
        image = self._image(machine, source)
        try:
            return making.of_image(machine, image, asked)
        except UserError as error:
            path = self.useq or self.scanspec
            if path is None or str(error).startswith(str(machine.path)):
                raise
            raise UserError(AskedText("{path}: {error}", path=path, error=error)) from None

    def _asked(self, machine: MachineFile) -> JobOptions:
        signs = {name: -1 if motor.negative else 1 for name, motor in machine.motors.items()}
        starts = in_steps(machine, pairs("start", self.start))
        plays = in_steps(machine, pairs("backlash_of", self.backlash_of))
        for name, steps in plays.items():
            if steps < 0 or not machine[name].smooth:
                raise UserError(f"motor {name}: backlash {steps}: 0 or more, of a smooth motor")
        for name in (*pairs("profile", self.profile), *self.still):
            _ = machine[name]  # names the motors that there are
        return JobOptions(
            pairs("profile", self.profile),
            plays,
            {name: signs[name] * place for name, place in starts.items()},
            self._settings(machine),
            self.resumable,
        )

    def _settings(self, machine: MachineFile) -> dict[str, Path]:
        found = pairs("settings", self.settings)
        for name in found:
            if name not in machine.boards:
                raise UserError(
                    f"{machine.path}: there is no board {name!r}: {', '.join(machine.boards)}"
                )
        return found

    def _image(self, machine: MachineFile, source: str) -> AskedImage:
        """Return the image that is asked for, or described by a specification."""
        if source in ("useq", "scanspec"):
            return self._specified(machine, source)
        assert self.image_size is not None
        scans, steps = pairs("scan", self.scan), pairs("step", self.step)
        pixels, lines = self.image_size
        image = self._common(machine, lines, pixels, next(iter(scans), None))
        return AskedImage(
            image, scans, in_steps(machine, steps),
            in_steps(machine, pairs("turn", self.turn)), self.still,
        )  # fmt: skip

    def _specified(self, machine: MachineFile, source: str) -> AskedImage:
        from pixstep.jobs import specifications

        path = self.useq or self.scanspec
        assert path is not None
        axes = {axis: name for name, axis in pairs("axis_of", self.axis_of).items()}
        kind: Any = source
        found = specifications.image_of(machine, kind, path, axes)
        image = found.image
        common = self._common(machine, image.lines, image.pixels, next(iter(found.scans)))
        common = replace(common, alternate=image.alternate)
        turns = in_steps(machine, pairs("turn", self.turn))
        return replace(found, image=common, turns=turns, still=(*found.still, *self.still))

    def _common(
        self, machine: MachineFile, lines: int, pixels: int, motor: str | None
    ) -> ImageGeometry:
        """Return an image with the lead-in, lead-out and offsets that are asked for."""
        lead_in = self.lead_in
        if lead_in is None:
            lead_in = machine.lead_in_of(machine[motor] if motor else None)
        lead_out = self.lead_out if self.lead_out is not None else machine.line.lead_out
        offsets = {
            name: getattr(self, f"scan_offset_{name}")
            or getattr(machine.line, f"scan_offset_{name}")
            for name in ("forward", "back")
        }
        return ImageGeometry(
            lines, pixels, lead_in, lead_in if lead_out is None else lead_out, self.alternate,
            *(_offset(machine, motor, offsets[name]) for name in ("forward", "back")),
        )  # fmt: skip


def _offset(machine: MachineFile, motor: str | None, offset: Quantity) -> int:
    if motor is None or not offset.value:
        return 0
    return in_steps(machine, {motor: offset})[motor]


def _text(data: MadeJob) -> str:
    motors = ", ".join(data["motors"])
    return (
        f"{data['file']}: {data['lines']} lines of {data['pixels']} pixels for {motors}, "
        f"{data['shapes']} shapes, {data['seconds']:g} s, {data['bytes']} bytes"
    )
