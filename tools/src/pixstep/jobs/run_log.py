# SPDX-License-Identifier: MIT
"""The log of a run: what was meant and what has happened, line by line, never a lie.

A line is 8 hexadecimal digits of CRC-32, a blank, JSON. It is on the disk before `add` returns. Its
last line may be torn, by a power cut: such a line is dropped, for nothing was done after it. A bad
line inside was changed by somebody, and the log is refused.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pixstep.errors import RefusedError, UserError

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
