# SPDX-License-Identifier: MIT
"""Check a profile under every reading that its file allows.

A CSV after a header holds blocks (line number, number of values, values) or bare rows, and a smooth
motor decodes it smoothly when homing but plainly in a fast move. A PRN holds speeds at pixel ends
for a smooth motor and counts for a plain one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from pixstep import formats
from pixstep.errors import RefusedError, UserError
from pixstep.formats.files import recognise
from pixstep.formats.records import PRN_KIND
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import ERROR, WARNING, Finding, Limits
from pixstep.profiles import generator
from pixstep.profiles.repair import START, whole_line

PRN, BLOCK, ROWS = "prn", "block", "rows"


@dataclass(frozen=True)
class ProfileRows:
    """One way to read the rows of a file: the values, or why they cannot be read so."""

    form: str
    values: tuple[int, ...] | None
    problem: str = ""
    adopted: bool = True


@dataclass(frozen=True)
class ProfileFile:
    """A profile file with all readings of its rows, the adopted one first."""

    path: Path
    rows: tuple[ProfileRows, ...]
    header: formats.ProfileHeader | None = None
    notes: tuple[str, ...] = ()

    @property
    def values(self) -> tuple[int, ...]:
        """The values of the adopted reading. Raises UserError if it does not fit the file."""
        if self.rows[0].values is None:
            raise RefusedError(self.rows[0].problem)
        return self.rows[0].values

    @property
    def is_prn(self) -> bool:
        """True for 8 columns."""
        return self.rows[0].form == PRN


@dataclass(frozen=True)
class ProfileReading:
    """A file read in one way: form of the rows, decode rule, and what was found.

    The decode rule is empty where the rows cannot be read in that form.
    """

    rows: ProfileRows
    decode: str
    findings: tuple[Finding, ...]

    @property
    def sound(self) -> bool:
        """True if a motor can follow it."""
        return self.rows.values is not None and not line_check.refused(list(self.findings))


def load(path: Path, *, raw: bool = False, lenient: bool = False) -> ProfileFile:
    """Read a PRN (by its width or suffix) or CSV profile. Raises UserError as the readers do."""
    if looks_like_prn(path):
        values, notes = formats.read_prn(path, lenient=lenient)
        return ProfileFile(path, (ProfileRows(PRN, tuple(values)),), notes=tuple(notes))
    read = formats.read_motion(path, raw=True)
    every = ProfileRows(ROWS, read.values)
    found = [every]
    if read.header:
        found = [_block(path), every]
    elif len(read.values) > 2 and read.values[:2] == (1, len(read.values) - 2):
        found.append(ProfileRows(BLOCK, read.values[2:]))
    if raw:
        found.sort(key=lambda rows: rows.form != ROWS)
    rows = tuple(replace(rows, adopted=number == 0) for number, rows in enumerate(found))
    return ProfileFile(path, rows, read.header, read.notes)


def looks_like_prn(path: Path) -> bool:
    """True for a .PRN file, or one that has a PRN's content."""
    if path.suffix.lower() in (".prn", ".csv"):
        return path.suffix.lower() == ".prn"
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    return recognise(data).kind == PRN_KIND


def check(profile: ProfileFile, motor: str | None, limits: Limits) -> list[ProfileReading]:
    """Return all readings with their findings.

    `motor` is smooth or plain; None if it is not known, then both rules count.
    """
    decodes = (PLAIN,) if motor == PLAIN else (SMOOTH, PLAIN)
    if profile.is_prn and motor == SMOOTH:
        decodes = (SMOOTH,)
    readings = []
    for rows in profile.rows:
        if rows.values is None:
            readings.append(ProfileReading(rows, "", ()))
            continue
        for decode in decodes:
            findings = tuple(_findings(profile, rows.form, rows.values, decode, limits))
            readings.append(ProfileReading(rows, decode, findings))
    return readings


def exit_status(readings: list[ProfileReading]) -> int:
    """Return 2 if no adopted reading is sound, 1 if one has findings or the form is ambiguous."""
    adopted = [reading for reading in readings if reading.rows.adopted]
    if not any(reading.sound for reading in adopted):
        return 2
    return int(ambiguous(readings) or any(reading.findings for reading in adopted))


def ambiguous(readings: list[ProfileReading]) -> bool:
    """True if all rows are taken as values although they fit a block that is sound too."""
    return any(
        reading.sound and reading.rows.form == BLOCK and not reading.rows.adopted
        for reading in readings
    )


def _block(path: Path) -> ProfileRows:
    try:
        return ProfileRows(BLOCK, formats.read_motion(path).values)
    except UserError as error:
        return ProfileRows(BLOCK, None, str(error))


def _findings(
    profile: ProfileFile, form: str, values: tuple[int, ...], decode: str, limits: Limits
) -> Iterator[Finding]:
    if decode == PLAIN:
        yield from _plain_findings(values, limits)
    elif form == PRN:
        yield from _speed_findings(values, limits)
    else:
        yield from _count_findings(values, limits)
    if profile.header and profile.header.haps > len(values):
        text = f"HAPs {profile.header.haps}, but there are {len(values)} values"
        yield Finding("haps", WARNING, 0, text)


def _speed_findings(speeds: tuple[int, ...], limits: Limits) -> Iterator[Finding]:
    """Check speeds at pixel ends, and the line that they make."""
    wrong = [Finding("speed", ERROR, number, text)
             for number, text in generator.speed_problems(speeds)]  # fmt: skip
    if not wrong and speeds[-1] > generator.MAX_SPEED:
        text = f"speed {speeds[-1]} is above {generator.MAX_SPEED}"
        wrong.append(Finding("out_of_range", ERROR, len(speeds), text))
    yield from wrong
    if not wrong:
        starts = (0, *speeds[:-1])
        counts = [(low + high) // 2 for low, high in zip(starts, speeds, strict=True)]
        yield from _count_findings(tuple(counts), limits)


def _count_findings(counts: tuple[int, ...], limits: Limits) -> Iterator[Finding]:
    """Check counts decoded smoothly: up, then held; the mirrored end adds nothing new."""
    line = Line(whole_line(counts, START))
    found = line_check.without_idle_pixel(line_check.check(line, limits))
    found = [item for item in found if item.pixel <= len(counts) + 1]
    yield from found
    if line_check.refused(found):
        return
    for pixel, (low, high) in enumerate(pairwise(line.speeds[: len(counts) + 1]), 1):
        if high < low and not any(item.pixel <= pixel for item in found):
            text = f"the speed falls from {low} to {high}: a profile rises, is this a whole line?"
            yield Finding("falls", ERROR, pixel, text)
            return


def _plain_findings(counts: tuple[int, ...], limits: Limits) -> Iterator[Finding]:
    """Check counts decoded plainly: each is the speed of its pixel and may not fall."""
    # A profile goes on at its last speed: the stop that the line check would see is not there.
    still = replace(limits, max_acceleration=None, jerk_warning=None)
    yield from line_check.check(Line(counts, PLAIN), still)
    previous, change = 0, 0
    for pixel, count in enumerate(counts, 1):
        step = count - previous
        if count < 0 or step < 0:
            text = f"the speed falls from {previous} to {count}"
            yield Finding("falls", ERROR, pixel, text)
            return
        if limits.max_acceleration and step > limits.max_acceleration:
            text = f"acceleration {step} is above {limits.max_acceleration}"
            yield Finding("acceleration", ERROR, pixel, text)
        if limits.jerk_warning is not None and abs(step - change) > limits.jerk_warning:
            text = f"the acceleration changes by {abs(step - change)}"
            yield Finding("jerk", WARNING, pixel, text)
        previous, change = count, step
