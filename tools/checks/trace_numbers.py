# SPDX-License-Identifier: MIT
"""Numbers of the suites of traces (test_*_traces.c), as the built programs print them.

    build/venv/bin/python tools/checks/trace_numbers.py BUILD

BUILD is a build of the host preset. Runs each suite on the PC and, simulated, on every board whose
RAM holds it, and puts each number that differs into the suite's source. Only after a change that is
meant to decode, account or answer otherwise; build and run the suites again afterwards: a test
ends with its first number that differs. Every board of as many axes must have the same numbers: a
number that two boards would change in different ways is an error.
"""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from common import ROOT, finish

BOARDS = ("mega", "m1284")
DIFFERS = re.compile(r"Expected (0x[0-9A-F]{8}) Was (0x[0-9A-F]{8})")


def programs(build: Path, suite: str) -> Iterator[list[str]]:
    """Yield the commands that run a suite, and the same with the core of a single axis."""
    for program in (suite, f"{suite}_one"):
        if (native := build / "bin" / program).is_file():
            yield [str(native)]
        for board in BOARDS:
            image = build.parent / board / "host_tests" / f"{program}.elf"
            if image.is_file():
                words = [build / "bin/pixstep-sim", "--unit", "--board", f"{board}={image}"]
                yield [str(word) for word in words]


def changes(build: Path, suite: str) -> Iterator[tuple[str, str]]:
    """Yield each number that differs, and what it is now."""
    for command in programs(build, suite):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        yield from DIFFERS.findall(done.stdout)


def main() -> None:
    """Rewrite the numbers of every suite of traces."""
    build, problems, changed = Path(sys.argv[1]).resolve(), [], 0
    for source in sorted((ROOT / "host_tests").rglob("test_*_traces.c")):
        text = source.read_text(encoding="utf-8")
        known: dict[str, str] = {}
        for before, now in changes(build, source.stem):
            if known.setdefault(before, now) != now:
                problems.append(f"{source.name}: {before} is {known[before]} and {now}")
            elif f"{before}uL" in text:
                text = text.replace(f"{before}uL", f"{now}uL")
                changed += 1
        source.write_text(text, encoding="utf-8")
    finish("trace_numbers", f"{changed} numbers changed", problems)


if __name__ == "__main__":
    main()
