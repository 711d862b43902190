# SPDX-License-Identifier: MIT
"""A text file as records: its bytes, its line ends, and the same bytes again."""

import io
from collections.abc import Iterator, Sequence
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
        number, record = _first_with_lf(data)
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


def _first_with_lf(data: bytes) -> tuple[int, bytes]:
    """Return the number and text of the first record that ends with LF alone."""
    for number, line in enumerate(io.BytesIO(data), 1):
        if not line.endswith(b"\r\n"):
            return number, line[:-1]
    raise AssertionError("no record ends with LF")


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
