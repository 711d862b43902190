# SPDX-License-Identifier: MIT
"""Generated parts of Markdown documents, kept between markers, and the tables in them."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from pixstep import atomic
from pixstep.errors import UserError


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---" for _ in head], *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in lines)


def between(text: str, name: str, content: str, path: Path | str = "file") -> str:
    """Return `text` with what stands between the markers of `name` replaced by `content`.

    The markers are comment lines `begin generated: NAME` and `end generated: NAME`.
    """
    pattern = _marker_pattern(name)
    if not pattern.search(text):
        raise UserError(f"{path}: has no markers {_begin(name)!r} and {_end(name)!r}")
    return pattern.sub(lambda _: f"{_begin(name)}\n{content.rstrip()}\n{_end(name)}", text, count=1)


def marked(name: str, content: str) -> str:
    """Return `content` between its markers."""
    return f"{_begin(name)}\n{content.rstrip()}\n{_end(name)}\n"


def write(path: Path, name: str, content: str) -> bool:
    """Rewrite the generated part of a file; return True if it changed."""
    text = _read(path)
    fresh = between(text, name, content, path)
    if fresh != text:
        replace(path, fresh)
    return fresh != text


def replace(path: Path, text: str) -> None:
    """Write a generated file in the place of the one that is there."""
    with atomic.rules(atomic.WriteRules(force=True)):  # that is what was asked for
        atomic.write_text(path, text)


def check(path: Path, name: str, content: str) -> bool:
    """True if the generated part of a file is what it should be."""
    text = _read(path)
    return between(text, name, content, path) == text


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


def _begin(name: str) -> str:
    return f"<!-- begin generated: {name} -->"


def _end(name: str) -> str:
    return f"<!-- end generated: {name} -->"


def _marker_pattern(name: str) -> re.Pattern[str]:
    return re.compile(f"{re.escape(_begin(name))}\n.*?{re.escape(_end(name))}", re.DOTALL)
