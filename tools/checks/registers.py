# SPDX-License-Identifier: MIT
"""Rule: the decoder's assembly leaves r2 to r6 alone, which belong to the step interrupt.

    registers.py IMAGE.elf...

Read off the disassembly, where every macro has become instructions.
"""

import re
import sys
from pathlib import Path

from avr_image import run
from common import ROOT, finish

RESERVED = re.compile(r"\br[2-6]\b")
GLOBAL = re.compile(r"^\s*\.global\s+(?P<name>\w+)", re.MULTILINE)
SYMBOL = re.compile(r"^(?P<start>[0-9a-f]+) (?P<size>[0-9a-f]+) \w (?P<name>\w+)$", re.MULTILINE)


def assembly_functions() -> set[str]:
    """Names that the assembly files of core define for others."""
    files = (ROOT / "firmware" / "core").glob("*/*.S")
    return {name for file in files for name in GLOBAL.findall(file.read_text(encoding="utf-8"))}


def check_function(path: Path, name: str, start: int, size: int) -> list[str]:
    """Instructions of one function that name a reserved register."""
    span = [f"--start-address={start}", f"--stop-address={start + size}"]
    listing = run(["avr-objdump", "-d", "--no-show-raw-insn", *span, str(path)]).splitlines()
    return [
        f"{path.name}: {name}: {line.strip()}"
        for line in listing
        if RESERVED.search(line.split(";")[0])
    ]


def check_image(path: Path, names: set[str]) -> list[str]:
    """Problems of one image."""
    problems, missing = [], set(names)
    for symbol in SYMBOL.finditer(run(["avr-nm", "-S", str(path)])):
        if symbol["name"] in names:
            missing.discard(symbol["name"])
            start, size = int(symbol["start"], 16), int(symbol["size"], 16)
            problems += check_function(path, symbol["name"], start, size)
    return problems + [f"{path.name}: {name} is not there" for name in sorted(missing)]


def main() -> None:
    """Check the images named on the command line."""
    names = assembly_functions()
    problems = [problem for name in sys.argv[1:] for problem in check_image(Path(name), names)]
    finish("registers", f"{len(names)} functions in {len(sys.argv) - 1} images", problems)


if __name__ == "__main__":
    main()
