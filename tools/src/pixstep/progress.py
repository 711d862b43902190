# SPDX-License-Identifier: MIT
"""How far something long is: told by what does it, shown on a terminal if somebody watches."""

import contextlib
import sys
from collections.abc import Callable, Iterator

Progress = Callable[[float], None]  # takes the share done, 0..1


def unseen(share: float) -> None:
    """Take the share done and show nothing."""
    del share


@contextlib.contextmanager
def shown(title: str) -> Iterator[Progress]:
    """Yield what takes the share done and shows it on the error stream, on a terminal only."""
    if not sys.stderr.isatty():
        yield unseen
        return
    from rich import progress as bars  # takes its time to load, which a script need not wait for
    from rich.console import Console

    columns = (
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.TimeRemainingColumn(),
    )
    bar = bars.Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(title, total=1.0)
    # A terminal that was closed is no reason to end, least of all instead of what ends the block.
    gone = contextlib.suppress(OSError)
    with gone:
        bar.start()
    try:
        yield lambda share: bar.update(task, completed=share)
    finally:
        with gone:
            bar.stop()
