# SPDX-License-Identifier: MIT
"""Rule: flash, static RAM and the worst stack of each image stay within its board's limits.

    sizes.py BOARD=IMAGE.elf...          prints the numbers, fails over a limit
    sizes.py --json BOARD=IMAGE.elf...   the numbers as JSON, for a table

The worst stack is counted on the disassembly: the deepest path of main, and on top of it the
deepest interrupt handler (all of them, as far as handlers let others in).
"""

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

from avr_image import Image, ImageError, read_image, run
from common import finish


@dataclass(frozen=True)
class Limits:
    """What a board has, in bytes, and how much RAM must be left over in the worst case."""

    flash: int
    ram: int
    reserve: int


# The one table. Flash is the part's, less the Arduino boot loader.
LIMITS = {
    "uno": Limits(flash=32_768 - 512, ram=2_048, reserve=256),
    "mega": Limits(flash=262_144 - 8_192, ram=8_192, reserve=1_024),
}

FLASH_SECTIONS = {".text", ".data"}
RAM_SECTIONS = {".data", ".bss", ".noinit"}


@dataclass(frozen=True)
class Size:
    """The numbers of one image, in bytes."""

    flash: int
    static_ram: int
    worst_stack: int
    free: int
    stack_path: list[str]


def section_bytes(elf: Path) -> dict[str, int]:
    """Sizes of the ELF file's sections by name."""
    rows = (line.split() for line in run(["avr-size", "-A", str(elf)]).splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) == 3 and row[1].isdigit()}


def worst_stack(image: Image) -> tuple[int, list[str]]:
    """Worst stack in bytes, and the functions on the path."""
    for name in sorted(image.reachable("main")):
        if image.functions[name].indirect:
            raise ImageError(f"{name} calls through a pointer: its stack cannot be counted")
    total, path = image.deepest("main")
    total += image.return_bytes
    nesting, alone = [], [(0, [])]
    for handler in image.handlers():
        taken, handler_path = image.deepest(handler)
        opens = any(image.functions[name].opens_interrupts for name in image.reachable(handler))
        (nesting if opens else alone).append((taken + image.return_bytes, handler_path))
    for taken, handler_path in [*nesting, max(alone, key=lambda one: one[0])]:
        total += taken
        path = path + handler_path
    return total, path


def measure(board: str, elf: Path) -> Size:
    """All numbers of one image."""
    sections = section_bytes(elf)
    flash = sum(sections.get(name, 0) for name in FLASH_SECTIONS)
    static_ram = sum(sections.get(name, 0) for name in RAM_SECTIONS)
    stack, path = worst_stack(read_image(elf))
    return Size(flash, static_ram, stack, LIMITS[board].ram - static_ram - stack, path)


def over_limits(board: str, size: Size) -> list[str]:
    """Complaints about one image."""
    limits, found = LIMITS[board], []
    if size.flash > limits.flash:
        found.append(f"{board}: {size.flash} bytes of flash, at most {limits.flash}")
    if size.free < limits.reserve:
        found.append(
            f"{board}: {size.free} bytes of RAM left with the worst stack, at least "
            f"{limits.reserve} ({' > '.join(size.stack_path)})"
        )
    return found


def main() -> None:
    """Measure the images named on the command line against the table."""
    arguments = [argument for argument in sys.argv[1:] if argument != "--json"]
    sizes: dict[str, Size] = {}
    problems: list[str] = []
    for argument in arguments:
        board, _, elf = argument.partition("=")
        try:
            sizes[board] = measure(board, Path(elf))
        except ImageError as error:
            problems.append(f"{board}: {error}")
            continue
        problems += over_limits(board, sizes[board])
    if "--json" in sys.argv:
        print(json.dumps({board: asdict(size) for board, size in sizes.items()}, indent=2))
        sys.exit(1 if problems else 0)
    for board, size in sizes.items():
        print(
            f"{board}: flash {size.flash}, static RAM {size.static_ram}, "
            f"worst stack {size.worst_stack}, left {size.free} bytes"
        )
    finish("sizes", f"{len(sizes)} images", problems)


if __name__ == "__main__":
    main()
