# SPDX-License-Identifier: MIT
"""A folder for results (`--out`): a run replaces only what an earlier run has left there.

Which files those are stands in the folder, in MARK, each with its SHA-256. A file that the user put
there or edited stays: a run that would have to replace it is refused, unless the user says --force.
A run's files appear together at its end; a run that fails or is killed leaves the folder as it was.
"""

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from pixstep import atomic
from pixstep.errors import AskedText, UserError

MARK = ".pixstep-results"
_Sums = Mapping[str, set[str]]  # the SHA-256 that a run may have left, by name


@contextlib.contextmanager
def of_run(out: Path, names: Iterable[str]) -> Iterator[Path]:
    """Yield an empty folder; what the block leaves there goes to `out` at its end.

    `names` are all files, without a path, that the run may leave; an earlier run's that this one
    does not leave are removed from `out`, as they must not pass for this one's. Raises UserError if
    one of them is not as a run left it.
    """
    wanted = sorted(set(names))
    with atomic.told_of(out):
        fresh = not out.exists()
        atomic.make_folder(out)
        _refuse_others(out, wanted, _marked(out))
        part = atomic.unfinished_folder(out)
    try:
        yield part.path
        with atomic.told_of(out):
            _deliver(part.path, out, wanted)
    except UserError as error:  # names a file by the place where it should have been
        if str(part.path) not in str(error):
            raise
        raise type(error)(str(error).replace(str(part.path), str(out))) from None
    finally:
        part.remove()
        if fresh:
            with contextlib.suppress(OSError):  # of a folder with results
                out.rmdir()


def _deliver(made: Path, out: Path, wanted: list[str]) -> None:
    """Move a run's files to their places.

    A mark for the old and the new files goes before them, so that whatever is in the folder when
    this process is killed is known as a run's.
    """
    before = _marked(out)
    _refuse_others(out, wanted, before)  # the run may have taken long
    new = {path.name: {_sum(path)} for path in made.iterdir() if path.is_file()}
    _mark(out, {name: before.get(name, set()) | new.get(name, set()) for name in {*before, *new}})
    for name in wanted:
        if name in new:
            (made / name).replace(os.path.realpath(out / name))
        else:
            (out / name).unlink(missing_ok=True)
    _mark(out, {name: before[name] for name in before if name not in wanted} | new)


def _refuse_others(out: Path, wanted: list[str], ours: _Sums) -> None:
    """Raise UserError for a file in the way that is not as a run left it."""
    for name in wanted:
        path = out / name
        if not (path.exists() or path.is_symlink()):
            continue
        if path.exists() and not path.is_file():
            raise UserError(f"{path}: is not a file: nothing can be written there")
        if name in ours and not path.is_symlink() and _sum(path) in ours[name]:
            continue
        if not atomic.forced():
            raise UserError(AskedText(
                "{path}: already exists and is not as an earlier run left it: name another "
                "folder with {out}, or say {force}",
                path=path,
            ))  # fmt: skip
        atomic.refuse(path)


def _sum(path: Path) -> str:
    import hashlib

    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _marked(out: Path) -> dict[str, set[str]]:
    """Return what runs have left."""
    try:
        rows = (out / MARK).read_text(encoding="utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return {}
    found: dict[str, set[str]] = {}
    for total, _, name in (row.partition("  ") for row in rows):
        if name and name == Path(name).name:
            found.setdefault(name, set()).add(total)
    return found


def _mark(out: Path, sums: _Sums) -> None:
    """Write the mark, in the form that sha256sum reads; a folder without results has none."""
    rows = [f"{total}  {name}\n" for name in sorted(sums) for total in sorted(sums[name])]
    if not rows:
        (out / MARK).unlink(missing_ok=True)
        return
    with atomic.rules(atomic.WriteRules(force=True)):
        atomic.write_text(out / MARK, "".join(rows))
