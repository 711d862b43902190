# SPDX-License-Identifier: MIT
"""One format into another: nothing is lost and no meaning is changed without being told so."""

import time
from dataclasses import dataclass, replace
from pathlib import Path

from pixstep import atomic
from pixstep.errors import AskedText, UserError
from pixstep.formats.files import encode
from pixstep.formats.findings import shown_path
from pixstep.formats.header import ProfileHeader
from pixstep.formats.motion import BARE, BLOCKS, FileBlock, MotionFile
from pixstep.formats.records import PRN_KIND, REGULAR, PrnFile


@dataclass(frozen=True)
class HeaderChanges:
    """Header fields to set; None leaves the one of the input."""

    name: str | None = None
    haps: int | None = None
    lead_in_px: int | None = None
    pixel_hz: str | None = None
    timestamp: str | None = None

    @property
    def given(self) -> dict[str, str | int]:
        """The fields that are set."""
        return {name: value for name, value in vars(self).items() if value is not None}


@dataclass(frozen=True)
class Conversion:
    """What to make, and what the user said may be lost or taken as the same."""

    to: str  # prn, csv or csb
    line: int | None = None
    plain: bool = False  # the motor is plain: a PRN's numbers are counts
    drop_header: bool = False
    changes: HeaderChanges = HeaderChanges()


def convert(
    file: PrnFile | MotionFile, request: Conversion
) -> tuple[PrnFile | MotionFile, tuple[str, ...]]:
    """Return the file in the format asked for and what is different in it, one sentence each.

    Raises UserError for what would be lost or mistaken without a word of the user's.
    """
    to_prn = request.to == PRN_KIND
    _check_options(isinstance(file, PrnFile), to_prn, request)
    ends = () if file.ends == REGULAR else (f"line ends were {file.ends.words}",)
    if isinstance(file, PrnFile):
        if to_prn:
            return PrnFile(file.values), ends
        file = MotionFile((FileBlock(file.values, len(file.values)),))
    else:
        file = _chosen(file, request)
    if not to_prn:
        made, notes = _to_motion(file, request)
        return made, ends + notes
    bare, notes = _without_header(file, "a PRN has none")
    return PrnFile(bare.values), ends + notes


@dataclass(frozen=True)
class Written:
    """A file that was written: its size in bytes, and what is different from its source."""

    lines: int
    values: int
    size: int
    notes: tuple[str, ...]


def write(file: PrnFile | MotionFile, source: Path, target: Path, request: Conversion) -> Written:
    """Write a file that was read from `source` in the format asked for; see `convert`."""
    try:
        made, notes = convert(file, request)
    except UserError as error:
        if str(error).startswith(shown_path(source)):
            raise
        raise UserError(
            AskedText("{path}: {error}", path=shown_path(source), error=error)
        ) from None
    data = encode(made, target)
    atomic.write_bytes(target, data)
    parts = (made,) if isinstance(made, PrnFile) else made.blocks
    return Written(len(parts), sum(len(part.values) for part in parts), len(data), notes)


def _check_options(from_prn: bool, to_prn: bool, request: Conversion) -> None:
    """Refuse what the options leave open or contradict."""
    if from_prn != to_prn and not request.plain:
        raise UserError(AskedText(
            "a PRN holds speeds for a smooth motor and counts for a plain one, a CSV or CSB counts "
            "for both: {decode} plain says that the motor is plain (for a smooth one, `pixstep "
            "line make` makes counts from speeds)"
        ))  # fmt: skip
    if request.changes.given and (to_prn or request.drop_header):
        raise UserError("header options are given, though the output has no header")
    if from_prn and (request.drop_header or request.line):
        raise UserError(
            AskedText("a PRN has neither a header nor lines: no {drop_header}, no {line}")
        )


def _chosen(file: MotionFile, request: Conversion) -> MotionFile:
    """Return the file with the asked-for line alone, or the only one if it must be one."""
    to_bare = request.to == PRN_KIND or request.drop_header
    if file.header and to_bare and not request.drop_header:
        raise UserError(AskedText("the header would be lost: {drop_header} says that it may"))
    if request.line is None and not to_bare:
        return file
    block = file.line(request.line)
    header = file.header and replace(file.header, lines=1)
    return replace(file, blocks=(block,), header=header)


def _to_motion(file: MotionFile, request: Conversion) -> tuple[MotionFile, tuple[str, ...]]:
    """Return a CSV or CSB with the header asked for."""
    made = replace(file, kind=request.to, ends=REGULAR, notes=())
    if request.drop_header:
        return _without_header(made, "--drop-header")
    if not request.changes.given:
        return made, ()
    if made.header:
        header = ProfileHeader(**{**vars(made.header), **request.changes.given})
        changed = ", ".join(request.changes.given)
        return replace(made, header=header), (f"header: {changed} changed",)
    changes = request.changes
    if changes.name is None or changes.pixel_hz is None:
        raise UserError(AskedText("a new header needs {header} NAME and {pixel_hz}"))
    header = ProfileHeader(
        timestamp=changes.timestamp or time.ctime(),
        name=changes.name,
        lines=1,
        haps=changes.haps or 0,
        lead_in_px=changes.lead_in_px or 0,
        pixel_hz=changes.pixel_hz,
    )
    return replace(made, header=header, reading=BLOCKS), (f"header {header.name!r} added",)


def _without_header(file: MotionFile, why: str) -> tuple[MotionFile, tuple[str, ...]]:
    """Return the values of one line alone."""
    if file.header is None:
        return file, ()
    values = file.values
    notes = [f"header {file.header.name!r} dropped: {why}"]
    if file.header.lines > 1:
        notes.append(f"that {file.header.lines} lines were announced is dropped with it")
    if file.blocks[0].truncated:
        announced = file.blocks[0].declared
        notes.append(f"{len(values)} values, that {announced} were announced is dropped with it")
    blocks = (FileBlock(values, len(values)),)
    return replace(file, header=None, reading=BARE, blocks=blocks), tuple(notes)
