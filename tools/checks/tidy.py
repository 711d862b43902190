# SPDX-License-Identifier: MIT
"""clang-tidy over a compile database: one process on each core, each with its share of the files.

    tidy.py [--without-paths] CLANG_TIDY BUILD_DIR FOLDER...

Only files under these folders of the repository are read. --without-paths leaves out clang's
analyzer, which follows every path through a function and takes nine tenths of the time.
A database of avr-gcc is read with the AVR's own types (int has 16 bits) and avr-libc's headers.
"""

import argparse
import functools
import json
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from common import ROOT, finish

# Flags of gcc that clang does not know; without this, each would be an error of its own.
QUIET = ["-Wno-unknown-warning-option", "-Wno-unused-command-line-argument"]

# Against the .clang-tidy of the project. clang-tidy obeys only the last --checks it is given.
WITHOUT_PATHS = "-clang-analyzer-*"

# Folders that are built for the AVR too.
FOR_AVR = ("firmware", "host_tests")

# Tells on the AVR where 16 bits are multiplied too early; on the PC, of the same line, nonsense.
ONLY_ON_AVR = "-bugprone-implicit-widening-of-multiplication-result"

# The folder of headers that stands for the AVR's where the firmware runs in the explorer.
EXPLORED = "/host_tests/explore/part"

# What avr-libc's own macros (ISR) use.
QUIET_AVR = ["-Wno-unknown-attributes", "-Wno-variadic-macro-arguments-omitted"]

# Flags of avr-gcc that clang takes for errors.
NOT_CLANGS = (
    *("-ffixed-", "-mrelax", "-mcall-prologues", "-mstrict-X", "-flto", "-ffat-lto-objects"),
    *("-fno-tree-", "-fno-ipa-", "-fipa-", "-fno-move-loop-invariants"),
)
# A file that is a macro in angle brackets looks like an expression without parentheses.
FILE_MACRO = re.compile(r"-D(BOARD_FILE|BOARD_KINDS)=\"?<([^>]*)>\"?")


def database_for_clang(build: Path, folder: str, wanted: tuple[str, ...]) -> list[dict[str, str]]:
    """The compile database of the wanted files, one entry for each, as clang accepts it."""
    listed = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    chosen = {
        entry["file"]: entry
        for entry in listed
        if entry["file"].startswith(wanted)
        and entry["file"].endswith(".c")
        and not built_twice(entry)
    }
    entries = list(chosen.values())
    for entry in entries:
        words = FILE_MACRO.sub(r'-D\1=\\"\2\\"', entry["command"]).split(" ")
        kept = [word for word in words if not word.startswith(NOT_CLANGS)]
        entry["command"] = " ".join([*kept, *flags_for(entry["command"])])
    (Path(folder) / "compile_commands.json").write_text(json.dumps(entries), encoding="utf-8")
    return entries


@functools.cache
def avr_headers() -> str:
    """avr-libc's headers, next to where avr-gcc keeps the part's own."""
    found = subprocess.run(
        ["avr-gcc", "-print-file-name=../../../avr/include"],
        capture_output=True,
        check=True,
        text=True,
    )
    candidate = Path(found.stdout.strip())
    return str(candidate.resolve() if candidate.is_dir() else Path("/usr/lib/avr/include"))


def part_definition(arguments: str) -> list[str]:
    """The macro by which avr-libc knows the part: -mmcu is not clang's to understand everywhere."""
    for word in arguments.split():
        if word.startswith("-mmcu=atmega"):
            return [f"-D__AVR_ATmega{word.removeprefix('-mmcu=atmega').upper()}__"]
    return []


def flags_for(command: str) -> list[str]:
    """Flags that clang needs behind one command of the database."""
    if "avr-gcc" not in command.split()[0]:
        return QUIET
    return [
        *QUIET,
        *QUIET_AVR,
        "--target=avr",
        "-nostdlibinc",
        f"-isystem{avr_headers()}",
        *part_definition(command),
    ]


def left_out(entry: dict[str, str]) -> list[str]:
    """Checks that say nothing of use about one entry."""
    by_avr_gcc = "avr-gcc" in entry["command"].split()[0]
    both = any(Path(entry["file"]).is_relative_to(ROOT / one) for one in FOR_AVR)
    return [ONLY_ON_AVR] if both and not by_avr_gcc else []


def shares(entries: list[dict[str, str]], count: int) -> Iterator[tuple[list[str], list[str]]]:
    """Checks to leave out, and files that are read without these: about `count` equal shares."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for entry in entries:
        alike.setdefault(tuple(left_out(entry)), []).append(entry["file"])
    for checks, files in alike.items():
        for first in range(count):
            if share := files[first::count]:
                yield list(checks), share


def check(words: list[str]) -> list[str]:
    """Findings of one process: most of the time for a single file is clang-tidy's own start."""
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode == 0:
        return []
    return [done.stdout.strip() or done.stderr.strip()]


def built_twice(entry: dict[str, str]) -> bool:
    """True for the explorer's instrumented copy of a firmware source, which is read as it is."""
    return EXPLORED in entry["command"] and "/firmware/" in entry["file"]


def main() -> None:
    """Run clang-tidy over what the arguments choose."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--without-paths", action="store_true")
    parser.add_argument("tidy")
    parser.add_argument("build", type=Path)
    parser.add_argument("folders", nargs="+")
    options = parser.parse_args()
    paths = [WITHOUT_PATHS] if options.without_paths else []
    wanted = tuple(f"{ROOT / folder}{os.sep}" for folder in options.folders)
    processes = os.cpu_count() or 1
    with tempfile.TemporaryDirectory() as database, ThreadPoolExecutor(processes) as pool:
        entries = database_for_clang(options.build, database, wanted)
        common = [options.tidy, "--quiet", "-p", database]
        commands = [
            [*common, f"--checks={','.join([*paths, *checks])}", *files]
            for checks, files in shares(entries, processes)
        ]
        problems = [finding for found in pool.map(check, commands) for finding in found]
    finish("clang-tidy", f"{len(entries)} files of {options.build.name}", problems)


if __name__ == "__main__":
    main()
