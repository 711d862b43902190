# SPDX-License-Identifier: MIT
"""The field of a job, and its reading."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.lazy import require_package
from pixstep.operations.kinds import FILE
from pixstep.operations.request import argument

if TYPE_CHECKING:
    from pixstep.jobs.job import Job


def job_file() -> Any:
    """Return the field of a job."""
    return argument(FILE, shown="NAME.pxjob")


def read(path: Path) -> Job:
    """Return a job. Raises RefusedError for one that is not as it was made."""
    require_package("pyarrow")
    from pixstep.jobs.job import Job

    return Job.read(path)
