# SPDX-License-Identifier: MIT
"""What a simulated run says at its end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, TypeVar

from pixstep.cli.options import show_json
from pixstep.simulation import report

if TYPE_CHECKING:
    import rich.console


class Judged(TypedDict):
    """A summary that has a verdict."""

    verdict: str


Summary = TypeVar("Summary", bound=Judged)


def deliver(
    summary: Summary,
    out: Path,
    page: Callable[[rich.console.Console, Summary], None],
    *,
    as_json: bool,
) -> int:
    """Print a summary as JSON, or its page and the files in `out`; return the exit status."""
    if as_json:
        show_json(summary)
    else:
        console = report.new_console()
        page(console, summary)
        report.print_files(console, out)
    return report.exit_status(summary["verdict"])
