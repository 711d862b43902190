# SPDX-License-Identifier: MIT
"""A folder for results (`--out`): only files that an earlier run has put there are replaced.

Which those are stands in the folder, in MARK, a name a line. A file of the user's stays: a run that
would have to replace one is refused.
"""

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path

from pixstep import atomic
from pixstep.errors import UserError

MARK = ".pixstep-results"


@contextlib.contextmanager
def of_run(out: Path, names: Iterable[str]) -> Iterator[None]:
    """Make room in a folder for the files that a run may write: `names`, without a path.

    The same files of an earlier run are removed, as they must not pass for this one's. Raises
    UserError if one of them was not written by a run.
    """
    wanted = sorted(set(names))
    with atomic.told_of(out):
        out.mkdir(parents=True, exist_ok=True)
        ours = _marked(out)
        _refuse_others(out, wanted, ours)
        for name in ours.intersection(wanted):
            (out / name).unlink(missing_ok=True)
        _mark(out, ours.union(wanted))
    try:
        yield
    finally:
        with atomic.told_of(out):
            _mark(out, {name for name in ours.union(wanted) if (out / name).is_file()})


def _refuse_others(out: Path, wanted: list[str], ours: set[str]) -> None:
    """Raise UserError for a file in the way that no run has written."""
    for name in wanted:
        path = out / name
        if name not in ours and (path.exists() or path.is_symlink()):
            raise UserError(
                f"{path}: is there already and is not of an earlier run: name another folder with "
                f"--out, or move it away"
            )


def _marked(out: Path) -> set[str]:
    """Return the names that are marked as written by a run."""
    try:
        rows = (out / MARK).read_text(encoding="utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return set()
    return {row for row in rows if row and row == Path(row).name}


def _mark(out: Path, names: set[str]) -> None:
    """Write the names; a folder without any has no mark."""
    if names:
        atomic.write_text(out / MARK, "".join(f"{name}\n" for name in sorted(names)))
    else:
        (out / MARK).unlink(missing_ok=True)
