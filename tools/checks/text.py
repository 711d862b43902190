# SPDX-License-Identifier: MIT
"""Rule: text files are plain: no tabs, no trailing blanks, short lines, one final newline, a
licence line in every source, nothing unfinished and nothing that only one machine knows.
"""

import re
from pathlib import Path

from common import ROOT, finish, repository_files

LINE_MAX = 100
SOURCES = {".c", ".h", ".S", ".inc", ".def", ".py", ".cmake", ".cjs", ".mjs", ".js"}
SCRIPTS_WITHOUT_SUFFIX = {"tools", ".ci"}
LICENCE = "SPDX-License-Identifier: MIT"

# Data and generated files keep the form that their readers and writers give them.
EXEMPT_SUFFIXES = {".png", ".PRN", ".csv", ".vcd", ".gz", ".xz"}
EXEMPT_FILES = {
    "sim/crosscheck/package-lock.json",
    "tools/src/pixstep/data/report/uplot-1.6.32.min.css",
    "tools/src/pixstep/data/report/uplot-1.6.32.min.js",
}
# Prose and tables may have longer lines.
LONG_LINES = {".json", ".md", ".def", ".html"}

# Words are put together here, so that this file does not find itself.
UNFINISHED = re.compile(r"\b(?:TO" + r"DO|FIX" + r"ME|XX" + r"X)\b")
ONE_MACHINE = re.compile(r"(?<![\w.])/(?:ho" + r"me|ro" + r"ot|Us" + r"ers)/")


def is_source(path: Path) -> bool:
    """Whether the file must carry the licence line."""
    inside = path.relative_to(ROOT)
    script = inside.suffix == "" and inside.parts[0] in SCRIPTS_WITHOUT_SUFFIX
    return inside.suffix in SOURCES or inside.name == "CMakeLists.txt" or script


def check_lines(path: Path, lines: list[str]) -> list[str]:
    """Complaints about single lines, as 'number: complaint'."""
    found = []
    for number, line in enumerate(lines, start=1):
        if "\t" in line:
            found.append(f"{number}: a tab")
        if line != line.rstrip():
            found.append(f"{number}: blanks at the end of the line")
        if len(line) > LINE_MAX and path.suffix not in LONG_LINES:
            found.append(f"{number}: {len(line)} characters, at most {LINE_MAX}")
        if UNFINISHED.search(line):
            found.append(f"{number}: marked as unfinished: {line.strip()}")
        if ONE_MACHINE.search(line):
            found.append(f"{number}: a path of one machine: {line.strip()}")
    return found


def check_file(path: Path) -> list[str]:
    """Complaints about one file."""
    inside = path.relative_to(ROOT).as_posix()
    try:
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        return [f"{inside}: not UTF-8"]
    found = check_lines(path, text.split("\n"))
    if "\r" in text:
        found.append("1: carriage returns")
    if text and (not text.endswith("\n") or text.endswith("\n\n")):
        found.append(f"{text.count(chr(10))}: not exactly one newline at the end")
    if is_source(path) and LICENCE not in text[:400]:
        found.append(f"1: no '{LICENCE}' at the top")
    return [f"{inside}:{complaint}" for complaint in found]


def main() -> None:
    """Check every text file of the repository."""
    files = [
        path
        for path in repository_files()
        if path.suffix not in EXEMPT_SUFFIXES
        and path.relative_to(ROOT).as_posix() not in EXEMPT_FILES
    ]
    finish("text", f"{len(files)} files", [line for path in files for line in check_file(path)])


if __name__ == "__main__":
    main()
