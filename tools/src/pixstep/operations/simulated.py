# SPDX-License-Identifier: MIT
"""What a simulated run gives back: its summary, its page, the files that it left."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from pixstep.operations.result import Page, Result
from pixstep.simulation import report

Summary = TypeVar("Summary", bound=report.Judged)


def result(summary: Summary, out: Path, write: Callable[[Page, Summary], None]) -> Result:
    """Return the summary of a run as a result; its page ends with the files in `out`."""

    def page(page: Page) -> None:
        write(page, summary)
        report.print_files(page, out)

    return Result(summary, page, report.exit_status(summary["verdict"]))
