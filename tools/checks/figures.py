# SPDX-License-Identifier: MIT
"""Rule: functions stay small and headers stay explained, by figures with limits.

    figures.py           prints each figure beside its limit and its goal, fails over a limit

A function's lines are its code lines as lizard counts them, the signature included, blank lines and
comments not. A header's comment share is its lines with a comment, without the licence, divided by
its lines with code; a line with both counts as both.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import lizard
from common import ROOT, finish, repository_files

SUFFIXES = {".c", ".h"}
# The body of a naked handler is instructions, not statements.
NAKED = "ISR_NAKED"
LICENCE = ("SPDX-License-Identifier", "This file is MIT")


@dataclass(frozen=True)
class Figure:
    """A figure of the tree with what it may be and what it should be."""

    name: str
    value: float
    limit: float
    goal: float
    at_least: bool = False
    where: str = ""

    @property
    def missed(self) -> bool:
        """Whether the value is on the wrong side of the limit."""
        return self.value < self.limit if self.at_least else self.value > self.limit

    def row(self) -> str:
        """The figure as a line of text."""
        bound = "at least" if self.at_least else "at most"
        goal = "" if self.goal == self.limit else f", goal {self.goal:g}"
        where = f" ({self.where})" if self.where else ""
        return f"{self.name}: {self.value:g}, {bound} {self.limit:g}{goal}{where}"


@dataclass(frozen=True)
class Limits:
    """Limit and goal of each figure of one part of the tree."""

    p50: tuple[int, int]
    p90: tuple[int, int]
    longest: tuple[int, int]
    comments: tuple[float, float]  # comment lines for each code line of the headers


# (limit, goal). Where the tree misses its goal, the limit is what it has reached.
PARTS = {
    "firmware": Limits((8, 8), (20, 20), (36, 36), (0.8, 0.8)),
    "sim": Limits((9, 9), (18, 18), (32, 32), (0.8, 0.8)),
}


@dataclass(frozen=True)
class Function:
    """A function with its lines of code."""

    lines: int
    name: str
    file: str


def part_files(part: str, files: Iterable[Path], root: Path = ROOT) -> list[Path]:
    """C files of a part of the tree, its tests left out."""
    inside = ((file, file.relative_to(root).as_posix()) for file in files)
    return [
        file
        for file, path in inside
        if file.suffix in SUFFIXES and path.startswith(f"{part}/") and "/tests/" not in path
    ]


def functions(files: Iterable[Path]) -> list[Function]:
    """Functions of C files, handlers written in assembly left out."""
    return [
        Function(one.nloc, one.name, file.name)
        for file in files
        for one in lizard.analyze_file(str(file)).function_list
        if NAKED not in one.long_name
    ]


def percentile(values: list[int], share: float) -> int:
    """The value that this share of the values does not exceed."""
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def comment_lines(text: str) -> tuple[int, int]:
    """Lines with a comment and lines with code of a C file; a licence counts as neither."""
    comments, code, inside = 0, 0, False
    for line in map(str.strip, text.splitlines()):
        if not line or any(word in line for word in LICENCE):
            continue
        starts = line.startswith(("//", "/*"))
        comments += inside or starts or "//" in line or "/*" in line
        code += not inside and not starts
        inside = "*/" not in line and (inside or "/*" in line)
    return comments, code


def comment_share(headers: Iterable[Path]) -> float:
    """Comment lines for each line of code, over all headers."""
    counts = [comment_lines(header.read_text(encoding="utf-8")) for header in headers]
    code = sum(lines for _, lines in counts)
    return sum(comments for comments, _ in counts) / code if code else 0.0


def measure(part: str, limits: Limits, files: list[Path]) -> list[Figure]:
    """All figures of one part."""
    found = functions(files)
    lines = [one.lines for one in found] or [0]
    longest = max(found, key=lambda one: one.lines, default=Function(0, "none", ""))
    share = comment_share(file for file in files if file.suffix == ".h")
    name = f"{part}, code lines of a function"
    return [
        Figure(f"{name}, half of {len(found)} have", percentile(lines, 0.5), *limits.p50),
        Figure(f"{name}, nine of ten have", percentile(lines, 0.9), *limits.p90),
        Figure(
            f"{name}, the longest has",
            longest.lines,
            *limits.longest,
            where=f"{longest.name} in {longest.file}",
        ),
        Figure(
            f"{part}, comment lines for each code line of a header",
            round(share, 3),
            *limits.comments,
            at_least=True,
        ),
    ]


def main() -> None:
    """Print all figures and judge them."""
    files = repository_files()
    found = [
        figure
        for part, limits in PARTS.items()
        for figure in measure(part, limits, part_files(part, files))
    ]
    for figure in found:
        print(figure.row())
    problems = [f"over its limit: {figure.row()}" for figure in found if figure.missed]
    finish("figures", f"{len(found)} figures", problems)


if __name__ == "__main__":
    main()
