# SPDX-License-Identifier: MIT
"""What a fuzzing target is built from, and builds of it with something changed or counted.

The host build writes a response file for each target (compiler options and sources, one a line)
and keeps clang's object of each source; everything here goes by these.
"""

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from pixstep import natives
from pixstep.errors import UserError

_SANITIZERS = ["-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=all"]
_COUNTED = re.compile(r"File '(.+)'\nLines executed:([\d.]+)% of (\d+)")


@dataclass(frozen=True)
class Defect:
    """A defect to plant: in `file` (under firmware/), `right` becomes `wrong`."""

    target: str
    file: str
    right: str
    wrong: str
    about: str


@dataclass(frozen=True)
class FileCoverage:
    """Lines of a firmware file that a corpus reaches."""

    file: str
    lines: int
    reached: int


def words(target: str) -> list[str]:
    """Return the compiler's words for a target; raises UserError if it is not configured."""
    path = natives.root() / "build" / "host" / "fuzz" / f"{target}.rsp"
    try:
        return path.read_text(encoding="utf-8").split("\n")[:-1]
    except OSError:
        raise UserError(
            f"{path}: missing; run tools/setup (it installs clang), then `cmake --preset host`"
        ) from None


def _object(source: Path) -> str:
    """Return where the host build keeps clang's object of a source."""
    inside = source.relative_to(natives.root())
    return str(natives.root() / "build" / "host" / "fuzz" / "objects" / f"{inside}.o")


def planted_text(defect: Defect) -> str:
    """Return the text of a defect's file with the defect.

    Raises UserError, which names the file, if the right text is not there exactly once: then the
    file has changed, and the defect must follow it.
    """
    source = natives.source(f"firmware/{defect.file}")
    text = source.read_text(encoding="utf-8")
    found = text.count(defect.right)
    if found != 1:
        raise UserError(
            f"{source}: the defect {defect.about!r} cannot be planted: {defect.right!r} is there "
            f"{found} times, not once"
        )
    return text.replace(defect.right, defect.wrong)


def build_with(defect: Defect, folder: Path) -> Path:
    """Build a target's fuzzer with a planted defect in `folder`; return the program.

    Only the source with the defect is compiled; the other objects are those of the built fuzzer.
    Raises UserError for a defect that cannot be planted.
    """
    source = natives.source(f"firmware/{defect.file}")
    text = planted_text(defect)
    planted = folder / "firmware" / source.name  # where the fuzzer is guided by what it reaches
    planted.parent.mkdir(parents=True, exist_ok=True)
    planted.write_text(text, encoding="utf-8")
    program = folder / "fuzz"
    covered = f"-fsanitize-coverage-allowlist={natives.source('fuzz/covered.txt')}"
    options = [word for word in words(defect.target) if not word.endswith(".c")]
    linked = [
        str(planted) if word == str(source) else _object(Path(word))
        for word in words(defect.target)
        if word.endswith(".c")
    ]
    _compile(["clang", *_SANITIZERS, covered, *options, *linked, "-o", str(program)], folder)
    return program


def coverage(target: str, corpus: Path, folder: Path) -> list[FileCoverage]:
    """Play a corpus file through a build that counts lines; return the firmware's files."""
    program = folder / "replay"
    replay = natives.source("fuzz/replay.c")
    options = ["--coverage", "-O0", "-w"]
    _compile(["gcc", *words(target), str(replay), *options, "-o", str(program)], folder)
    _compile([str(program), str(corpus)], folder)
    counts = [path.name for path in folder.glob("*.gcda")]
    firmware = f"{natives.root() / 'firmware'}/"
    found = []
    for name, share, lines in _COUNTED.findall(_compile(["gcov", "-n", *counts], folder)):
        if name.startswith(firmware):
            reached = round(float(share) * int(lines) / 100)
            found.append(FileCoverage(name.removeprefix(firmware), int(lines), reached))
    return sorted(found, key=lambda item: item.file)


def _compile(command: list[str], folder: Path) -> str:
    """Run a command in a folder; return its output."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except OSError as error:
        raise UserError(f"{command[0]}: {error.strerror or error}") from None
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise UserError(f"{command[0]}: {said[0] if said else done.returncode}")
    return done.stdout
