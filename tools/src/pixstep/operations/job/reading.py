# SPDX-License-Identifier: MIT
"""The fields of a job and of a run, and their reading."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.lazy import require_package
from pixstep.operations.kinds import FILE, PATH
from pixstep.operations.request import argument

if TYPE_CHECKING:
    from pixstep.jobs.job import Job
    from pixstep.jobs.run_folder import RunFolder


def job_file() -> Any:
    """Return the field of a job."""
    return argument(FILE, shown="NAME.pxjob")


def read(path: Path) -> Job:
    """Return a job. Raises RefusedError for one that is not as it was made."""
    require_package("pyarrow")
    from pixstep.jobs.job import Job

    return Job.read(path)


def run_folder() -> Any:
    """Return the field of a run's folder."""
    return argument(PATH, shown="NAME.pxrun")


def opened(path: Path) -> tuple[RunFolder, Job]:
    """Return a run and its job. Raises UserError for what is no run."""
    require_package("pyarrow")
    from pixstep.jobs.job import Job
    from pixstep.jobs.run_folder import RunFolder

    folder = RunFolder.of(path)
    job = Job.read(folder.job_path)
    folder.require_job(job)
    return folder, job
