# SPDX-License-Identifier: MIT
"""What a simulated run says at its end."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from pixstep.cli.options import show_json
from pixstep.simulation import report


def deliver(
    summary: dict, out: Path, page: Callable[[Console, dict], None], *, as_json: bool
) -> int:
    """Print a summary as JSON, or its page and the files in `out`; return the exit status."""
    if as_json:
        show_json(summary)
    else:
        console = Console(highlight=False)
        page(console, summary)
        report.print_files(console, out)
    return report.exit_status(summary)
