# SPDX-License-Identifier: MIT
"""The reader's hands: answers to a command's questions, and commands typed at the bench.

A pipe is no terminal: what is typed is not echoed. The hands write it into the output themselves,
where a reader would see it.
"""

import errno
import os
import re
from collections import deque
from collections.abc import Generator, Iterator
from pathlib import Path

from pixstep.errors import UserError
from pixstep_dev.tutorial import document
from pixstep_dev.tutorial.document import Cue, TutorialStep

_ASKS = re.compile(r"\[[Yy]/[Nn]\]: \Z")


class Hands:
    """What is typed during a walk; `logs` has a log, a status and pipes for each step.

    One window at most may be opened beside the first: the bench.
    """

    def __init__(self, steps: tuple[TutorialStep, ...], logs: list[Path]):
        self._steps, self._logs = steps, logs
        self._pipes: list[int] = []
        self._bench: Path | None = None
        self._keys = -1
        self._read = 0  # of the bench's log
        self._due: deque[str] = deque()  # typed at the bench, not yet done by it
        for step, log in zip(steps, logs, strict=True):
            if step.typed_to:
                os.mkfifo(pipe_of(log))
            if step.window:
                self._bench = log
                self._keys = self._open(log, os.O_RDWR)

    def work(self) -> Iterator[None]:
        """Type what each step shows, in its turn; wait where this yields."""
        before: Path | None = None
        for step, log in zip(self._steps, self._logs, strict=True):
            found = document.cues(step)
            if found or step.before:
                while before and not status_of(before).exists():
                    yield
                yield from self._done_at_bench()
                for text in step.before:
                    yield from self._type_at_bench(text)
                yield from self._accompany(found, log)
            before = log

    def close(self) -> None:
        """Let go of all pipes."""
        while self._pipes:
            os.close(self._pipes.pop())

    def _accompany(self, found: list[Cue], log: Path) -> Iterator[None]:
        """Type at the cues of one command, which starts when its pipe is opened for writing."""
        waiting = deque(found)
        while waiting and waiting[0].bench and not waiting[0].after:
            yield from self._type_shown(waiting.popleft().text, log)
        read = len(_text(log))
        while (pipe := self._reader_of(log)) is None:
            yield
        for cue in waiting:
            seen = yield from _printed(cue, log, read)
            if not seen:
                break
            read = seen.end()
            if cue.bench:
                yield from self._type_shown(cue.text, log)
            else:
                _echo(log, cue.text)
                os.write(pipe, f"{cue.text}\n".encode())
        self._pipes.remove(pipe)
        os.close(pipe)

    def _type_shown(self, text: str, log: Path) -> Iterator[None]:
        """Type a command at the bench that stands in the output of another command."""
        _echo(log, f"{document.BENCH}{text}")
        yield from self._type_at_bench(text)

    def _type_at_bench(self, text: str) -> Iterator[None]:
        """Type a command at the bench, and wait until it is done unless an `until` is before it."""
        if self._bench is None:
            raise UserError(f"{document.BENCH}{text}: no window of a bench is open")
        os.write(self._keys, f"{text}\n".encode())
        self._due.append(text)
        if not any(item.startswith("until ") for item in self._due):
            yield from self._done_at_bench()

    def _done_at_bench(self) -> Iterator[None]:
        """Wait until the bench has printed all that was typed, each line behind its time."""
        while self._due and self._bench:
            done = re.compile(rf"^ *[0-9.]+ s  {re.escape(self._due[0])}\n", re.MULTILINE)
            text = _text(self._bench)
            if seen := done.search(text, self._read):
                self._read = seen.end()
                self._due.popleft()
                continue
            if ended_of(self._bench).exists():
                raise UserError(f"{self._due[0]}: the bench has ended: {text.splitlines()[-1:]}")
            yield

    def _reader_of(self, log: Path) -> int | None:
        """Open the pipe of a command that is at it; None if it is not yet."""
        try:
            return self._open(log, os.O_WRONLY | os.O_NONBLOCK)
        except OSError as error:
            if error.errno != errno.ENXIO:
                raise
        return None

    def _open(self, log: Path, how: int) -> int:
        self._pipes.append(os.open(pipe_of(log), how))
        return self._pipes[-1]


def pipe_of(log: Path) -> Path:
    """Return the standard input of a command that somebody types to."""
    return log.with_name(f"{log.name}.typed")


def status_of(log: Path) -> Path:
    """Return where the exit status of a step is, from its end on."""
    return log.with_name(f"{log.name}.status")


def ended_of(log: Path) -> Path:
    """Return what is there when the command of a window has ended."""
    return log.with_name(f"{log.name}.ended")


def _printed(cue: Cue, log: Path, read: int) -> Generator[None, None, re.Match[str] | None]:
    """Wait for what stands before a cue; None if the command ends, or asks something else."""
    pattern, last = re.compile(cue.after, re.MULTILINE), False
    while not (seen := pattern.search(_text(log), read)) and not last:
        last = status_of(log).exists() or _ASKS.search(_text(log), read) is not None
        yield
    return seen


def _text(log: Path) -> str:
    return log.read_text(encoding="utf-8", errors="replace") if log.exists() else ""


def _echo(log: Path, text: str) -> None:
    with log.open("a", encoding="utf-8") as stream:
        stream.write(f"{text}\n")
