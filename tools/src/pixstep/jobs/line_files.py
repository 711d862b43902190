# SPDX-License-Identifier: MIT
"""Files of lines as a job: one a motor, with the backlash and lead-in of its header."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from pixstep import formats
from pixstep.errors import UserError
from pixstep.formats import MotionFile
from pixstep.jobs.assembly import ImagePlace, MotorStroke
from pixstep.jobs.header import SourceTable
from pixstep.jobs.making import JobOptions, NewJob, of_lines, source_files
from pixstep.lines.line import PLAIN, Line
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable
from pixstep.profiles import own_backlash
from pixstep.profiles.own_backlash import AskedBacklash


def of_files(
    machine: MachineFile, paths: Mapping[str, Path], asked: JobOptions, *, alternate: bool = True
) -> NewJob:
    """Return the job of files of lines, one a motor; a file of one line is that line each time.

    The counts of a smooth motor have no sign: they run forth and back if they `alternate`. The
    image begins as the header of a file says that has a lead-in.
    """
    read = {machine[name].name: formats.read_motion(path) for name, path in paths.items()}
    count = max(len(file.blocks) for file in read.values())
    strokes = {name: _strokes(machine[name], read[name], count, alternate) for name in read}
    own, notes = _own_backlash(machine, read, asked)
    images = [_image_pixels(machine[name], file, own) for name, file in read.items()]
    places = [ImagePlace(max(one[k % len(one)] for one in images)) for k in range(count)]
    source = SourceTable(kind="lines", files=source_files(paths.values()))
    made = of_lines(machine, strokes, places, source, own)
    return replace(made, notes=(*notes, *(note for file in read.values() for note in file.notes)))


def _strokes(motor: MotorTable, file: MotionFile, count: int, alternate: bool) -> list[MotorStroke]:
    if len(file.blocks) not in (1, count):
        raise UserError(
            f"{file.path}: holds {len(file.blocks)} lines, others have {count}: equally many are "
            f"wanted, or one that is used for all"
        )
    blocks = file.blocks * count if len(file.blocks) == 1 else file.blocks
    back = [alternate and number % 2 == 1 for number in range(count)]
    return [
        MotorStroke(tuple(block.values), motor.smooth and motor.negative != turned)
        for block, turned in zip(blocks, back, strict=True)
    ]


def _own_backlash(
    machine: MachineFile, read: Mapping[str, MotionFile], asked: JobOptions
) -> tuple[JobOptions, list[str]]:
    """Return the play that each motor's lines take up: what is asked, the file's, the machine's."""
    plays, notes = dict(asked.backlash), []
    for name, file in read.items():
        wanted = AskedBacklash(asked.play(machine[name]), name in asked.backlash, str(machine.path))
        counts, kind = file.blocks[0].values, machine[name].decode
        plays[name], said = own_backlash.taken(file.path, file.header, counts, kind, wanted)
        notes += said
    return replace(asked, backlash=plays), notes


def _image_pixels(motor: MotorTable, file: MotionFile, asked: JobOptions) -> list[int]:
    """Return the first pixel of the image in each line of a file; 0 where nothing says it."""
    lead_in = file.header.lead_in_px if file.header else 0
    if not lead_in or motor.decode == PLAIN:
        return [0] * len(file.blocks)
    found = []
    for block in file.blocks:
        line = Line(tuple(block.values), motor.decode, asked.play(motor))
        first = line.speeds.index(line.line_speed) + 1 if line.line_speed else 0
        found.append(first + lead_in if first else 0)
    return found
