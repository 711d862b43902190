# SPDX-License-Identifier: MIT
"""Output files appear whole or not at all: written beside their place, then renamed.

A link stays and its file is replaced. A device, a FIFO and the standard output (also as "-") are
written to. Everything that the system refuses is a UserError naming the file. Under `rules`, a file
that exists is replaced only if the user says so, and an input never.

The process that makes an unfinished file or folder holds a lock on it. A process that is killed
cannot tidy up, but its lock ends with it: the next process that writes into the same folder finds
and removes what is left.
"""

import contextlib
import errno
import json
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path

from pixstep.errors import AskedText, UserError

try:
    import fcntl
except ImportError:  # Windows: nothing is locked there, and nothing is removed for others
    fcntl = None  # type: ignore[assignment]

UNFINISHED = ".pixstep-part-"


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
        if self.path.is_dir() and not self.path.is_symlink():
            shutil.rmtree(self.path, ignore_errors=True)
        else:
            with contextlib.suppress(OSError):
                self.path.unlink()
        self.release()


def unfinished_file(folder: Path, suffix: str = "") -> Part:
    """Make an empty file in a folder."""
    sweep(folder)
    while True:
        handle, name = tempfile.mkstemp(prefix=UNFINISHED, suffix=suffix, dir=folder)
        os.close(handle)
        part = _locked(Path(name))
        if part:
            return part


def unfinished_folder(folder: Path) -> Part:
    """Make an empty folder in a folder."""
    sweep(folder)
    while True:
        part = _locked(Path(tempfile.mkdtemp(prefix=UNFINISHED, dir=folder)))
        if part:
            return part


def sweep(folder: Path) -> None:
    """Remove from a folder what processes that are gone have left."""
    if fcntl is None:
        return
    with contextlib.suppress(OSError):
        for path in [path for path in folder.iterdir() if path.name.startswith(UNFINISHED)]:
            with contextlib.suppress(OSError):  # another process has the lock of this one
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


STDOUT = Path("-")
_LONGEST_SUFFIX = 8  # of a name that says a format; a longer one could make the name too long
_waiting: ContextVar[list[tuple[Part, Path]] | None] = ContextVar("waiting", default=None)


@dataclass(frozen=True)
class WriteRules:
    """What may be replaced: existing files only with `force`, the command's inputs never."""

    force: bool = False
    inputs: tuple[Path, ...] = ()


_rules: ContextVar[WriteRules | None] = ContextVar("rules", default=None)


@contextlib.contextmanager
def rules(new: WriteRules) -> Iterator[None]:
    """Hold the block to rules; without any a library's caller may write where it likes."""
    token = _rules.set(new)
    try:
        yield
    finally:
        _rules.reset(token)


@contextlib.contextmanager
def inputs(more: Iterable[Path]) -> Iterator[None]:
    """Hold the block to the rules in force, with more inputs; without rules nothing is held."""
    found = _rules.get()
    if found is None:
        yield
        return
    with rules(replace(found, inputs=(*found.inputs, *more))):
        yield


def forced() -> bool:
    """Whether the user says that existing files may be replaced."""
    found = _rules.get()
    return found is not None and found.force


def refuse(target: Path) -> None:
    """Raise UserError if the rules forbid to write a target."""
    found = _rules.get()
    if found is None or is_stdout(target):
        return
    for path in found.inputs:
        with contextlib.suppress(OSError):
            if target.samefile(path) and path.is_file():
                raise UserError(f"{target}: is the input: name another file for the output")
    if not found.force and target.is_file():
        raise UserError(AskedText("{path}: already exists ({force} replaces it)", path=target))


@contextlib.contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yield a temporary path beside `target`; rename it into place if the block succeeds.

    The folder is made if it is missing. On an exception the temporary file is removed and the
    old `target`, if any, stays as it was.
    """
    target = Path(target)
    with told_of(target):
        place = _place(target)
        part = _part(target, place)
    try:
        with told_of(target, part.path):
            yield part.path
            if place:
                part.path.chmod(_mode(place))
                _rename(part, target, place)
            else:
                _pour(part.path, target)
    except BaseException:
        part.remove()
        raise
    if place is None:
        part.remove()


@contextlib.contextmanager
def together() -> Iterator[None]:
    """Let the files that are written in the block appear at its end, all of them or none."""
    waiting: list[tuple[Part, Path]] = []
    token = _waiting.set(waiting)
    try:
        yield
        for part, place in waiting:
            with told_of(place):
                part.path.replace(place)
    finally:
        _waiting.reset(token)
        for part, _ in waiting:
            part.remove()


@contextlib.contextmanager
def told_of(target: Path, *instead: Path) -> Iterator[None]:
    """Raise UserError naming `target` for what the system refuses to do with it.

    `instead` are files that stand for it. A broken pipe is left to the caller.
    """
    try:
        yield
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise
        named = Path(os.fsdecode(error.filename or target))
        mine = named in (target, *instead) or named.name.startswith(UNFINISHED)
        where = "" if mine else f" ({named})"
        reason = error.strerror or str(error)
        if isinstance(error, FileExistsError):  # where a folder is to be made
            reason = os.strerror(errno.ENOTDIR)
        raise UserError(f"{target}: {reason}{where}") from None


def is_stdout(target: Path | None) -> bool:
    """Whether a target is this program's standard output: by name, or as /dev/stdout."""
    if target is None or target == STDOUT:
        return target is not None
    try:
        return os.path.samestat(target.stat(), os.fstat(1))
    except OSError:
        return False


def is_stream(target: Path) -> bool:
    """Whether a target is no file but can be written to: the standard output, a device, a FIFO."""
    if is_stdout(target):
        return True
    try:
        return _is_sink(target.stat().st_mode)
    except OSError:
        return False


def write_bytes(target: Path, data: bytes) -> None:
    """Write `data` to `target` atomically."""
    with replacing(target) as temporary:
        temporary.write_bytes(data)


def write_text(target: Path, text: str) -> None:
    """Write UTF-8 `text` to `target` atomically, line ends as given."""
    write_bytes(target, text.encode("utf-8"))


def write_json(target: Path, value: object) -> None:
    """Write `value` as indented JSON to `target` atomically."""
    write_text(target, json.dumps(value, indent=2) + "\n")


def write_with(target: Path, writer: Callable[[Path], object]) -> None:
    """Let `writer(path)` make the file at a temporary path, then rename it to `target`."""
    with replacing(target) as temporary:
        writer(temporary)


def _place(target: Path) -> Path | None:
    """Return where the file of a target is, links followed; None for what can only be written to.

    Makes its folder.
    """
    if is_stdout(target):
        return None
    place = Path(os.path.realpath(target))
    if place.exists():
        kind = target.stat().st_mode
        if _is_sink(kind):
            return None
        if not stat.S_ISREG(kind):
            what = "a folder" if stat.S_ISDIR(kind) else "no file"
            raise UserError(f"{target}: is {what}: nothing can be written there")
        refuse(target)
    elif target.is_symlink() and not place.parent.is_dir():
        raise UserError(f"{target}: is a link to {place}, whose folder is not there")
    make_folder(place.parent, target)
    return place


def make_folder(folder: Path, target: Path | None = None) -> None:
    """Make a folder for `target`, and those that it lies in, if they are not there.

    Raises UserError if one of them would lie at the root of the system, where only the system's own
    folders are: a path that is mistyped ("/run1" for "run1") would leave one there.
    """
    missing = Path.cwd() / folder
    while not os.path.lexists(missing) and not os.path.lexists(missing.parent):
        missing = missing.parent
    if not os.path.lexists(missing) and missing.parent == Path(missing.anchor):
        raise UserError(
            f"{target or folder}: there is no folder {missing}, and none is made at the root of "
            f"the system: make it first, or name another"
        )
    folder.mkdir(parents=True, exist_ok=True)


def _is_sink(mode: int) -> bool:
    return stat.S_ISCHR(mode) or stat.S_ISFIFO(mode)


def _part(target: Path, place: Path | None) -> Part:
    """Make an empty file beside a place, or for a stream; a format is told by its suffix."""
    if place is None:  # a drawing takes its format from the suffix
        suffix = target.suffix if target.suffix in (".svg", ".pdf") else ".png"
        return unfinished_file(Path(tempfile.gettempdir()), suffix)
    suffix = place.suffix if len(os.fsencode(place.suffix)) <= _LONGEST_SUFFIX else ""
    return unfinished_file(place.parent, suffix)


def _rename(part: Part, target: Path, place: Path) -> None:
    """Put a file into its place, or note that it is to be put there with others."""
    refuse(target)  # somebody may have made it meanwhile
    waiting = _waiting.get()
    if waiting is None:
        part.path.replace(place)
        part.release()
    else:
        with contextlib.suppress(FileNotFoundError):
            place.lstat()  # raises the system's error for a name that no file can have
        waiting.append((part, place))


def _pour(temporary: Path, target: Path) -> None:
    """Write a file's bytes to what is no file."""
    if is_stdout(target):
        if sys.stdout is None:
            raise OSError(errno.EBADF, "the standard output is closed")
        import click  # takes its time to load, which a script need not wait for

        click.echo(temporary.read_bytes(), nl=False)
        return
    with temporary.open("rb") as source, target.open("wb") as sink:
        shutil.copyfileobj(source, sink)


def _mode(place: Path) -> int:
    """Return the access rights that a file has, or that a new one gets."""
    with contextlib.suppress(FileNotFoundError):
        return stat.S_IMODE(place.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
