# SPDX-License-Identifier: MIT
"""Every command of every document: run by a test, or marked with what it needs instead.

Parts between markers of generated content are left out: their generators are compared by rules.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pixstep_dev.tutorial import document
from pixstep_dev.tutorial.document import Document

_GENERATED = re.compile(r"<!-- begin generated: (\S+) -->.*?<!-- end generated: \1 -->", re.DOTALL)
_IMAGE = "no title says what makes it"  # of a picture, which a walked document alone must say


@dataclass(frozen=True)
class Survey:
    """A document with its commands; `complaints` are blocks that say nothing clear."""

    name: str
    found: Document
    complaints: tuple[str, ...]

    @property
    def run(self) -> int:
        """How many commands are run by the quick check."""
        return sum(_is_command(one) and not one.long for one in self.found.steps)

    @property
    def long(self) -> int:
        """How many are run by the long check alone."""
        return sum(one.long for one in self.found.steps)

    @property
    def not_run(self) -> Counter[str]:
        """How many are not run, by what they need."""
        return Counter(one.needs for one in self.found.not_run)


def survey(root: Path) -> Iterator[Survey]:
    """Yield the documents of a clone that have commands or complaints."""
    for path in (root / "README.md", *sorted((root / "docs").glob("*.md"))):
        name = path.relative_to(root).as_posix()
        found = document.parse(written(path.read_text(encoding="utf-8")))
        wrong = tuple(f"{name}:{one}" for one in found.complaints if not one.endswith(_IMAGE))
        made = Survey(name, found, wrong)
        if made.run or made.long or made.not_run or wrong:
            yield made


def written(text: str) -> str:
    """Return a text without its generated parts; lines keep their numbers."""
    return _GENERATED.sub(lambda part: "\n" * part[0].count("\n"), text)


def table(found: list[Survey]) -> Iterator[str]:
    """Yield rows that say how many commands are run, and what the others need."""
    for one in found:
        yield f"{one.name}: {_said(one.run, one.long, one.not_run)}"
    needs = sum((one.not_run for one in found), Counter[str]())
    run, long = sum(one.run for one in found), sum(one.long for one in found)
    yield f"all: {_said(run, long, needs)}"
    for need in sorted(needs):
        yield f"{need}: {document.NOT_RUN[need]}"


def _said(run: int, long: int, needs: Counter[str]) -> str:
    parts = [f"{run} run"] + ([f"{long} by the long check"] if long else [])
    if needs:
        each = ", ".join(f"{count} {need}" for need, count in sorted(needs.items()))
        parts.append(f"{needs.total()} not run ({each})")
    return ", ".join(parts)


def _is_command(step: document.TutorialStep) -> bool:
    return not step.command.startswith("cat >")
