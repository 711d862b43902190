# SPDX-License-Identifier: MIT
"""Look into profiles and motion files, check them, write them in another format."""

from __future__ import annotations

from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any, TypedDict, cast

from pixstep import formats
from pixstep.errors import FINE, NEGATIVE, REFUSED, AskedText, UserError
from pixstep.formats import convert, records
from pixstep.formats.describe import Description, describe, table
from pixstep.formats.files import KINDS, NAMES, Examined, check_name, examine
from pixstep.formats.findings import LENIENT, STRICT, shown_path
from pixstep.formats.header import MOST_HAPS, MOST_LEAD_IN
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.operations import shared
from pixstep.operations.asked import AskedError, AskedRefusedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, HZ, OUTPUT, TEXT, Choice, Pixels, Whole
from pixstep.operations.request import Request, argument, flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import origin

_VERDICTS = {FINE: "fine", NEGATIVE: "accepted with notes", REFUSED: "refused"}
_COLOURS = {"error": "red", "warning": "yellow"}


def _lenient() -> Any:
    return flag(
        "Accept LF, a missing final newline, truncated lines, a wrong name; each with a note."
    )


def _decode(about: str, **more: Any) -> Any:
    return shared.decode(about, required=False, machine=None, **more)


@operation("file info")
class FileInfo(Request):
    """Say what is in a file.

    Its format and why, the header in words, lines, values, steps, line ends, the reading taken and
    the one not taken.
    """

    result = Description

    path: Path = argument(FILE, shown="FILE")
    raw: bool = shared.raw()

    def run(self, desk: Desk) -> Result:
        """Describe the file."""
        del desk
        facts = describe(self.path, raw=self.raw)

        def write(to: Page) -> None:
            to.tell(to.styled(shown_path(self.path), bold=True))
            for label, text in table(facts):
                to.tell(f"  {label:<16} {text}")

        return Result(facts, write)


class FileFinding(TypedDict):
    """What is wrong at a place of a file; lines and columns count from 1."""

    name: str
    severity: str
    line: int
    column: int
    message: str


class CheckedFile(TypedDict):
    """What a check says of a file; `kind` is null for an unknown format."""

    file: str
    kind: str | None
    why: str
    verdict: str
    findings: list[FileFinding]


@operation("file check")
class FileCheck(Request):
    """List everything wrong with a file.

    Every finding is a line `file:line:column: severity: message`. Exit status 0 fine, 1 accepted
    with notes or warnings, 3 refused.
    """

    result = CheckedFile

    path: Path = argument(FILE, shown="FILE")
    lenient: bool = _lenient()
    raw: bool = shared.raw()
    decode: str | None = _decode(
        "smooth: a smooth motor's PRN is even, above 0, never falling.",
        default_text="by the motor in the file's name, smooth for M39",
    )

    def run(self, desk: Desk) -> Result:
        """Check the file."""
        del desk
        examined = self._examined(lenient=self.lenient)
        findings, refused = examined.findings.in_order(), examined.findings.refused
        status = REFUSED if refused else NEGATIVE if findings else FINE
        helps = refused and not self.lenient and not self._examined(lenient=True).findings.refused
        data: CheckedFile = {
            "file": str(examined.path),
            "kind": examined.kind,
            "why": examined.why,
            "verdict": _VERDICTS[status],
            "findings": [cast("FileFinding", asdict(item)) for item in findings],
        }

        def write(to: Page) -> None:
            name = shown_path(self.path)
            for item in findings:
                severity = to.styled(item.severity, colour=_COLOURS.get(item.severity))
                place = f"{name}:{item.line}:{item.column}: {severity}"
                to.tell(AskedText("{place}: {text}", place=place, text=item.message))
            what = NAMES[examined.kind] if examined.kind else "unknown format"
            hint = AskedText(" ({lenient} accepts it)") if helps else ""
            text = f"{name}: {data['verdict']}: {what}"
            to.tell(AskedText("{text}{hint}", text=text, hint=hint))

        return Result(data, write, status)

    def _examined(self, *, lenient: bool) -> Examined:
        """Read the file and look at its name, too."""
        examined = examine(self.path, LENIENT if lenient else STRICT, raw=self.raw)
        check_name(examined)
        smooth = self.decode == SMOOTH
        if smooth and examined.kind in NAMES and examined.kind != records.PRN_KIND:
            raise AskedError(
                "{path}: {decode} smooth is for PRN profiles, this is a {kind}: "
                "`pixstep line check` checks lines",
                path=shown_path(self.path), kind=NAMES[examined.kind],
            )  # fmt: skip
        named = origin.parse_name(self.path)
        if self.decode is None and examined.kind == records.PRN_KIND:
            smooth = named is not None and named.decode == SMOOTH
        if smooth and not examined.findings.refused:
            records.check_smooth(examined.required().values, examined.findings)
        return examined


class ConvertedFile(TypedDict):
    """A file that was written."""

    file: str
    kind: str
    lines: int
    values: int
    bytes: int


@operation("file convert")
class FileConvert(Request):
    """Write a file in another format.

    Nothing is lost and no meaning is changed without being told to; text is written with CR LF.
    Header options change the header of IN or, with --header and --pixel-hz, make one; --haps and
    --lead-in are then 0 unless given.
    """

    result = ConvertedFile

    source: Path = argument(FILE, shown="IN")
    target: Path = argument(OUTPUT, shown="OUT")
    to: str | None = option(Choice(KINDS), "Format.", default_text="by the name of OUT")
    line: int | None = option(shared.LINE_NUMBER, "Only line N of many.", shown="N")
    decode: str | None = _decode("plain: the numbers of a PRN are counts, as those of a CSV are.")
    drop_header: bool = flag("The header may be lost.")
    name: str | None = option(
        TEXT, "Profile name, at most 20 characters.", "--header", shown="NAME"
    )
    haps: int | None = option(Whole(0, MOST_HAPS), "Entries usable in homing.")
    lead_in: int | None = option(Pixels(0, MOST_LEAD_IN), "Constant pixels before image.")
    pixel_hz: Fraction | None = option(HZ, "Pixel frequency: 30, 29.97 or 30000/1001.")
    date: str | None = option(
        TEXT, "As 'Mon Oct 12 15:13:35 2009'.", shown="CTIME", default_text="now"
    )
    lenient: bool = _lenient()
    raw: bool = shared.raw()

    def run(self, desk: Desk) -> Result:
        """Read the file, convert it and write it."""
        hz, kind = self.pixel_hz, self._kind()
        text = None if hz is None else formats.hz_text(hz)
        header = convert.HeaderChanges(self.name, self.haps, self.lead_in, text, self.date)
        request = convert.Conversion(
            kind, self.line, self.decode == PLAIN, self.drop_header, header
        )
        read = self._read()
        made = convert.write(read, self.source, self.target, request)
        desk.say([*read.notes, *(f"{shown_path(self.source)}: {note}" for note in made.notes)])
        if text is not None and Fraction(text) != hz:
            desk.say([f"{shown_path(self.source)}: pixel frequency {hz} Hz is written as {text}"])
        data: ConvertedFile = {
            "file": str(self.target),
            "kind": kind,
            "lines": made.lines,
            "values": made.values,
            "bytes": made.size,
        }
        count = f"{made.lines} lines, " if made.lines > 1 else ""
        page = f"{NAMES[kind]}, {count}{made.values} values, {made.size} bytes"
        return Result(data, f"{shown_path(self.target)}: {page}")

    def _kind(self) -> str:
        """Return the format of the output; a name that says another one is refused."""
        named = self.target.suffix.lower().removeprefix(".")
        path = shown_path(self.target)
        if self.to is None and named not in KINDS:
            raise AskedError("{path}: which format? {to} prn, csv or csb", path=path)
        if self.to is not None and named in KINDS and named != self.to:
            raise AskedError("{path}: {to} {kind} contradicts the name", path=path, kind=self.to)
        return self.to or named

    def _read(self) -> formats.PrnFile | formats.MotionFile:
        """Read the input; a refusal that --lenient would lift says so."""
        try:
            return formats.read_any(self.source, lenient=self.lenient, raw=self.raw)
        except UserError as error:
            if self.lenient or examine(self.source, LENIENT, raw=self.raw).findings.refused:
                raise
            raise AskedRefusedError("{reason} ({lenient} accepts it)", reason=error) from None
