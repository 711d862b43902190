# SPDX-License-Identifier: MIT
"""Print a job: compared, armed once, its lines without a gap, every line logged."""

from __future__ import annotations

from pathlib import Path

from pixstep.operations.desk import Desk
from pixstep.operations.job import buses, printing
from pixstep.operations.job.printing import Prints, RunOfJob
from pixstep.operations.job.reading import job_file, read
from pixstep.operations.kinds import PATH
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result


@operation("job run")
class JobRun(Prints):
    """Print a job on the boards of the machine file.

    The job is compared first: red is refused, amber wants a yes or --accept-amber. The first line
    begins on the pixel clock, of several boards on the same edge; each board chains the others
    without a gap, and one line is queued ahead. The folder NAME.pxrun has the log: a line counts as
    printed when every board says so by counter and position. Ctrl-C pauses at the end of the line
    after the one that moves, a second one stops at once. `pixstep job resume` goes on.
    """

    result = RunOfJob
    needs_machine = True

    job: Path = job_file()
    folder: Path | None = option(
        PATH, "Folder of the run.", shown="NAME.pxrun", default_text="the job's name"
    )
    to_start: bool = flag("Bring motors to where line 1 begins, which are elsewhere.")

    def run(self, desk: Desk) -> Result:
        """Compare the job, begin a run, print."""
        job, found = read(self.job), buses.today(desk.facts)
        from pixstep.jobs import positioning
        from pixstep.jobs.history import History
        from pixstep.jobs.parts import Parts
        from pixstep.jobs.run_folder import SUFFIX, RunFolder
        from pixstep.jobs.session import JobSession, elsewhere
        from pixstep.jobs.stations import of_job

        path = self.folder or Path(self.job.name).with_suffix(SUFFIX)
        RunFolder.refuse_other(path, job)
        machine = found.tables
        with buses.opened(desk, machine, self.port, self.timeout) as bus_of:
            told = self.compare(desk, job, found, bus_of)
            stations = of_job(job, machine, bus_of)
            away = positioning.off(job, 1, stations)
            if away and not self.to_start:
                raise elsewhere(away)
            folder = RunFolder.begin(path, job)
            with folder.log() as log, printing.watched(desk, lambda: folder.pause_asked) as watch:
                parts = Parts(path) if self.records else None
                session = JobSession(job, machine, stations, log, History(0), watch, parts)
                if self.time_gaps:
                    session.time_gaps()
                session.begin(told, safe=printing.safe(job, machine))
                try:
                    return printing.make(session, path, may_move=self.to_start)
                finally:
                    folder.forget_pause()
