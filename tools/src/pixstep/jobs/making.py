# SPDX-License-Identifier: MIT
"""Make a job: of an image, or of lines that are there already."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pixstep.board import capability, values
from pixstep.errors import AskedText, UserError
from pixstep.jobs import image, ramps
from pixstep.jobs.assembly import Common, Copies, ImagePlace, MotorPart, MotorStroke, assemble
from pixstep.jobs.header import JobLineTable, JobMotorTable, SourceTable, sums
from pixstep.jobs.image import ImageGeometry, ImageLayout, ImageMove, ScanMotor
from pixstep.jobs.job import SETTINGS, Job
from pixstep.jobs.ramps import LINE, MOVE, RampFromRest
from pixstep.lines.units import Quantity, whole_speed
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable as MachineMotor
from pixstep.profiles import generator
from pixstep.profiles.generator import MAX_SPEED


@dataclass(frozen=True)
class JobOptions:
    """What every job is asked for beside its lines. All distances and positions are in steps.

    `profiles` and `backlash` replace those of the machine file; `starts` are the motors' positions
    at the first line; `settings` are exported settings of boards, by the board's name.
    """

    profiles: Mapping[str, Path] = field(default_factory=dict)
    backlash: Mapping[str, int] = field(default_factory=dict)
    starts: Mapping[str, int] = field(default_factory=dict)
    settings: Mapping[str, Path] = field(default_factory=dict)
    resumable: bool = True

    def play(self, motor: MachineMotor) -> int:
        """Return the play that a motor's smooth lines take up."""
        return self.backlash.get(motor.name, motor.backlash_steps) if motor.smooth else 0


@dataclass(frozen=True)
class AskedImage:
    """An image: how fast motors scan, how far others step or turn, in the load's direction.

    `image_at` is where the load is when the first line's image begins, in steps, by the motor;
    `backwards`: the first line runs in the negative direction.
    """

    image: ImageGeometry
    scans: Mapping[str, Quantity]
    steps: Mapping[str, int] = field(default_factory=dict)
    turns: Mapping[str, int] = field(default_factory=dict)
    still: Sequence[str] = ()
    source: SourceTable = field(default_factory=lambda: SourceTable(kind="image"))
    image_at: Mapping[str, int] = field(default_factory=dict)
    backwards: bool = False


@dataclass(frozen=True)
class NewJob:
    """A job that was made, and what is to be said of it."""

    job: Job
    notes: tuple[str, ...] = ()


def of_image(machine: MachineFile, wanted: AskedImage, asked: JobOptions) -> NewJob:
    """Return the job of an image. Raises UserError for what a motor cannot do."""
    _refuse_twice(machine, wanted)
    copies = Copies.of_machine(machine)
    scans = [_scan(machine, name, wanted, asked) for name in wanted.scans]
    steps = [_move(machine, name, far, (MOVE, LINE)) for name, far in wanted.steps.items()]
    turns = {name: _turn(machine, name, far) for name, far in wanted.turns.items()}
    first = image.layout(wanted.image, scans)
    found = image.roomy(first, steps)
    strokes = image.strokes_of(found, scans, steps, turns, _rest_px(machine, turns), wanted.still)
    made = {one.motor: one.ramp for one in scans}
    made |= {one.motor: one.ramp for one in (*steps, *turns.values())}
    abouts = {
        name: _about(machine, name, wanted, asked, copies, made.get(name)) for name in strokes
    }
    starts = _starts(machine, wanted, asked, found, scans)
    parts = {
        name: MotorPart(abouts[name], strokes[name], starts.get(name, 0))
        for name in machine.motors
        if name in strokes
    }
    common = _common(_line_table(found), wanted.source, copies, asked)
    notes = [note for scan in scans for note in scan.ramp.notes]
    notes += _notes(machine, first, found, turns)
    return NewJob(assemble(parts, image.places(found), common), tuple(notes))


def of_lines(
    machine: MachineFile, strokes: Mapping[str, Sequence[MotorStroke]],
    places: Sequence[ImagePlace], source: SourceTable, asked: JobOptions,
    files: Mapping[str, Mapping[str, Any]] | None = None,
) -> NewJob:  # fmt: skip
    """Return the job of lines that are there already, one a motor and place.

    `files` are what the files of motors' lines say of themselves, as job.toml has it.
    """
    copies = Copies.of_machine(machine)
    parts = {
        name: MotorPart(
            JobMotorTable(
                role="lines", decode=machine[name].kind, backlash=asked.play(machine[name]),
                profiles=copies.profiles(machine, name, asked.profiles.get(name)),
                **(files or {}).get(name, {}),
            ),
            strokes[name],
            asked.starts.get(name, 0),
        )
        for name in machine.motors
        if name in strokes
    }  # fmt: skip
    common = _common(JobLineTable(lines=0, pixels=0), source, copies, asked)
    return NewJob(assemble(parts, places, common))


def source_files(paths: Iterable[Path]) -> dict[str, str]:
    """Return the files that lines come from, with their sums."""
    return sums({path.name: path.read_bytes() for path in paths})


def _refuse_twice(machine: MachineFile, wanted: AskedImage) -> None:
    """Refuse a motor that is to do two things, and a job in which nothing scans or turns."""
    seen: set[str] = set()
    for name in (*wanted.scans, *wanted.steps, *wanted.turns, *wanted.still):
        _ = machine[name]  # names the motors that there are
        if name in seen:
            raise UserError(f"motor {name}: scans, steps, turns or stands still: one of them")
        seen.add(name)
    if not (wanted.scans or wanted.turns):
        raise UserError("an image needs a motor that scans, or one that turns")


def _scan(machine: MachineFile, name: str, wanted: AskedImage, asked: JobOptions) -> ScanMotor:
    motor = machine[name]
    top = _speed(machine, motor, wanted.scans[name])
    play = asked.play(motor)
    if play > top:
        raise UserError(f"motor {name}: backlash {play} does not fit one pixel at speed {top}")
    ramp = ramps.scanning(machine, motor, top, asked.profiles.get(name))
    return ScanMotor(name, ramp, not motor.smooth, play, motor.negative != wanted.backwards)


def _speed(machine: MachineFile, motor: MachineMotor, speed: Quantity) -> int:
    """Return a speed in steps/pixel. Raises UserError naming the motor and the nearest legal."""
    try:
        top = whole_speed(speed, machine.pixel_hz, motor.steps_per_unit, smooth=motor.smooth)
    except UserError as error:
        raise UserError(f"motor {motor.name}: {error}") from None
    if not 1 <= top <= MAX_SPEED + 1:  # an odd one just above it is refused with its neighbours
        raise UserError(f"motor {motor.name}: speed {top} is outside 1..{MAX_SPEED} steps/px")
    return top


def _move(machine: MachineFile, name: str, distance: int, uses: Sequence[str]) -> ImageMove:
    """Return a move of the load as the motor's."""
    motor = machine[name]
    steps = -distance if motor.negative else distance
    if not steps:
        raise UserError(
            AskedText("motor {name}: a move of 0 steps: {still} is for one that rests", name=name)
        )
    made = ramps.move(machine, motor, steps, uses)
    return ImageMove(name, made, motor.smooth and steps < 0)


def _turn(machine: MachineFile, name: str, distance: int) -> ImageMove:
    if machine[name].smooth:
        raise UserError(f"motor {name} is smooth: only a plain motor turns inside a line")
    return _move(machine, name, distance, (LINE, MOVE))


def _rest_px(machine: MachineFile, turns: Mapping[str, ImageMove]) -> int:
    """Return the pixels that turning motors rest in: one, or as long as their drivers need."""
    hz = machine.pixel_hz
    kinds = {machine.board_of(machine[name]).kind for name in turns}
    return max((capability.of(kind, hz).rest_px for kind in kinds), default=1)


def _starts(
    machine: MachineFile,
    wanted: AskedImage,
    asked: JobOptions,
    found: ImageLayout,
    scans: Sequence[ScanMotor],
) -> dict[str, int]:
    """Return where each motor is at the first line, in its own steps.

    A motor's position is that of its load after a move in the motor's negative direction; after one
    in the other direction the load is the play behind.
    """
    scanning = {scan.motor: scan for scan in scans}
    starts = {}
    for name in machine.motors:
        sign = -1 if machine[name].negative else 1
        place = asked.starts.get(name, sign * wanted.image_at.get(name, 0))
        if scan := scanning.get(name):
            way = -1 if scan.negative else 1
            if name in wanted.image_at and name not in asked.starts:
                place -= way * scan.travel(found.begin(back=False))
                place += scan.backlash if scan.negative else 0
            place += way * wanted.image.offset_forward
        starts[name] = place
    return starts


def _about(
    machine: MachineFile, name: str, wanted: AskedImage, asked: JobOptions, copies: Copies,
    ramp: RampFromRest | None,
) -> JobMotorTable:  # fmt: skip
    motor = machine[name]
    role, distance = _role(name, wanted)
    return JobMotorTable.model_validate({
        "role": role, "decode": motor.decode, "distance": distance,
        "speed": ramp.speed if ramp and name in wanted.scans else 0,
        "backlash": asked.play(motor) if name in wanted.scans else 0,
        "used": ramp.use if ramp else "",
        "profiles": copies.profiles(machine, name, asked.profiles.get(name)),
    })  # fmt: skip


def _role(name: str, wanted: AskedImage) -> tuple[str, int]:
    if name in wanted.scans:
        return "scan", 0
    if name in wanted.steps:
        return "step", wanted.steps[name]
    return ("turn", wanted.turns[name]) if name in wanted.turns else ("still", 0)


def _line_table(found: ImageLayout) -> JobLineTable:
    of = found.image
    return JobLineTable(
        lines=0, pixels=0, image_pixels=of.pixels, lead_in=of.lead_in, lead_out=of.lead_out,
        alternate=of.alternate, scan_offset_forward=of.offset_forward,
        scan_offset_back=of.offset_back,
    )  # fmt: skip


def _common(line: JobLineTable, source: SourceTable, copies: Copies, asked: JobOptions) -> Common:
    for path in asked.settings.values():
        values.read_file(path)  # names what is wrong with it
    settings = {
        board: copies.add(SETTINGS, path, f"{board}.toml") for board, path in asked.settings.items()
    }
    return Common(line, source, copies, asked.resumable, settings)


def _notes(
    machine: MachineFile, first: ImageLayout, found: ImageLayout, turns: Mapping[str, ImageMove]
) -> Iterator[str]:
    before, after = first.image, found.image
    for words, was, now in (
        ("lead-in", before.lead_in, after.lead_in), ("lead-out", before.lead_out, after.lead_out),
    ):  # fmt: skip
        if was != now:
            yield f"{words} {now} pixels instead of {was}: so long do the motors that step take"
    for name, move in turns.items():
        if advice := generator.slow_first_pixels(f"motor {name}", move.counts):
            yield advice
        if play := machine[name].backlash_steps:
            yield (
                f"motor {name} has a play of {play} steps, which no plain line takes up by itself "
                f"(`pixstep line compensate`)"
            )
