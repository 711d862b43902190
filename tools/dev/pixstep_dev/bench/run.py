# SPDX-License-Identifier: MIT
"""Do the tasks of figures on all cores, and gather their rows."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep_dev.bench.figure import BenchFigure, Task, failures

_left = threading.Event()  # in a worker: Ctrl-C was pressed


def measure(
    figures: Iterable[BenchFigure],
    progress: Progress = unseen,
    *,
    boards: Sequence[str] = (),
    executor: Callable[[], Executor] | None = None,
) -> dict[str, Any]:
    """Return {"figures": {name: rows}, "failures": [...], "not_measured": [...], "wall_s": s}.

    Tasks run side by side, those that want to be alone afterwards one by one; rows keep the order
    of the tasks. `boards` are those measured, none: all. What a task could not measure leaves out
    its rows and says why. `progress` is called with the share of tasks done.
    """
    started = time.monotonic()
    figures = list(figures)
    tasks = [
        task for figure in figures for task in figure.tasks() if not boards or task.board in boards
    ]
    rows: dict[int, list[dict[str, Any]]] = {}
    lacks: list[str] = []
    with (executor or _cores)() as pool:
        for index, future in _finished(pool, tasks):
            try:
                rows[index] = future.result()
            except BrokenProcessPool:
                raise UserError("a measuring process was ended from outside") from None
            except UserError as error:
                rows[index] = []
                lacks.append(f"{tasks[index].figure}: {error}")
            progress(len(rows) / len(tasks))
    result: dict[str, list[dict[str, Any]]] = {figure.name: [] for figure in figures}
    for index, task in enumerate(tasks):
        result[task.figure] += rows[index]
    return {
        "figures": result,
        "failures": [text for found in result.values() for text in failures(found)],
        "not_measured": lacks,
        "wall_s": round(time.monotonic() - started, 1),
    }


def merged(results: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return several results as one, the rows of each figure in the order of the results."""
    names = [name for result in results for name in result["figures"]]
    return results[0] | {
        "figures": {
            name: [row for result in results for row in result["figures"].get(name, ())]
            for name in dict.fromkeys(names)
        },
        "failures": [text for result in results for text in result["failures"]],
        "not_measured": [text for result in results for text in result["not_measured"]],
    }


def _finished(pool: Executor, tasks: list[Task]) -> Iterator[tuple[int, Future[Any]]]:
    """Yield every task's index and future as it ends; leaving early cancels the rest."""
    together = {pool.submit(_do, task): index for index, task in enumerate(tasks) if not task.alone}
    try:
        for future in as_completed(together):
            yield together[future], future
        for index, task in enumerate(tasks):
            if task.alone:
                future = pool.submit(_do, task)
                wait([future])
                yield index, future
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _cores() -> Executor:
    """Return a pool of one process a core; spawned, not forked: the progress bar has a thread."""
    return ProcessPoolExecutor(
        max_workers=len(os.sched_getaffinity(0)),
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, _leave),
    )


def _leave(number: int, frame: object) -> None:
    """On Ctrl-C a worker drops its task without a word; its simulator and files go with it."""
    del number, frame
    _left.set()
    raise SystemExit(1)


def _do(task: Task) -> list[dict[str, Any]]:
    """Do a task; a worker that was left does not begin those already handed to it."""
    return [] if _left.is_set() else task.work(*task.arguments)
