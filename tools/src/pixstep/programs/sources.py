# SPDX-License-Identifier: MIT
"""Where the counts of a plan come from while it runs: this process, or one of their own.

Planning the first window of a program takes longer than a board's queue lasts. In a process of its
own it keeps no board waiting; the pipe between both holds it back when it is far ahead.
"""

import pickle
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any, Protocol, Self, TextIO

import numpy as np

from pixstep.errors import PlainError, UserError
from pixstep.programs.motors import Setup
from pixstep.programs.options import Options
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan

_MODULE = "pixstep.programs.planner"
_TOGETHER = 2048  # pixels in a message
_MESSAGES = 16  # that wait to be taken
COUNTS, ERROR, END = "counts", "error", "end"


class Source(Protocol):
    """Counts of pixels, a row each, as they are planned."""

    over: bool
    """True when all have been taken."""

    def more(self, *, wait: bool) -> Counts | None:
        """Return some more counts; None at the end, and without `wait` if none is planned yet.

        Raises UserError for a mistake in the program.
        """


class Here:
    """A plan that is made when its counts are asked for."""

    def __init__(self, plan: Plan) -> None:
        self.over = False
        self._parts = plan.counts()

    def more(self, *, wait: bool) -> Counts | None:
        """Plan some more."""
        del wait
        part = next(self._parts, None)
        self.over = part is None
        return part


@dataclass(frozen=True)
class Request:
    """A program file and how it is to be planned."""

    path: str
    setup: Setup
    options: Options

    def text(self) -> TextIO:
        """Open the program; wrong bytes become characters that no statement has.

        Raises UserError if that fails.
        """
        try:
            return Path(self.path).open(encoding="utf-8", errors="replace")
        except OSError as error:
            raise UserError(f"{self.path}: {error.strerror}") from None

    def parts(self) -> Iterator[Counts]:
        """Yield the counts of the plan, not many at a time."""
        with self.text() as text:
            for part in Plan(self.path, text, self.setup, self.options).counts():
                for first in range(0, len(part), _TOGETHER):
                    yield part[first : first + _TOGETHER]


class PlanProcess:
    """A plan that another process makes: `with PlanProcess(request) as source:`."""

    def __init__(self, request: Request) -> None:
        self.over = False
        self._request = request
        self._messages: Queue[tuple[str, Any]] = Queue(_MESSAGES)
        self._closed = False

    def __enter__(self) -> Self:
        # In a session of its own Ctrl-C does not reach it: this process ends it.
        self._process = subprocess.Popen(
            [sys.executable, "-m", _MODULE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        try:
            pipe = self._process.stdin
            assert pipe is not None
            pickle.dump(self._request, pipe)  # it stays open: its end is the process's, too
            pipe.flush()
            self._reader = Thread(target=self._read, daemon=True)
            self._reader.start()
        except BaseException:
            self._process.kill()
            self._process.wait()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._closed = True
        self._process.kill()
        while self._reader.is_alive():
            self.more(wait=False)  # makes room for what the reader holds
            self._reader.join(0.01)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()

    def more(self, *, wait: bool) -> Counts | None:
        """Return counts that the process has made."""
        if self.over:
            return None
        try:
            kind, found = self._messages.get(block=wait)
        except Empty:
            return None
        if kind == COUNTS:
            return np.asarray(found, dtype=np.int64)
        self.over = True
        if kind == ERROR and not self._closed:
            raise found
        return None

    def _read(self) -> None:
        """Take the messages of the process; a process that ends without a word is an error."""
        assert self._process.stdout is not None
        kind = COUNTS
        while kind == COUNTS:
            try:
                kind, found = pickle.load(self._process.stdout)
            except (EOFError, OSError, pickle.UnpicklingError):
                kind, found = ERROR, PlainError(f"{self._request.path}: the planner has ended")
            self._messages.put((kind, found))
