# SPDX-License-Identifier: MIT
"""Read and write whole files: what other modules use."""

from collections.abc import Sequence
from pathlib import Path

from pixstep import atomic
from pixstep.errors import UserError
from pixstep.formats.csb import encode_csb
from pixstep.formats.csvtext import encode_csv
from pixstep.formats.examine import examine
from pixstep.formats.findings import LENIENT, STRICT, Rules, shown_path
from pixstep.formats.header import ProfileHeader
from pixstep.formats.motion import CSB_KIND, CSV_KIND, MotionFile, of_lines
from pixstep.formats.prn import KIND as PRN_KIND
from pixstep.formats.prn import PrnFile

# A CSV that was edited and saved with LF is worth a note, not a refusal.
_EDITED = Rules(line_ends=True)


def read_any(path: Path, *, lenient: bool = False, raw: bool = False) -> PrnFile | MotionFile:
    """Read a PRN, CSV or CSB, recognised by its content.

    Strictly, unless `lenient` tolerates LF, a missing final newline and a truncated line, each with
    a note. `raw` takes every row after a header as a value. Raises UserError naming file, line,
    column and value.
    """
    return examine(path, LENIENT if lenient else STRICT, raw=raw).required()


def read_prn(path: Path, *, lenient: bool = False) -> tuple[list[int], list[str]]:
    """Read an acceleration profile: unsigned, right-aligned in 8 columns, CR LF.

    Return the values and the notes. `lenient` accepts LF and a missing final newline and says so
    in the notes. Raises UserError naming file, line, column and value for anything else.
    """
    read = examine(path, LENIENT if lenient else STRICT, kinds=(PRN_KIND,)).required()
    return list(read.values), list(read.notes)


def read_motion(
    path: Path, *, raw: bool = False, lenient: bool = False, strict: bool = False
) -> MotionFile:
    """Read a CSV or CSB of one line or many, bare or after a header.

    After a header the data are blocks of line number, number of values, values; `raw` takes every
    row as a value. Line ends may be LF, with a note, unless `strict`; `lenient` accepts a block
    that ends early as well. Raises UserError naming file, line, column and value.
    """
    return _read(path, (CSV_KIND, CSB_KIND), raw, lenient, strict)


def read_csv(path: Path, *, raw: bool = False, lenient: bool = False) -> MotionFile:
    """Read a CSV of one line as `read_motion` does; many lines are refused."""
    read = _read(path, (CSV_KIND,), raw, lenient, False)
    read.line()
    return read


def write_prn(path: Path, values: Sequence[int]) -> None:
    """Write a profile, one value a record, right-aligned in 8 columns, CR LF."""
    _require_values(path, values)
    atomic.write_bytes(path, PrnFile(tuple(values)).encode(path))


def write_csv(path: Path, counts: Sequence[int], header: ProfileHeader | None = None) -> None:
    """Write one count per record, right-aligned in 6 columns, CR LF; after `header` if given."""
    _require_values(path, counts)
    write_motion(path, of_lines([counts], header))


def write_motion(path: Path, file: MotionFile) -> None:
    """Write a CSV or CSB, whichever `file.kind` says."""
    atomic.write_bytes(path, encode(file, path))


def encode(file: PrnFile | MotionFile, path: Path | str = "file") -> bytes:
    """Return the bytes of a file: the very ones that it was read from, if it was read."""
    if isinstance(file, PrnFile):
        return file.encode(path)
    return (encode_csb if file.kind == CSB_KIND else encode_csv)(file, path)


def _read(path: Path, kinds: tuple[str, ...], raw: bool, lenient: bool, strict: bool) -> MotionFile:
    rules = LENIENT if lenient else STRICT if strict else _EDITED
    return examine(path, rules, raw=raw, kinds=kinds).required_motion()


def _require_values(path: Path, values: Sequence[int]) -> None:
    """Refuse to write a file that no reader would take."""
    if not values:
        raise UserError(f"{shown_path(path)}:1:1: no values to write")
