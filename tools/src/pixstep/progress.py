# SPDX-License-Identifier: MIT
"""Progress on the terminal's error stream; silent when nobody watches."""

import contextlib
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

_errors = Console(stderr=True)


@contextlib.contextmanager
def shown(title: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the share done (0..1) and shows it, on a terminal only."""
    if not _errors.is_terminal:
        yield lambda _: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    progress = Progress(*columns, console=_errors, transient=True)
    task = progress.add_task(title, total=1.0)
    # A terminal that was closed is no reason to end, least of all instead of what ends the block.
    gone = contextlib.suppress(OSError)
    with gone:
        progress.start()
    try:
        yield lambda share: progress.update(task, completed=share)
    finally:
        with gone:
            progress.stop()
