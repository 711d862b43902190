# SPDX-License-Identifier: MIT
"""The log of a run: what was meant and what has happened, line by line, never a lie.

A line is 8 hexadecimal digits of CRC-32, a blank, JSON. It is on the disk before `add` returns. Its
last line may be torn, by a power cut: such a line is dropped, for nothing was done after it. A bad
line inside was changed by somebody, and the log is refused.

What the log of a run says of each line of its job.

printed     every board has confirmed its end, or a person has said `--skip`
in flight   it may have begun: its blocks may be on a board. At most two are
left        nothing of it was sent
"""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from pixstep.errors import RefusedError, UserError

BEGIN, CHAIN, QUEUED, DONE = "begin", "chain", "queued", "done"
LOST, PAUSED, STOPPED, FINISHED = "lost", "paused", "stopped", "finished"
RESUME, REDO, SKIP, HOMED, MOVED = "resume", "redo", "skip", "homed", "moved"
FOUND = "found"  # at a resume: what became of lines in flight, as the boards said
NOT_PRINTED, UNKNOWN = "not printed", "unknown"


@dataclass(frozen=True)
class Base:
    """An axis when a chain of lines began: its counters and its position."""

    unit: int
    axis: int
    lines_done: int
    next_block: int
    position_steps: int

    @classmethod
    def of(cls, data: dict[str, Any]) -> Base:
        """Return the axis of an event."""
        return cls(**{name: int(data[name]) for name in cls.__dataclass_fields__})


@dataclass
class History:
    """What a log tells. `chain` is the first line of the last chain, 0 before it begins.

    `bases` are the axes when it began, by motor. `found` is what boards have said of lines in
    flight, fate and text; `repeated` what was said of lines that may have been begun, and that were
    to be printed again.
    """

    lines: int
    printed: set[int] = field(default_factory=set)
    in_flight: list[int] = field(default_factory=list)
    chain: int = 0
    bases: dict[str, Base] = field(default_factory=dict)
    skipped: set[int] = field(default_factory=set)
    found: dict[int, tuple[str, str]] = field(default_factory=dict)
    repeated: dict[int, list[str]] = field(default_factory=dict)
    finished: bool = False
    last: Event = field(default_factory=dict)
    tags: dict[str, int] = field(default_factory=dict)  # of the boards, by name
    # How long the bus of a board may be silent: as it was before, and in this run.
    stored: dict[str, int] = field(default_factory=dict)
    silence_ms: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, events: Iterable[Event]) -> History:
        """Return what events tell."""
        found = cls(0)
        for event in events:
            found.take(event)
        return found

    def take(self, event: Event) -> None:
        """Take an event."""
        kind, line = event.get("event"), int(event.get("line", 0))
        if kind == FOUND:  # it changes nothing, but what is known
            told = event["lines"]
            self.found |= {one["line"]: (one["fate"], one["text"]) for one in told}
            return
        self.last = event
        if kind == BEGIN:
            self.lines = int(event["lines"])
            boards = event["boards"]
            self.tags = _of_boards(boards, "tag")
            self.stored = _of_boards(boards, "bus_timeout_ms")
            self.silence_ms = _of_boards(boards, "silence_ms")
            axes = (about["axes"] for about in boards.values())
            self.bases = {name: Base.of(data) for one in axes for name, data in one.items()}
        elif kind == CHAIN:
            self.chain, self.in_flight, self.found = line, [], {}
            self.bases = {name: Base.of(data) for name, data in event["axes"].items()}
        elif kind == MOVED:
            self.chain = 0
            self.bases = {name: Base.of(data) for name, data in event["axes"].items()}
        elif kind == QUEUED:
            self.in_flight.append(line)
        elif kind in (DONE, SKIP):
            self._settle(line)
            self.printed.add(line)
            if kind == SKIP:
                self.skipped.add(line)
        elif kind == REDO:
            self._settle(line)
            self._repeat(line, str(event.get("was", NOT_PRINTED)))
        elif kind == FINISHED:
            self.finished = True

    @property
    def twice(self) -> dict[int, str]:
        """Lines that were printed though they may have been begun before, and how that ended."""
        lines = sorted(self.printed - self.skipped)
        return {line: ", ".join(self.repeated[line]) for line in lines if line in self.repeated}

    @property
    def next_line(self) -> int:
        """The first line that is neither printed nor skipped; the one after the last at the end."""
        return next((n for n in range(1, self.lines + 1) if n not in self.printed), self.lines + 1)

    def state(self, *, is_running: bool) -> str:
        """How the run is: finished, running, paused or broken."""
        if self.finished:
            return "finished"
        if is_running:
            return "running"
        return PAUSED if self.last.get("event") == PAUSED else "broken"

    def _repeat(self, line: int, was: str) -> None:
        if was != NOT_PRINTED:
            self.repeated.setdefault(line, []).append(re.split(" of |:", was)[0])

    def _settle(self, line: int) -> None:
        if line in self.in_flight:
            self.in_flight.remove(line)


def _of_boards(boards: Mapping[str, Mapping[str, Any]], key: str) -> dict[str, int]:
    return {name: int(about[key]) for name, about in boards.items()}


try:
    import fcntl
except ImportError:  # Windows: two runs in one folder are not kept apart there
    fcntl = None  # type: ignore[assignment]

Event = dict[str, Any]
NAME = "log.jsonl"
_CRC_DIGITS = 8


class RunLog:
    """The log of a run that this process writes; nobody else may meanwhile."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path, self._handle = path, handle

    @classmethod
    def open(cls, path: Path) -> Self:
        """Open a log, a new one if there is none, and drop what is torn at its end.

        Raises RefusedError for a log that another process writes, and for a damaged one.
        """
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror or error}") from None
        try:
            if not _lock(handle):
                raise RefusedError(f"{path}: another process runs this job (`pixstep job status`)")
            _, good = _parsed(path, path.read_bytes())
            if good < os.fstat(handle).st_size:
                os.ftruncate(handle, good)
                os.fsync(handle)
            _sync_folder(path.parent)
        except BaseException:
            os.close(handle)
            raise
        return cls(path, handle)

    def add(self, event: Event) -> None:
        """Add an event; it is on the disk when this returns."""
        data = encoded(event)
        while data:
            data = data[_write(self._handle, data) :]
        _sync(self._handle)

    def close(self) -> None:
        """Give the log back."""
        os.close(self._handle)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def encoded(event: Mapping[str, Any]) -> bytes:
    """Return the line of an event."""
    text = json.dumps(event, separators=(",", ":"), ensure_ascii=False).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def read(path: Path) -> list[Event]:
    """Return the events of a log. Raises RefusedError for a line inside that is not as written."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    return _parsed(path, data)[0]


def is_written(path: Path) -> bool:
    """Return whether a process has the log open to write."""
    try:
        handle = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        return not _lock(handle)
    finally:
        os.close(handle)


def _parsed(path: Path, data: bytes) -> tuple[list[Event], int]:
    """Return the events of some bytes, and where the last good line ends."""
    rows = data.split(b"\n")
    whole, torn = rows[:-1], rows[-1]
    events: list[Event] = []
    good = 0
    for number, row in enumerate(whole, 1):
        event = _event(row)
        if event is None:
            if number == len(whole) and not torn:
                break
            raise RefusedError(f"{path}:{number}: damaged: its sum is not that of its text")
        events.append(event)
        good += len(row) + 1
    return events, good


def _event(row: bytes) -> Event | None:
    """Return the event of a line; None if its sum is wrong."""
    total, text = row[:_CRC_DIGITS], row[_CRC_DIGITS + 1 :]
    if total != b"%08x" % zlib.crc32(text) or row[_CRC_DIGITS : _CRC_DIGITS + 1] != b" ":
        return None
    try:
        event = json.loads(text)
    except ValueError:
        return None
    return event if isinstance(event, dict) else None


_write = os.write
_sync = getattr(os, "fdatasync", os.fsync)  # Windows and macOS have no fdatasync


def _lock(handle: int) -> bool:
    """Lock a file; False if another process has it."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _sync_folder(folder: Path) -> None:
    """Let a new file's name be on the disk, where the system can do that."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
