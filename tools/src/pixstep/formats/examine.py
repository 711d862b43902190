# SPDX-License-Identifier: MIT
"""Read a file whatever its format is and say everything that is to be found in it."""

from dataclasses import dataclass, replace
from pathlib import Path

from pixstep.formats.csb import parse_csb
from pixstep.formats.csvtext import parse_csv
from pixstep.formats.findings import MAX_FINDINGS, STRICT, Findings, Rules, shown
from pixstep.formats.motion import CSB_KIND, CSV_KIND, MotionFile, could_be_blocks
from pixstep.formats.prn import KIND as PRN_KIND
from pixstep.formats.prn import PrnFile, parse_prn
from pixstep.formats.recognise import KINDS, recognise
from pixstep.formats.records import load, split_records

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
    path: Path, rules: Rules = STRICT, *, raw: bool = False, kinds: tuple[str, ...] = KINDS
) -> Examined:
    """Read a file, collecting all findings; a file of none of `kinds` is refused by name.

    Raises UserError only for a file that cannot be loaded: unreadable, empty, too large.
    """
    return examine_bytes(Path(path), load(path), rules, raw=raw, kinds=kinds)


def examine_bytes(
    path: Path,
    data: bytes,
    rules: Rules = STRICT,
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
        _refuse_kind(data, found.kind, found.why, kinds, findings)
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
        findings.warning(
            "could_be_blocks",
            1,
            1,
            f"begins with 1, {file.rows[1]} and holds {file.rows[1]} more rows: read as "
            f"{len(file.rows)} values of a line, though it looks like a numbered block without "
            "its header",
        )
    return file and replace(file, path=str(path))


def _refuse_kind(
    data: bytes, kind: str | None, why: str, kinds: tuple[str, ...], findings: Findings
) -> None:
    """Refuse a file of another format by the name of what it looks like."""
    if kind is None:
        findings.error("kind", 1, 1, why)
        return
    wanted = " or ".join(NAMES[name] for name in kinds)
    message = f"{_beginning(data)} looks like a {_LOOKS[kind]}, not like a {wanted}: {why}"
    findings.error("kind", 1, 1, message)


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
