# SPDX-License-Identifier: MIT
"""Rule: flash, static RAM and the worst stack of each image stay within its board's limits.

    sizes.py BOARD=IMAGE.elf...          prints the numbers, fails over a limit
    sizes.py --json BOARD=IMAGE.elf...   the numbers as JSON, for a table

The worst stack is counted on the disassembly: the deepest path of main, and on top of it the
deepest interrupt handler (all of them, as far as handlers let others in).
"""

import json
import re
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import boards
from avr_image import read_image, run
from avr_stack import Image, ImageError
from common import finish


@dataclass(frozen=True)
class Limits:
    """What a board has, in bytes, and how much of both must be left over in the worst case."""

    flash: int
    ram: int
    reserve: int
    flash_reserve: int


def limits_of(board: str) -> Limits:
    """A board's limits. Flash is the part's, less the boot loader."""
    number = boards.load(board).number
    return Limits(
        flash=number("FLASH_BYTES") - number("BOOT_BYTES"),
        ram=number("RAM_BYTES"),
        reserve=number("STACK_RESERVE_BYTES"),
        flash_reserve=int(boards.load(board).constants.get("FLASH_RESERVE_BYTES", "0"), 0),
    )


def exclusive(board: str) -> list[set[int]]:
    """Handlers of which only one can be active, by vector.

    The three of the serial port mask each other before they let anybody in
    (firmware/avr/hal/uart.c), and a timer's overflow interrupt is off while its compare A interrupt
    is on (step_timer.c).
    """
    part = boards.load(board)
    timers = zip(part.timer_vectors("COMPA"), part.timer_vectors("OVF"), strict=True)
    return [part.serial_vectors, *(set(pair) for pair in timers)]


# The word below the stack that tells when it grew too far (firmware/avr/hal/cpu.c).
CANARY_BYTES = 2

# avr-gcc's one address space: flash from 0, RAM and EEPROM far above.
RAM_AT = 0x800000
EEPROM_AT = 0x810000

SECTION = re.compile(
    r"^\s*\d+ (?P<name>\S+)\s+(?P<size>[0-9a-f]{8})\s+(?P<run>[0-9a-f]{8})\s+"
    r"(?P<load>[0-9a-f]{8})\s+\S+\s+\S+\s+(?P<flags>.*)$",
    re.MULTILINE,
)


@dataclass(frozen=True)
class Size:
    """The numbers of one image, in bytes."""

    flash: int
    static_ram: int
    worst_stack: int
    free: int
    stack_path: list[str]


def memory_bytes(board: str, elf: Path) -> tuple[int, int]:
    """Flash and RAM up to the last byte in use: gaps that alignment leaves count."""
    ram_start = RAM_AT + boards.load(board).number("RAM_START")
    flash_end, ram_end = 0, ram_start
    for section in SECTION.finditer(run(["avr-objdump", "-h", "-w", str(elf)])):
        size, runs, load = (int(section[part], 16) for part in ("size", "run", "load"))
        if "ALLOC" not in section["flags"] or size == 0:
            continue
        if RAM_AT <= runs < EEPROM_AT:
            ram_end = max(ram_end, runs + size)
        if "LOAD" in section["flags"] and load < RAM_AT:
            flash_end = max(flash_end, load + size)
        elif "LOAD" in section["flags"] and load < EEPROM_AT:
            raise ImageError(f"section {section['name']} would be loaded into RAM (at {load:#x})")
    return flash_end, ram_end - ram_start


def group_of(board: str, handler: str) -> str:
    """A name shared by the handlers of which only one can be active."""
    vector = int(handler.removeprefix("__vector_"))
    group = next((one for one in exclusive(board) if vector in one), {vector})
    return f"__vector_{min(group)}"


def worst_stack(board: str, image: Image) -> tuple[int, list[str]]:
    """Worst stack in bytes, and the functions on the path."""
    total, path = image.deepest("main")
    total += image.return_bytes
    nesting: dict[str, tuple[int, list[str]]] = {}
    alone: list[tuple[int, list[str]]] = [(0, [])]
    for handler in image.handlers():
        taken, handler_path = image.deepest(handler)
        one = (taken + image.return_bytes, handler_path)
        if any(image.functions[name].opens_interrupts for name in image.reachable(handler)):
            group = group_of(board, handler)
            nesting[group] = max(nesting.get(group, one), one)
        else:
            alone.append(one)
    for taken, handler_path in [*nesting.values(), max(alone, key=lambda one: one[0])]:
        total += taken
        path = path + handler_path
    return total, path


def measure(board: str, elf: Path) -> Size:
    """All numbers of one image."""
    flash, static_ram = memory_bytes(board, elf)
    static_ram += CANARY_BYTES
    stack, path = worst_stack(board, read_image(elf))
    return Size(flash, static_ram, stack, limits_of(board).ram - static_ram - stack, path)


def over_limits(board: str, size: Size) -> list[str]:
    """Problems of one image."""
    limits, found = limits_of(board), []
    most = limits.flash - limits.flash_reserve
    if size.flash > most:
        found.append(f"{board}: {size.flash} bytes of flash, at most {most}")
    if size.free < limits.reserve:
        found.append(
            f"{board}: {size.free} bytes of RAM left with the worst stack, at least "
            f"{limits.reserve} ({' > '.join(size.stack_path)})"
        )
    return found


def text(board: str, size: Size) -> str:
    """The numbers of one image as a line, what is left with its limit."""
    limits = limits_of(board)
    flash = limits.flash - size.flash
    return (
        f"{board}: flash {size.flash}, left {flash} bytes (at least {limits.flash_reserve}); "
        f"static RAM {size.static_ram}, worst stack {size.worst_stack}, "
        f"left {size.free} bytes (at least {limits.reserve})"
    )


def main() -> None:
    """Measure the images named on the command line against their boards' limits."""
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
        print(text(board, size))
    finish("sizes", f"{len(sizes)} images", problems)


if __name__ == "__main__":
    main()
