# SPDX-License-Identifier: MIT
"""What reading a file finds: errors, warnings and tolerated quirks, each at a line and a column.

Lines and columns count from 1. A CSB has no lines: its findings are on line 1, their column is the
number of the byte.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.errors import AskedText, RefusedError

ERROR = "error"  # refuses the file
WARNING = "warning"  # read all the same, but hardly meant so
NOTE = "note"  # an old quirk, tolerated

MAX_FINDINGS = 1000  # a file that is not what it should be has one a record
_SHOWN_BYTES = 48


@dataclass(frozen=True)
class Tolerance:
    """Which quirks are tolerated; whatever is not refuses the file."""

    line_ends: bool = False  # LF instead of CR LF, no newline at the end
    truncated: bool = False  # fewer values or lines than the file announces
    names: bool = False  # the file's name says another format than its content


STRICT = Tolerance()
LENIENT = Tolerance(line_ends=True, truncated=True, names=True)


@dataclass(frozen=True)
class RecordFinding:
    """One thing found; `name` is stable, for programs that read it."""

    name: str
    severity: str
    line: int
    column: int
    message: str

    def text(self, path: Path | str) -> str:
        """Return the finding as `file:line:column: message`, one line of bounded length."""
        place = f"{shown_path(path)}:{self.line}:{self.column}"
        return AskedText("{place}: {message}", place=place, message=self.message)


Place = Callable[[int, int], tuple[int, int]]


@dataclass
class Findings:
    """Collects findings; at MAX_FINDINGS it is `full` and a reader may stop.

    `place` maps a line and a column of the text to where they are in the file.
    """

    rules: Tolerance = STRICT
    found: list[RecordFinding] = field(default_factory=list)
    place: Place = lambda line, column: (line, column)

    def placed(self, place: Place) -> "Findings":
        """Return a view that adds to the same findings at other places."""
        return Findings(self.rules, self.found, place)

    def error(self, name: str, line: int, column: int, message: str) -> None:
        """Add what refuses the file."""
        self._add(name, ERROR, line, column, message)

    def warning(self, name: str, line: int, column: int, message: str) -> None:
        """Add what is read all the same."""
        self._add(name, WARNING, line, column, message)

    def quirk(
        self, name: str, tolerated: bool, where: tuple[int, int], texts: tuple[str, str]
    ) -> None:
        """Add an old quirk: a note if it is tolerated, else an error; a text for each."""
        accepted, refused = texts
        if tolerated:
            self._add(name, NOTE, *where, f"{accepted}: accepted")
        else:
            self._add(name, ERROR, *where, refused)

    def _add(self, name: str, severity: str, line: int, column: int, message: str) -> None:
        if not self.full:
            self.found.append(RecordFinding(name, severity, *self.place(line, column), message))

    @property
    def full(self) -> bool:
        """True if no more are taken."""
        return len(self.found) >= MAX_FINDINGS

    @property
    def refused(self) -> bool:
        """True if any finding is an error."""
        return self.refused_since(0)

    def refused_since(self, count: int) -> bool:
        """True if any finding after the first `count` is an error."""
        return any(item.severity == ERROR for item in self.found[count:])

    def in_order(self) -> list[RecordFinding]:
        """Return all findings by line and column."""
        return sorted(self.found, key=lambda item: (item.line, item.column))

    def raise_first(self, path: Path | str) -> None:
        """Raise RefusedError for the first error in the file, if there is one."""
        for item in self.in_order():
            if item.severity == ERROR:
                raise RefusedError(item.text(path))

    def notes(self, path: Path | str) -> tuple[str, ...]:
        """Return warnings and notes as lines of text."""
        return tuple(item.text(path) for item in self.in_order() if item.severity != ERROR)


def shown(text: bytes | str) -> str:
    """Return a value as it is quoted in a message: ASCII, one line, of bounded length."""
    if isinstance(text, bytes):
        text = text.decode("latin-1")
    if len(text) <= _SHOWN_BYTES:
        return ascii(text)
    return f"{text[:_SHOWN_BYTES]!a}... ({len(text)} bytes)"


def counted(number: int, what: str) -> str:
    """Return a number of things: 1 row, 2 rows."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def shown_path(path: Path | str) -> str:
    """Return a path as it is; one that cannot be printed on a line, escaped."""
    text = str(path)
    return text if text.isprintable() else ascii(text)
