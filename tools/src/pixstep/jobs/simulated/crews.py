# SPDX-License-Identifier: MIT
"""Who simulates blocks: processes of this computer, or the workers of a Dask cluster.

Both give futures of `concurrent.futures`. A process that dies is replaced, and what it had is given
to another one.
"""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

from pixstep.errors import AskedText, UserError, one_line
from pixstep.jobs.simulated import cuts, work
from pixstep.jobs.simulated.cuts import Tools
from pixstep.jobs.simulated.work import Answer
from pixstep.lazy import lazy, require_package

if TYPE_CHECKING:
    import distributed
else:
    distributed = lazy("distributed")

_CONNECT_S = 10.0
_ALONE_S = 60.0  # without a worker, after which nobody waits for one any more
_COUNT_S = 5.0  # after which workers are counted again
_AHEAD = 2  # blocks that each worker has, so that none waits for the next one


class LostError(UserError):
    """Nobody is left who simulates blocks."""


class Crew(Protocol):
    """Who simulates blocks."""

    local: bool

    @property
    def width(self) -> int:
        """How many are given out at once, at most."""

    def submit(self, data: bytes, edges: str) -> Future[Answer]:
        """Give a block to somebody."""

    def renew(self) -> None:
        """Begin anew after one has died: nothing is under way any more."""

    def look(self, waited_s: float) -> None:
        """Raise LostError if nobody is left, after so long without an answer."""


class _Processes:
    """Processes of this computer."""

    local = True

    def __init__(self, count: int) -> None:
        self._count, self.width = count, _AHEAD * count
        self._pool = self._begin()

    def _begin(self) -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self._count, mp_context=context, initializer=_begin_process)

    def submit(self, data: bytes, edges: str) -> Future[Answer]:
        try:
            with _own_main():  # processes begin as blocks come
                return self._pool.submit(work.simulate, data, edges)
        except BrokenProcessPool as error:  # one has died since the last answer
            lost: Future[Answer] = Future()
            lost.set_exception(error)
            return lost

    def renew(self) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._pool = self._begin()

    def look(self, waited_s: float) -> None:
        del waited_s

    def end(self) -> None:
        """End all processes, whatever they do; none is left, nor anything that waits for one."""
        processes = [*(self._pool._processes or {}).values()]
        for process in processes:
            process.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)


@contextlib.contextmanager
def _own_main() -> Iterator[None]:
    """Let processes begin without the program that calls.

    They would run it again, to know what it defines. They need none of it, and a script that
    simulates as it is run would begin more of them.
    """
    before = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = before


def _begin_process() -> None:
    """Let a process leave Ctrl-C to the one that made it, and end with that one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@contextlib.contextmanager
def processes(count: int) -> Iterator[Crew]:
    """Yield so many processes of this computer."""
    crew = _Processes(count)
    try:
        yield crew
    finally:
        crew.end()


class _Cluster:
    """The workers of a Dask cluster, which may become more or fewer."""

    local = False

    def __init__(self, address: str, client: Any) -> None:
        self._address, self._client = address, client
        self._executor: Executor = client.get_executor(pure=False)
        self._threads, self._counted_s = 0, -_COUNT_S

    @property
    def width(self) -> int:
        """Blocks at once at most, by the workers that there are."""
        if time.monotonic() - self._counted_s >= _COUNT_S:
            self._threads, self._counted_s = self._count(), time.monotonic()
        return _AHEAD * max(1, self._threads)

    def _count(self) -> int:
        if self._client.status != "running":
            raise self._lost("is gone")
        return sum(self._client.nthreads().values())

    def submit(self, data: bytes, edges: str) -> Future[Answer]:
        return self._executor.submit(work.simulate, data, edges)

    def renew(self) -> None:
        """Do nothing: the scheduler gives what a worker had to another one."""

    def look(self, waited_s: float) -> None:
        if not self._count() and waited_s > _ALONE_S:
            raise self._lost(f"has had no workers for {waited_s:.0f} s")

    def _lost(self, why: str) -> LostError:
        return LostError(_told_of(self._address, why))


@contextlib.contextmanager
def cluster(address: str, wanted: Tools, kinds: tuple[str, ...]) -> Iterator[Crew]:
    """Yield the workers of a Dask cluster, once each has said that it has the same tools.

    Raises UserError naming a worker that has others, or a scheduler that does not answer.
    """
    require_package("distributed")
    with _quiet():
        try:
            # A client of no address at all would try to close for long. distributed has no types.
            distributed.comm.addressing.get_address_host_port(address)
            client: Any = distributed.Client(  # type: ignore[no-untyped-call]
                address, timeout=_CONNECT_S, set_as_default=False
            )
        except (OSError, ValueError, TypeError) as error:
            why = one_line(str(error)) or type(error).__name__
            raise UserError(_told_of(address, why)) from None
        try:
            _require_same(address, client, wanted, kinds)
            yield _Cluster(address, client)
        finally:
            client.close(timeout=5)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Let Dask write nothing besides: what goes wrong is raised."""
    _ = distributed.Client  # its loggers are there once it is loaded
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    loggers = [logging.getLogger(name) for name in names]
    before = [one.disabled for one in loggers]
    for one in loggers:
        one.disabled = True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of other versions of Dask's packages
            yield
    finally:
        for one, disabled in zip(loggers, before, strict=True):
            one.disabled = disabled


def _require_same(address: str, client: Any, wanted: Tools, kinds: tuple[str, ...]) -> None:
    """Raise UserError naming each worker that has other tools."""
    names = {at: about["name"] for at, about in client.scheduler_info(-1)["workers"].items()}
    if not names:
        raise UserError(_told_of(address, "has no workers"))
    told = []
    for at, found in client.run(cuts.tools_here, kinds, on_error="return").items():
        if isinstance(found, BaseException):
            why = one_line(str(found)) or type(found).__name__
        else:
            why = cuts.tool_differences(wanted, found)
        if why:
            told.append(f"worker {names.get(at, '')} at {at}: {why}")
    if told:
        raise cuts.OtherToolsError(_told_of(address, "; ".join(told)))


def _told_of(address: str, what: str) -> AskedText:
    return AskedText("{scheduler} {address}: {what}", address=address, what=what)
