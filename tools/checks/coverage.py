# SPDX-License-Identifier: MIT
"""Rule: the native suites reach every line of firmware/core; branches are reported.

    coverage.py                 builds the suites with counters, runs them, prints lines and
                                branches of each file, fails if a line of core is not reached
    coverage.py --html          the same, and build/coverage/report/index.html, line by line
    coverage.py --write FILE    the same, and the table in FILE between its markers
    coverage.py --check FILE    the same, and fails if that table lacks a file or names another

The table in a document is a record: what branches there are is the compiler's choice, so only the
files it names are checked. What no native suite reaches is to be tested or removed. An exclusion
(GCOVR_EXCL_...) needs a reason behind it in its line.
"""

import argparse
import json
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from common import ROOT, finish

from pixstep.errors import UserError
from pixstep_dev import markdown

BUILD = ROOT / "build" / "coverage"
REPORT = BUILD / "report" / "index.html"
# The layers whose sources the suites run natively, and the one that must be reached completely.
LAYERS = ("firmware/core/", "firmware/app/")
COMPLETE = "firmware/core/"
TABLE = "coverage"
# gcovr's own words, and those of others that it obeys.
EXCLUSION = re.compile(r"\b(?:GCOVR?|LCOV)_EXCL_\w+\W*(?P<reason>.*)")
REASON_CHARACTERS = 10


class CoverageError(Exception):
    """Nothing can be said; the message says why."""


@dataclass(frozen=True)
class File:
    """What the suites reached of one source file."""

    name: str
    lines: int
    missed: tuple[int, ...]
    branches: int
    taken: int

    def row(self) -> tuple[str, str, str]:
        """Cells for the table: file, lines reached, branches taken."""
        lines = f"{self.lines - len(self.missed)} of {self.lines}"
        return f"`{self.name}`", lines, _share(self.taken, self.branches)


def _share(taken: int, there: int) -> str:
    return f"{taken} of {there} ({100 * taken / there:.0f} %)" if there else "none"


def run(command: list[str | Path]) -> str:
    """Output of a program; CoverageError with the last of its text if it fails."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    except OSError as error:
        raise CoverageError(f"{words[0]}: {error.strerror} (tools/setup installs it)") from None
    if done.returncode:
        last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-15:])
        raise CoverageError(f"{' '.join(words[:4])} ... failed:\n{last}")
    return done.stdout


def run_suites() -> None:
    """Build the suites with counters, and nothing else of that tree; run them, counting anew."""
    run(["cmake", "--preset", "coverage"])
    run(["cmake", "--build", "--preset", "coverage", "--target", "unit_suites"])
    for counts in BUILD.rglob("*.gcda"):
        counts.unlink()
    _forget_gone_sources()
    names = sorted(path.stem for path in (ROOT / "host_tests").rglob("test_*.c"))
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    failed = [name for name in names if subprocess.run([BUILD / "bin" / name], **quiet).returncode]
    if failed:
        raise CoverageError(f"suites must pass before they count: {', '.join(failed)} failed")


def _forget_gone_sources() -> None:
    """Remove what the build keeps of sources that were renamed: gcovr would look for them."""
    for notes in BUILD.rglob("*.dir/**/*.gcno"):
        parts = notes.relative_to(BUILD).parts
        place = parts.index("CMakeFiles")
        source = ROOT.joinpath(*parts[:place], *parts[place + 2 :]).with_suffix("")
        if not source.exists():
            notes.unlink()


def count(html: bool) -> list[File]:
    """Have gcovr read the counters of every file of the layers."""
    command = [Path(sys.executable).parent / "gcovr", "--root", ROOT, "--json", "-"]
    command += [
        word for layer in LAYERS for word in ("--filter", f"{re.escape(str(ROOT))}/{layer}")
    ]
    if html:
        REPORT.parent.mkdir(exist_ok=True)
        command += ["--html-details", REPORT]
    found = json.loads(run([*command, BUILD / "firmware", BUILD / "host_tests"]))
    return [counted(one["file"], one["lines"]) for one in found["files"] if one["lines"]]


def counted(name: str, lines: list[dict]) -> File:
    """Sum up one file as gcovr describes it."""
    lines = [line for line in lines if not line.get("gcovr/excluded")]
    branches = [branch for line in lines for branch in line["branches"]]
    return File(
        name,
        len({line["line_number"] for line in lines}),
        tuple(sorted(missed_lines(lines))),
        len(branches),
        sum(branch["count"] > 0 for branch in branches),
    )


def missed_lines(lines: list[dict]) -> set[int]:
    """Line numbers that nobody reached; a line counts once, in however many functions it stands."""
    reached = {line["line_number"] for line in lines if line["count"]}
    return {line["line_number"] for line in lines} - reached


def unreached(files: list[File]) -> list[str]:
    """Complaints: lines of core that no suite reaches."""
    return [
        f"{file.name}:{line}: no native suite reaches it: test it, or remove it"
        for file in files
        if file.name.startswith(COMPLETE)
        for line in file.missed
    ]


def uncounted(files: list[File]) -> list[str]:
    """Complaints: C sources of the layers that are not part of any suite."""
    counted_names = {file.name for file in files}
    sources = [path for layer in LAYERS for path in (ROOT / layer).rglob("*.c")]
    names = (str(path.relative_to(ROOT)) for path in sorted(sources))
    return [
        f"{name}: no native suite is linked with it"
        for name in names
        if name not in counted_names and not name.endswith("/main.c")
    ]


def bare_exclusions() -> list[str]:
    """Complaints: exclusions without a reason in their line."""
    found = []
    for layer in LAYERS:
        for path in sorted((ROOT / layer).rglob("*.[ch]")):
            for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                match = EXCLUSION.search(text)
                if match and len(match["reason"]) < REASON_CHARACTERS:
                    where = path.relative_to(ROOT)
                    found.append(f"{where}:{number}: an exclusion without its reason")
    return found


def table(files: list[File]) -> str:
    """Return the counts as a Markdown table with a last row for each layer."""
    rows = [file.row() for file in files]
    for layer in LAYERS:
        own = [file for file in files if file.name.startswith(layer)]
        lines = sum(file.lines for file in own)
        missed = sum(len(file.missed) for file in own)
        share = _share(sum(file.taken for file in own), sum(file.branches for file in own))
        rows.append((f"all of `{layer}`", f"{lines - missed} of {lines}", share))
    return markdown.table(("file", "lines reached", "branches taken"), rows)


def outdated(path: Path, files: list[File]) -> list[str]:
    """Complaints: files that a document's table lacks, or names though they are gone."""
    text = path.read_text(encoding="utf-8")
    shown = set(re.findall(r"^\| `(firmware/[^`]+)` \|", text, re.MULTILINE))
    names = {file.name for file in files}
    found = []
    for name in sorted(names ^ shown):
        what = "lacks" if name in names else "still names"
        found.append(f"{path}: {what} {name}: tools/coverage --write {path}")
    return found


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="tools/coverage", description="Lines and branches that the native suites reach."
    )
    parser.add_argument("--html", action="store_true", help=f"write {REPORT.relative_to(ROOT)} too")
    parser.add_argument("--write", type=Path, metavar="FILE", help="rewrite the table in FILE")
    parser.add_argument("--check", type=Path, metavar="FILE", help="is the table in FILE complete?")
    return parser.parse_args()


def main() -> None:
    """Build, run, count, print, judge."""
    options = arguments()
    try:
        run_suites()
        files = count(options.html)
        if options.write:
            markdown.write(options.write, TABLE, table(files))
        problems = unreached(files) + uncounted(files) + bare_exclusions()
        problems += outdated(options.check, files) if options.check else []
    except (CoverageError, UserError, OSError) as error:
        finish("coverage", "nothing counted", [str(error)])
    print(table(files))
    if options.html:
        print(f"line by line: {REPORT.relative_to(ROOT)}")
    finish("coverage", f"{len(files)} files", problems)


if __name__ == "__main__":
    main()
