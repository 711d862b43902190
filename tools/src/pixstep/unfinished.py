# SPDX-License-Identifier: MIT
"""Files and folders of work in progress, which lie beside the place that the work is for.

The process that makes one holds a lock on it. A process that is killed cannot tidy up, but its lock
ends with it: the next process that writes into the same folder finds and removes what is left.
"""

import contextlib
import errno
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: nothing is locked there, and nothing is removed for others
    fcntl = None  # type: ignore[assignment]

PREFIX = ".pixstep-part-"


@dataclass(frozen=True)
class Part:
    """A file or folder in progress, and the descriptor that holds its lock."""

    path: Path
    lock: int | None

    def release(self) -> None:
        """Give the lock up."""
        if self.lock is not None:
            os.close(self.lock)

    def remove(self) -> None:
        """Remove what is still there, and give the lock up."""
        _remove(self.path)
        self.release()


def file(folder: Path, suffix: str = "") -> Part:
    """Make an empty file in a folder."""
    sweep(folder)
    while True:
        handle, name = tempfile.mkstemp(prefix=PREFIX, suffix=suffix, dir=folder)
        os.close(handle)
        part = _locked(Path(name))
        if part:
            return part


def directory(folder: Path) -> Part:
    """Make an empty folder in a folder."""
    sweep(folder)
    while True:
        part = _locked(Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder)))
        if part:
            return part


def sweep(folder: Path) -> None:
    """Remove from a folder what processes that are gone have left."""
    if fcntl is None:
        return
    with contextlib.suppress(OSError):
        for path in [path for path in folder.iterdir() if path.name.startswith(PREFIX)]:
            _sweep_one(path)


def _sweep_one(path: Path) -> None:
    """Remove a file or folder whose process is gone."""
    with contextlib.suppress(OSError):
        lock = _lock(path)
        if lock is not None:
            Part(path, lock).remove()


def _locked(path: Path) -> Part | None:
    """Lock what was just made; None if a sweep was quicker than the lock."""
    if fcntl is None:
        return Part(path, None)
    try:
        lock = _lock(path)
    except BlockingIOError:
        return None
    if lock is not None and not path.exists():
        os.close(lock)
        return None
    return Part(path, lock)


def _lock(path: Path) -> int | None:
    """Return a descriptor that holds the lock, None where the file system has no locks.

    Raises BlockingIOError if another process holds it.
    """
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(handle)
        if error.errno in (errno.EAGAIN, errno.EACCES):
            raise
        return None
    return handle


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            path.unlink()
