# SPDX-License-Identifier: MIT
"""Look into a job: its lines, also as files again, and the configuration that it carries."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

from pixstep import atomic, formats, outfolder
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN
from pixstep.lines.units import hz_words
from pixstep.operations import shared
from pixstep.operations.desk import Desk
from pixstep.operations.job.reading import job_file, read
from pixstep.operations.kinds import FOLDER, TEXT
from pixstep.operations.request import Request, operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import origin
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    from pixstep.jobs.job import Job
    from pixstep.jobs.shapes import MotorRun


class ExportedJob(TypedDict):
    """Files of lines that were written: one a motor, each with all lines."""

    job: str
    lines: int
    files: list[str]


@operation("job export")
class JobExport(Request):
    """Write the lines of a job as files again: a CSV for each motor, with all lines or one.

    A file has a header with the frequency of pixels and the backlash of its lines. Counts of a
    smooth motor have no sign: which lines run backwards is in `job show --line N`.
    """

    result = ExportedJob

    job: Path = job_file()
    line_number: int | None = shared.line_number("Line N alone.")
    motors: tuple[str, ...] = option(
        TEXT, "Motor; again for more.", "--of", many=True, shown="NAME", default_text="all",
    )  # fmt: skip
    out: Path = option(FOLDER, "Folder for the files: NAME.csv.", required=True)

    def run(self, desk: Desk) -> Result:
        """Read the job and write its lines."""
        found = read(self.job)
        chosen = self.motors or found.motors
        numbers = range(1, found.lines + 1) if self.line_number is None else [self.line_number]
        names = {name: f"{_plain(name)}.csv" for name in chosen}
        with outfolder.of_run(self.out, names.values()) as folder:
            for name, file in names.items():
                formats.write_motion(folder / file, _motion(found, name, numbers))
        files = [str(self.out / file) for file in names.values()]
        data = {"job": str(self.job), "lines": len(numbers), "files": files}
        return Result(data, "\n".join(f"{path}: {len(numbers)} lines" for path in files))


def _plain(name: str) -> str:
    """Return a motor's name as that of a file."""
    return "".join(sign if sign.isalnum() or sign in "-_." else "_" for sign in name)


def _motion(job: Job, name: str, numbers: range | list[int]) -> formats.MotionFile:
    """Return the lines of a motor as a file."""
    if name not in job.motors:
        raise UserError(f"{job.path}: there is no motor {name!r}: {', '.join(job.motors)}")
    lines = [job.line(number)[name].counts for number in numbers]
    about = job.header.motors[name]
    play = None if about.decode == PLAIN else about.backlash
    title = origin.plain_name(Path(_plain(name)))
    header = origin.header(title, job.header.line.lead_in, job.pixel_hz, play)
    return formats.of_lines(lines, header)


_PIXELS_SHOWN = 12  # of a line, at either end


class JobMotor(TypedDict):
    """A motor of a job: distances in steps, its speed in steps/px."""

    motor: str
    role: str
    decode: str
    backlash: int
    speed: int
    distance: int
    shapes: int
    start_steps: int
    end_steps: int


class MotorLine(TypedDict):
    """What a motor makes in a line: counts, positions at the pixels' end edges, in steps."""

    motor: str
    decode: str
    backlash: int
    negative: bool
    start_steps: int
    play_side: str
    image_pixel: int
    purpose: str
    counts: list[int]
    expected: list[int]


class ShownJob(TypedDict):
    """What is in a job; `line` is there if one was asked for."""

    file: str
    id: str
    bytes: int
    made_at: str
    made_by: str
    source: str
    lines: int
    pixels: int
    image_pixels: int
    lead_in: int
    lead_out: int
    alternate: bool
    scan_offset_forward: int
    scan_offset_back: int
    resumable: bool
    pixel_hz: str
    seconds: float
    motors: list[JobMotor]
    line: NotRequired[list[MotorLine]]


@operation("job show")
class JobShow(Request):
    """Show what is in a job: lines, motors, times, shapes; with --line one line of it.

    The file is proved first: one that differs in a byte from what was made is refused.
    """

    result = ShownJob

    job: Path = job_file()
    line_number: int | None = shared.line_number("Line N: counts and positions of each motor.")

    def run(self, desk: Desk) -> Result:
        """Read the job and show it."""
        found = read(self.job)
        data = _shown(found)
        if self.line_number is not None:
            data["line"] = [
                _motor_line(found, name, run)
                for name, run in found.runs_of(self.line_number).items()
            ]
        return Result(data, partial(_write, data, self.line_number), value=found)


class JobFile(TypedDict):
    """A file that a job carries along; `text` is its content, None if that is no text."""

    name: str
    bytes: int
    sha256: str
    text: str | None


class JobConfiguration(TypedDict):
    """What a job was made with: what it says of itself, and the user's files in it."""

    file: str
    header: dict[str, Any]
    files: list[JobFile]


@operation("job show-config")
class JobShowConfig(Request):
    """Show what a job was made with: its parameters, the machine file and the profiles in it.

    With --out these files are written into a folder as they were, byte for byte.
    """

    result = JobConfiguration

    job: Path = job_file()
    out: Path | None = option(FOLDER, "Write the machine file and the profiles into a folder.")

    def run(self, desk: Desk) -> Result:
        """Read the job and show its configuration."""
        found = read(self.job)
        files = [_file(name, data) for name, data in found.copies.items()]
        told: JobConfiguration = {
            "file": str(self.job),
            "header": found.header.model_dump(mode="json", by_alias=True, exclude={"sha256"}),
            "files": files,
        }
        if self.out is not None:
            written = {_flat(name): data for name, data in found.copies.items()}
            with outfolder.of_run(self.out, written) as folder:
                for name, data in written.items():
                    atomic.write_bytes(folder / name, data)
        return Result(told, partial(_write_configuration, found, self.out), value=found)


def _flat(name: str) -> str:
    """Return a member's name in a folder: the machine file and its profiles beside each other."""
    folder, _, file = name.rpartition("/")
    return f"{folder}-{file}" if folder == "settings" else file


def _shown(job: Job) -> ShownJob:
    about, line = job.header, job.header.line
    return {
        "file": str(job.path),
        "id": about.id,
        "bytes": job.path.stat().st_size,
        "made_at": about.made.at.isoformat(),
        "made_by": about.made.by,
        "source": about.source.kind,
        "lines": job.lines,
        "pixels": job.pixels,
        "image_pixels": line.image_pixels,
        "lead_in": line.lead_in,
        "lead_out": line.lead_out,
        "alternate": line.alternate,
        "scan_offset_forward": line.scan_offset_forward,
        "scan_offset_back": line.scan_offset_back,
        "resumable": about.resumable,
        "pixel_hz": hz_words(job.pixel_hz),
        "seconds": round(job.seconds, 3),
        "motors": [_motor(job, name) for name in job.motors],
    }


def _motor(job: Job, name: str) -> JobMotor:
    about = job.header.motors[name]
    return {
        "motor": name,
        "role": about.role,
        "decode": about.decode,
        "backlash": about.backlash,
        "speed": about.speed,
        "distance": about.distance,
        "shapes": len({key for key, _ in job.shapes_of(name)}),
        "start_steps": job.runs_of(1)[name].start_steps,
        "end_steps": job.expected(job.lines, name)[-1],
    }


def _motor_line(job: Job, name: str, run: MotorRun) -> MotorLine:
    made = job.line(run.line)[name]
    return {
        "motor": name,
        "decode": made.decode,
        "backlash": made.backlash,
        "negative": made.negative,
        "start_steps": run.start_steps,
        "play_side": run.play_side,
        "image_pixel": run.image_pixel,
        "purpose": run.purpose,
        "counts": list(made.counts),
        "expected": list(job.expected(run.line, name)),
    }


def _file(name: str, data: bytes) -> JobFile:
    try:
        text: str | None = data.decode("utf-8")
    except UnicodeDecodeError:
        text = None
    sha256 = hashlib.sha256(data).hexdigest()
    return {"name": name, "bytes": len(data), "sha256": sha256, "text": text}


def _write(data: ShownJob, number: int | None, page: Page) -> None:
    """Write the facts of a job, its motors, and one line if it was asked for."""
    for text in _facts(data):
        page.tell(text)
    table = new_table(
        "motor", "role", "kind", "backlash", "speed", "distance", "shapes", "from", "to"
    )
    for row in data["motors"]:
        table.add_row(
            row["motor"], row["role"], row["decode"], str(row["backlash"]), str(row["speed"]),
            str(row["distance"]), str(row["shapes"]), str(row["start_steps"]),
            str(row["end_steps"]),
        )  # fmt: skip
    page.draw(table)
    page.tell("backlash, distance, from, to in steps; speed in steps/px")
    for one in data.get("line", ()):
        _write_line(page, one, number or 0)


def _facts(data: ShownJob) -> Iterator[str]:
    yield f"{data['file']}: {data['lines']} lines of {data['pixels']} pixels, id {data['id'][:16]}"
    yield (
        f"made {data['made_at']} by pixstep {data['made_by']} of {data['source']}; "
        f"{data['seconds']:g} s at {data['pixel_hz']} Hz, {data['bytes']} bytes"
    )
    if data["image_pixels"]:
        way = "forth and back" if data["alternate"] else "one way, each with a return"
        yield (
            f"image of {data['image_pixels']} pixels, lead-in {data['lead_in']}, lead-out "
            f"{data['lead_out']}, {way}, scan offsets {data['scan_offset_forward']} and "
            f"{data['scan_offset_back']} steps"
        )
    if not data["resumable"]:
        yield "not resumable: a job that is broken off begins again"


def _write_line(page: Page, row: MotorLine, number: int) -> None:
    way = ", backwards" if row["negative"] else ""
    image = f", image from pixel {row['image_pixel']}" if row["image_pixel"] else ""
    image = ", a return without an image" if row["purpose"] == "return" else image
    side = f", moved {row['play_side']} last" if row["play_side"] else ""
    page.tell(
        f"line {number}, motor {row['motor']}: {row['decode']}{way}{image}; from "
        f"{row['start_steps']}{side}"
    )
    table = new_table("pixel", "steps", "expected")
    count = len(row["counts"])
    for pixel in range(count):
        if count > 2 * _PIXELS_SHOWN and pixel == _PIXELS_SHOWN:
            table.add_row("...", "", "")
        if _PIXELS_SHOWN <= pixel < count - _PIXELS_SHOWN:
            continue
        table.add_row(str(pixel + 1), str(row["counts"][pixel]), str(row["expected"][pixel]))
    page.draw(table)


def _write_configuration(job: Job, out: Path | None, page: Page) -> None:
    """Write job.toml without its sums, the machine file, and what else is in the job."""
    about = job.header.model_copy(update={"sha256": {}})
    page.tell(about.text().partition("\n[sha256]")[0])
    for name, data in job.copies.items():
        page.tell(f"# {name}, {len(data)} bytes")
        if name.endswith(".toml"):
            page.tell(data.decode("utf-8", "replace"))
    if out is not None:
        page.tell(f"{out}: {len(job.copies)} files written")
