# SPDX-License-Identifier: MIT
"""What a simulated run says at its end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.cli.options import show_json
from pixstep.simulation import report

if TYPE_CHECKING:
    import rich.console


def deliver(
    summary: dict, out: Path, page: Callable[[rich.console.Console, dict], None], *, as_json: bool
) -> int:
    """Print a summary as JSON, or its page and the files in `out`; return the exit status."""
    if as_json:
        show_json(summary)
    else:
        console = report.new_console()
        page(console, summary)
        report.print_files(console, out)
    return report.exit_status(summary)
