# SPDX-License-Identifier: MIT
"""Text files as records: their bytes, their line ends, the columns of their numbers.

Numbers are decimal integers right-aligned in a fixed number of columns, read exactly as they are
written. A PRN, an acceleration profile, is such records and nothing else: unsigned, 8 columns.
"""

import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.formats.findings import Findings, counted, shown, shown_path

MAX_BYTES = 16 * 1024 * 1024  # two million values; the longest real files have thousands

CRLF = "\r\n"
LF = "\n"


@dataclass(frozen=True)
class LineEnds:
    """How the records of a file end; all that its text does not say.

    `usual` ends every record but those numbered (from 1) in `others`, which end with the other one
    of CR LF and LF. `cut` is None, or what the last record ends with if that is neither: "", or
    the first half of a CR LF.
    """

    usual: str = CRLF
    others: frozenset[int] = frozenset()
    cut: str | None = None

    @property
    def other(self) -> str:
        """The one of CR LF and LF that is not usual here."""
        return LF if self.usual == CRLF else CRLF

    @property
    def words(self) -> str:
        """Name them for a person."""
        name = {CRLF: "CR LF", LF: "LF"}
        text = name[self.usual]
        if self.others:
            text += f", {name[self.other]} after {counted(len(self.others), 'record')}"
        return text if self.cut is None else f"{text}, no newline at the end"


REGULAR = LineEnds()  # what every writer makes


def load(path: Path) -> bytes:
    """Return the bytes of a file. Raises UserError: unreadable, empty, larger than MAX_BYTES."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UserError(f"{shown_path(path)}: {reason}") from None
    if not data:
        raise RefusedError(f"{shown_path(path)}:1:1: the file is empty")
    if len(data) > MAX_BYTES:
        raise RefusedError(
            f"{shown_path(path)}:1:1: larger than {MAX_BYTES} bytes (16 MiB): no profile or line "
            "file is so large"
        )
    return data


def split_records(data: bytes) -> Iterator[bytes]:
    """Yield the records without their line ends."""
    for line in io.BytesIO(data):
        if line.endswith(b"\r\n"):
            yield line[:-2]
        elif line.endswith((b"\n", b"\r")):
            yield line[:-1]
        else:
            yield line


def find_line_ends(data: bytes) -> LineEnds:
    """Return how the records of a file end."""
    cut = None if data.endswith(b"\n") else "\r" if data.endswith(b"\r") else ""
    lf_all, crlf = data.count(b"\n"), data.count(b"\r\n")
    if lf_all == crlf:
        return LineEnds(CRLF, cut=cut)
    if crlf == 0:
        return LineEnds(LF, cut=cut)
    usual = CRLF if 2 * crlf >= lf_all else LF
    ends = (line.endswith(b"\r\n") for line in io.BytesIO(data) if line.endswith(b"\n"))
    others = (number for number, has_cr in enumerate(ends, 1) if has_cr != (usual == CRLF))
    return LineEnds(usual, frozenset(others), cut)


def check_line_ends(data: bytes, findings: Findings) -> None:
    """Find the two quirks of line ends, each once, at the first record that has it."""
    ends = data.count(b"\n")
    bare = ends - data.count(b"\r\n")
    if bare:
        number, record = next(
            (number, line[:-1])
            for number, line in enumerate(io.BytesIO(data), 1)
            if not line.endswith(b"\r\n")
        )
        findings.quirk(
            "line_end",
            findings.rules.line_ends,
            (number, len(record) + 1),
            (
                f"LF instead of CR LF after {counted(bare, 'record')}",
                f"{shown(record)} ends with LF, CR LF expected ({bare} of {ends} records)",
            ),
        )
    if not data.endswith(b"\n"):
        number, start = data.count(b"\n") + 1, data.rfind(b"\n") + 1
        record = data[start:]
        findings.quirk(
            "no_final_newline",
            findings.rules.line_ends,
            (number, len(record) + 1),
            (
                f"no newline after the last record {shown(record)}",
                f"{shown(record)} has no CR LF after it",
            ),
        )


def join_records(texts: Sequence[str], ends: LineEnds) -> bytes:
    """Return the bytes of records with their line ends."""
    if not ends.others:
        last = ends.usual if ends.cut is None else ends.cut
        return (ends.usual.join(texts) + last).encode("ascii")
    used = [
        ends.other if number in ends.others else ends.usual for number in range(1, len(texts) + 1)
    ]
    if ends.cut is not None:
        used[-1] = ends.cut
    return "".join(text + end for text, end in zip(texts, used, strict=True)).encode("ascii")


@dataclass(frozen=True)
class Columns:
    """The columns of one format's records: how many, and whether a minus sign is legal."""

    width: int
    signed: bool
    kind: str
    hints: tuple[tuple[int, str], ...] = ()  # what another width looks like

    @property
    def largest(self) -> int:
        """Largest value that fits."""
        return int(10**self.width) - 1

    @property
    def smallest(self) -> int:
        """Smallest value that fits."""
        return -(10 ** (self.width - 1) - 1) if self.signed else 0

    def column(self, value: int) -> int:
        """Return the 1-based column where the text of a value that fits begins."""
        return self.width - len(str(value)) + 1


PRN_COLUMNS = Columns(8, False, "PRN", ((6, "CSV"),))
CSV_COLUMNS = Columns(6, True, "CSV", ((8, "PRN"),))

# What a writer would have written and nothing else, so that reading loses nothing.
_CANONICAL = {
    True: re.compile(rb" *(?:0|-?[1-9][0-9]*)"),
    False: re.compile(rb" *(?:0|[1-9][0-9]*)"),
}
_ODD_BYTE = re.compile(rb"[^ -~]")
_ODD_BYTES = {
    0x09: ("tab", "holds a tab, only blanks may pad a record"),
    0x0D: ("line_end", "holds a CR that no LF follows, CR LF expected"),
    0x1A: ("control", "holds byte 0x1A, the end-of-file mark of DOS"),
}


def read_numbers(
    rows: Iterable[bytes], columns: Columns, findings: Findings, first: int = 1
) -> list[int]:
    """Return the values of records, the first of them on line `first`; a bad one is a finding."""
    match, width, values = _CANONICAL[columns.signed].fullmatch, columns.width, []
    for number, text in enumerate(rows, first):
        if len(text) == width and match(text):
            values.append(int(text))
            continue
        name, column, message = _complaint(text, columns)
        findings.error(name, number, column, message)
        if findings.full:
            break
    return values


def odd_byte(text: bytes) -> tuple[str, int, str] | None:
    """Return name, column and message for the first byte that no record may hold, if any."""
    found = _ODD_BYTE.search(text)
    if not found:
        return None
    byte = text[found.start()]
    reason = "is not ASCII" if byte > 0x7F else "is a control character"
    name, message = _ODD_BYTES.get(byte, ("not_ascii", f"holds byte 0x{byte:02X}, which {reason}"))
    return name, found.start() + 1, f"{shown(text)} {message}"


def number_texts(
    values: Iterable[int], columns: Columns, path: Path | str, first: int = 1
) -> list[str]:
    """Return the records of values. Raises UserError for one that does not fit its columns."""
    rows = []
    for number, value in enumerate(values, first):
        if not columns.smallest <= value <= columns.largest:
            raise UserError(
                f"{shown_path(path)}:{number}:1: value {value} does not fit {columns.width} "
                f"columns of a {columns.kind}: {columns.smallest}..{columns.largest}"
            )
        rows.append(f"{value:>{columns.width}d}")
    return rows


def _complaint(text: bytes, columns: Columns) -> tuple[str, int, str]:
    """Return name, column and message of what is wrong with a record."""
    odd = odd_byte(text)
    if odd:
        return odd
    if not text.strip():
        return "empty_record", 1, f"empty record {shown(text)}"
    return _too_large(text, columns) or _wrong_width(text, columns) or _not_number(text, columns)


def _too_large(text: bytes, columns: Columns) -> tuple[str, int, str] | None:
    digits = text.strip(b" ").lstrip(b"0")
    if not digits.isdigit() or len(digits) <= columns.width:
        return None
    column = len(text) - len(text.lstrip(b" ")) + 1
    most = f"is above {columns.largest}, the most that {columns.width} columns hold"
    hint = _hint(text, columns)
    return "too_large", column, f"{shown(digits)} {most}{hint}"


def _wrong_width(text: bytes, columns: Columns) -> tuple[str, int, str] | None:
    if len(text) == columns.width:
        return None
    column = min(len(text), columns.width) + 1
    message = f"{shown(text)} is {len(text)} columns wide, not {columns.width}"
    return "width", column, message + _hint(text, columns)


def _hint(text: bytes, columns: Columns) -> str:
    kind = dict(columns.hints).get(len(text))
    return f": looks like a {kind} profile" if kind else ""


def _not_number(text: bytes, columns: Columns) -> tuple[str, int, str]:
    """Say why a record of the right width and of printable characters is no number."""
    start = len(text) - len(text.lstrip(b" "))
    body = text[start:]
    what = "an integer" if columns.signed else "an unsigned decimal integer"
    if body[:1] in b"+-" and not (columns.signed and body[:1] == b"-"):
        reason = "only a minus sign is legal" if columns.signed else "values are unsigned"
        return "sign", start + 1, f"{shown(text)} has a sign, {reason}"
    bad = re.search(rb"[^0-9]", body[1:] if body[:1] == b"-" else body)
    if bad:
        column = start + 1 + bad.start() + (body[:1] == b"-")
        if not text[column - 1 :].strip(b" "):
            return "alignment", column, f"{shown(text)} is not right-aligned"
        message = f"{shown(text)} is not {what} right-aligned in {columns.width} columns"
        return "not_a_number", column, message
    if body == b"-":
        return "not_a_number", start + 1, f"{shown(text)} is a sign without a number"
    message = f"{shown(text)} has a leading zero, only blanks may pad a record"
    return "leading_zero", start + 1, message


PRN_KIND = "prn"


@dataclass(frozen=True)
class PrnFile:
    """A profile: one value an entry, how its lines end, and what was tolerated.

    A value is a speed at the end of the pixel (steps/pixel) for a smooth motor, and the steps made
    in the pixel for a plain one; 0..99999999. The file does not say which.
    """

    values: tuple[int, ...]
    ends: LineEnds = REGULAR
    notes: tuple[str, ...] = ()

    kind = PRN_KIND

    def encode(self, path: Path | str = PRN_KIND) -> bytes:
        """Return the bytes of the file. Raises UserError for a value that does not fit."""
        return join_records(number_texts(self.values, PRN_COLUMNS, path), self.ends)


def parse_prn(data: bytes, findings: Findings) -> PrnFile:
    """Read a profile; the result is right only if nothing is refused."""
    check_line_ends(data, findings)
    values = read_numbers(split_records(data), PRN_COLUMNS, findings)
    return PrnFile(tuple(values), find_line_ends(data))


def check_smooth(values: tuple[int, ...], findings: Findings) -> None:
    """Find what a smooth motor's profile may not have: an odd speed, zero, a decrease."""
    for number, name, message in _smooth_faults(values):
        column = PRN_COLUMNS.column(values[number - 1])
        findings.error(name, number, column, message)


def _smooth_faults(values: tuple[int, ...]) -> Iterator[tuple[int, str, str]]:
    """Yield entry, name and message."""
    previous = 0
    for number, value in enumerate(values, 1):
        if value == 0:
            yield number, "zero_speed", "speed 0: the speeds of a smooth motor are above 0"
        elif value % 2:
            legal = f"nearest legal {value - 1} and {value + 1}"
            yield number, "odd_speed", f"speed {value} of a smooth motor is odd, {legal}"
        if value < previous:
            yield number, "falling_speed", f"speed falls from {previous} to {value}"
        previous = value
