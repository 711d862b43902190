# SPDX-License-Identifier: MIT
"""Whole files, read and written; the content alone tells which format one has, not the name.

`examine` reads any file and says everything that is to be found in it; `read_...` raise its first
error.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from pixstep import atomic
from pixstep.errors import UserError
from pixstep.formats.findings import (
    LENIENT,
    MAX_FINDINGS,
    STRICT,
    Findings,
    Tolerance,
    shown,
    shown_path,
)
from pixstep.formats.header import HEADER_WIDTH, ProfileHeader
from pixstep.formats.motion import (
    CSB_KIND,
    CSV_KIND,
    MotionFile,
    could_be_blocks,
    encode_csb,
    encode_csv,
    has_header,
    of_lines,
    parse_csb,
    parse_csv,
)
from pixstep.formats.records import PRN_KIND, PrnFile, load, parse_prn, split_records

KINDS = (PRN_KIND, CSV_KIND, CSB_KIND)
_LOOKED_AT = 64
_BY_WIDTH = {6: CSV_KIND, 8: PRN_KIND}


@dataclass(frozen=True)
class Recognised:
    """A format and the reason; `kind` is None for a file that has none of them."""

    kind: str | None
    why: str


def recognise(data: bytes) -> Recognised:
    """Say which format bytes have, whether or not they are right in it."""
    if data.startswith(b"CSB"):
        return Recognised(CSB_KIND, f"begins with {shown(data[:4])}")
    first = next(split_records(data), b"")
    if has_header(data):
        what = f"{HEADER_WIDTH} columns wide" if len(first) == HEADER_WIDTH else "text"
        return Recognised(CSV_KIND, f"its first line is {what}, as a header is")
    looked_at = list(islice(split_records(data), _LOOKED_AT))
    widths = Counter(len(text) for text in looked_at if text.strip(b" +-0123456789") == b"")
    votes = {width: widths[width] for width in _BY_WIDTH if widths[width]}
    if not votes:
        return Recognised(
            None,
            f"{shown(first)} is {len(first)} columns wide: neither a PRN (8 columns of digits) "
            "nor a CSV (6, or a header of 40) nor a CSB",
        )
    width = max(votes, key=lambda width: (votes[width], width == len(first)))
    why = f"{votes[width]} of the first {len(looked_at)} records are numbers in {width} columns"
    return Recognised(_BY_WIDTH[width], why)


NAMES = {PRN_KIND: "PRN profile", CSV_KIND: "CSV file", CSB_KIND: "CSB file"}
_LOOKS = {**NAMES, CSV_KIND: "CSV profile"}  # six columns, where eight are expected


@dataclass(frozen=True)
class Examined:
    """A file's bytes, its format and why, what it holds (None if refused), what was found."""

    path: Path
    data: bytes
    kind: str | None
    why: str
    file: PrnFile | MotionFile | None
    findings: Findings

    def required(self) -> PrnFile | MotionFile:
        """Return what the file holds, its notes with it. Raises UserError for the first error."""
        self.findings.raise_first(self.path)
        if self.file is None:
            raise AssertionError(f"{self.path}: refused without an error")
        return replace(self.file, notes=self.findings.notes(self.path))

    def required_motion(self) -> MotionFile:
        """Return what a file holds that was examined as CSV or CSB alone, as `required` does."""
        file = self.required()
        if isinstance(file, PrnFile):
            raise AssertionError(f"{self.path}: a PRN, though none was asked for")
        return file


def examine(
    path: Path, rules: Tolerance = STRICT, *, raw: bool = False, kinds: tuple[str, ...] = KINDS
) -> Examined:
    """Read a file, collecting all findings; a file of none of `kinds` is refused by name.

    Raises UserError only for a file that cannot be loaded: unreadable, empty, too large.
    """
    return examine_bytes(Path(path), load(path), rules, raw=raw, kinds=kinds)


def examine_bytes(
    path: Path,
    data: bytes,
    rules: Tolerance = STRICT,
    *,
    raw: bool = False,
    kinds: tuple[str, ...] = KINDS,
) -> Examined:
    """Do what `examine` does with bytes that are loaded already and are not empty."""
    found = recognise(data)
    findings = Findings(rules)
    file: PrnFile | MotionFile | None = None
    kind = found.kind or _diagnosed_as(path, kinds)
    if kind not in kinds:
        wanted = " or ".join(NAMES[name] for name in kinds)
        looks = f"{_beginning(data)} looks like a {_LOOKS.get(found.kind or '')}"
        text = f"{looks}, not like a {wanted}: {found.why}" if found.kind else found.why
        findings.error("kind", 1, 1, text)
    elif kind == PRN_KIND:
        file = parse_prn(data, findings)
    else:
        parse = parse_csv if kind == CSV_KIND else parse_csb
        file = _motion(parse(data, findings, raw=raw), path, findings)
    if findings.full:
        findings.found[-1] = replace(
            findings.found[-1], name="stopped", message=f"stopped after {MAX_FINDINGS} findings"
        )
    return Examined(path, data, found.kind, found.why, file, findings)


def _diagnosed_as(path: Path, kinds: tuple[str, ...]) -> str | None:
    """Return the text format whose rules say best what is wrong with a file that has none."""
    text_kinds = [kind for kind in kinds if kind != CSB_KIND]
    if len(text_kinds) == 1:
        return text_kinds[0]
    named = path.suffix.lower().removeprefix(".")
    return named if named in text_kinds else None


def _motion(file: MotionFile | None, path: Path, findings: Findings) -> MotionFile | None:
    """Name the file; point at rows without a header that could have been blocks."""
    if file and file.header is None and could_be_blocks(file.rows):
        text = (
            f"begins with 1, {file.rows[1]} and holds {file.rows[1]} more rows: read as "
            f"{len(file.rows)} values of a line, though it looks like a numbered block without "
            "its header"
        )
        findings.warning("could_be_blocks", 1, 1, text)
    return file and replace(file, path=str(path))


def check_name(examined: Examined) -> None:
    """Find a name that says another format than the content: the numbers' meaning depends on it.

    Six-column counts in a file that is named PRN are never accepted.
    """
    named = examined.path.suffix.lower().removeprefix(".")
    if named not in KINDS or examined.kind in (None, named):
        return
    looks = f"{_beginning(examined.data)} looks like a {_LOOKS[examined.kind]}"
    text = f"{looks}, though the name ends in {shown(examined.path.suffix)}: {examined.why}"
    tolerated = examined.findings.rules.names and named != PRN_KIND
    examined.findings.quirk("name", tolerated, (1, 1), (text, text))


def _beginning(data: bytes) -> str:
    """Return the first record, or a CSB's magic, as it is quoted in a message."""
    return shown(data[:4] if data.startswith(b"CSB") else next(split_records(data)))


# A CSV that was edited and saved with LF is worth a note, not a refusal.
_EDITED = Tolerance(line_ends=True)


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
