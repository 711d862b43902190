# SPDX-License-Identifier: MIT
"""The lines of a job as files again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from pixstep import formats, outfolder
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN
from pixstep.operations import shared
from pixstep.operations.desk import Desk
from pixstep.operations.job.reading import job_file, read
from pixstep.operations.kinds import FOLDER, TEXT
from pixstep.operations.request import Request, operation, option
from pixstep.operations.result import Result
from pixstep.profiles import origin

if TYPE_CHECKING:
    from pixstep.jobs.job import Job


class ExportedJob(TypedDict):
    """Files of lines that were written: one a motor, each with all lines."""

    job: str
    lines: int
    files: list[str]


@operation("job export")
class JobExport(Request):
    """Write the lines of a job as files again: a CSV a motor, with all lines or with one.

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
