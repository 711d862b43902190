# SPDX-License-Identifier: MIT
"""Do the tasks of figures on all cores, and gather their rows."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from pixstep.bench.figure import Figure, Task, failures
from pixstep.errors import UserError

Progress = Callable[[float], None]


def measure(
    figures: Iterable[Figure],
    progress: Progress = lambda _: None,
    *,
    executor: Callable[[], Executor] | None = None,
) -> dict:
    """Return {"figures": {name: rows}, "failures": [...], "wall_s": seconds}.

    Tasks run side by side, those that want to be alone afterwards one by one; rows keep the order
    of the tasks. `progress` is called with the share of tasks done.
    """
    started = time.monotonic()
    figures = list(figures)
    tasks = [task for figure in figures for task in figure.tasks()]
    rows: dict[int, list[dict]] = {}
    with (executor or _cores)() as pool:
        for index, found in _finished(pool, tasks):
            rows[index] = found
            progress(len(rows) / len(tasks))
    result: dict[str, list[dict]] = {figure.name: [] for figure in figures}
    for index, task in enumerate(tasks):
        result[task.figure] += rows[index]
    wrong = [text for found in result.values() for text in failures(found)]
    return {"figures": result, "failures": wrong, "wall_s": round(time.monotonic() - started, 1)}


def _finished(pool: Executor, tasks: list[Task]):
    """Yield (index, rows) of every task as it ends; an error of one ends all."""
    together = {
        pool.submit(task.work, *task.arguments): index
        for index, task in enumerate(tasks)
        if not task.alone
    }
    try:
        for future in as_completed(together):
            yield together[future], future.result()
        for index, task in enumerate(tasks):
            if task.alone:
                yield index, pool.submit(task.work, *task.arguments).result()
    except BrokenProcessPool:
        raise UserError("a measuring process was ended from outside") from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _cores() -> Executor:
    """Return a pool of one process a core. They are spawned, not forked: the progress bar has a
    thread. Ctrl-C is for the command alone, which then ends them.
    """
    return ProcessPoolExecutor(
        max_workers=len(os.sched_getaffinity(0)),
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),
    )
