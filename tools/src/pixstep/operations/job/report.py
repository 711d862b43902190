# SPDX-License-Identifier: MIT
"""The report of a run: one HTML file that tells how it went, and draws every line of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from pixstep import atomic
from pixstep.errors import FINE, NEGATIVE
from pixstep.operations.desk import Desk
from pixstep.operations.job.reading import opened, run_folder
from pixstep.operations.kinds import FILE, OUTPUT
from pixstep.operations.request import Request, operation, option
from pixstep.operations.result import Result

if TYPE_CHECKING:
    from pixstep.jobs.report.pixels import ReportFigures
    from pixstep.jobs.report.story import Story


class ReportedJob(TypedDict):
    """The report of a run: its verdict with a colour, green, blue, amber or red.

    `records` counts pixels of which the run has records, `measured` those that were measured.
    `worst_off_steps` is how far a motor was from where it should have been, `worst_error_ticks` how
    far an edge was off, at the most; `strange` counts records that expect another position than the
    job does.
    """

    run: str
    output: str
    bytes: int
    colour: str
    verdict: str
    records: int
    measured: int
    worst_off_steps: int
    worst_error_ticks: int
    strange: int


@operation("job report")
class JobReport(Request):
    """Write the report of a run: one HTML file, which needs no network.

    It begins with the verdict. Then come the comparison of the job with the machine, a map of the
    job line by pixel, and drawings of any line: speed, position, edge error; expected, actual and
    measured position. The page of a run that goes on loads itself again and again, and `pixstep
    watch --page` keeps its file new. Exit status 0; 1 if the report is amber or red.
    """

    result = ReportedJob

    run_path: Path = run_folder()
    output: Path | None = option(
        OUTPUT, "HTML file to write.", "-o", shown="FILE", default_text="NAME.html"
    )
    measured: Path | None = option(
        FILE, "What an encoder measured: a table (.csv, .parquet) of line, motor, pixel and "
        "measured_steps, positions as the boards count them.", shown="FILE",
    )  # fmt: skip

    def run(self, desk: Desk) -> Result:
        """Read the run and write its report."""
        output = self.output or Path(f"{self.run_path.resolve().stem}.html")
        data = write(self.run_path, output, self.measured)
        status = NEGATIVE if data["colour"] in ("amber", "red") else FINE
        return Result(data, f"{output}: {data['verdict']}", status)


def write(run: Path, output: Path, measured: Path | None = None) -> ReportedJob:
    """Write the report of a run into a file."""
    folder, job = opened(run)
    folder.require_outside(output)
    from pixstep.jobs.report import page, pixels
    from pixstep.jobs.report.story import Story

    story = Story.of(folder, job)
    figures = pixels.of_run(job, run, measured)
    text = page.text(story, figures, run.resolve().name)
    atomic.write_text(output, text)
    return _facts(run, output, len(text.encode()), story, figures)


def _facts(run: Path, output: Path, size: int, story: Story, figures: ReportFigures) -> ReportedJob:
    from pixstep.jobs.report import page

    return {
        "run": str(run), "output": str(output), "bytes": size,
        "colour": page.colour(story, figures), "verdict": story.verdict[1],
        "records": figures.records, "measured": figures.measured,
        "worst_off_steps": abs(figures.worst_off), "worst_error_ticks": figures.worst_error,
        "strange": figures.strange,
    }  # fmt: skip
