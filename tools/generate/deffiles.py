# SPDX-License-Identifier: MIT
"""Reader of the firmware's X-macro tables: rows `NAME(argument, "text", ...)`, one per line.

The same files feed the C code, so a table exists once. Arguments are integers (decimal or hex),
quoted texts (several are joined, as in C) or bare words.
"""

import re
from dataclasses import dataclass
from pathlib import Path


class TableError(Exception):
    """A row or constant of a .def file is not as expected; the text names file and line."""


_ROW = re.compile(r"([A-Z][A-Z0-9_]*)\((.*)\)\s*$", re.DOTALL)
_TEXT = r'"(?:[^"\\]|\\.)*"'
_ARGUMENT = re.compile(rf"\s*((?:{_TEXT}\s*)+|[^,]+?)\s*(?:,|$)", re.DOTALL)
_INTEGER = re.compile(r"-?(0x[0-9a-fA-F]+|\d+)[uUlL]*")


@dataclass(frozen=True)
class Row:
    """One row: the macro's name, its arguments, and where it stands."""

    macro: str
    arguments: tuple[int | str, ...]
    where: str


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a .def file in order; comments and preprocessor lines are skipped.

    A row may go over several lines; it ends where its parenthesis closes. Raises TableError
    naming file and line for anything else.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise TableError(f"{path}: {error.strerror or error}") from None
    rows = []
    pending, start = "", 0
    for number, line in enumerate(_without_comments(text).split("\n"), 1):
        stripped = line.strip()
        if not pending and (not stripped or stripped.startswith("#")):
            continue
        start = start if pending else number
        pending = f"{pending} {stripped}".strip()
        if _complete(pending):
            rows.append(_parse_row(pending, f"{path}:{start}"))
            pending = ""
    if pending:
        raise TableError(f"{path}:{start}: {pending!r} does not end")
    return rows


def _without_comments(text: str) -> str:
    """Blank out C comments, keeping line numbers and quoted texts."""

    def blank(match: re.Match) -> str:
        found = match.group(0)
        return found if found.startswith('"') else re.sub(r"[^\n]", "", found)

    return re.sub(rf"{_TEXT}|//[^\n]*|/\*.*?\*/", blank, text, flags=re.DOTALL)


def _complete(text: str) -> bool:
    """True if the parentheses outside of quoted texts are balanced."""
    bare = re.sub(_TEXT, "", text)
    return bare.count("(") == bare.count(")")


def _parse_row(text: str, where: str) -> Row:
    """Parse one complete row."""
    match = _ROW.match(text)
    if not match:
        raise TableError(f"{where}: {text!r} is not a row NAME(...)")
    arguments = tuple(_argument(found) for found in _ARGUMENT.findall(match.group(2)))
    return Row(match.group(1), arguments, where)


def _argument(text: str) -> int | str:
    """Return an integer, the joined content of quoted texts, or the word itself."""
    if _INTEGER.fullmatch(text):
        return int(text.rstrip("uUlL"), 0)
    if text.startswith('"'):
        return "".join(re.sub(r"\\(.)", r"\1", part[1:-1]) for part in re.findall(_TEXT, text))
    return text
