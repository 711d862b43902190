# SPDX-License-Identifier: MIT
"""Places the functions of an image so that as many calls as possible are short.

    place_functions.py IMAGE.elf firmware/avr/boards/uno_order.ld [--tries 600000]

A call or jump between functions takes two bytes of flash where its end is at most 4 KB away, else
four. The order of the functions is searched by simulated annealing, with the same result in each
run, and written as a linker script; IMAGE.map beside the image has the sizes. Functions that the
script does not name come last, and a name that no function has does no harm: after a change of the
firmware the order is a little less good, not wrong. To place the functions of a small board anew:

    cmake --build --preset uno && place_functions.py build/uno/firmware/pixstep-uno.elf \\
        firmware/avr/boards/uno_order.ld && cmake --build --preset uno
"""

import argparse
import bisect
import math
import random
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from avr_image import run

# The farthest end of a short jump, bytes, with a margin for what the linker still makes shorter.
REACH = 4090
# Temperatures of the annealing, calls: where it begins, and where it ends.
HOT, COLD = 2.5, 0.05
# Sections that are moved together, at most.
MOST_TOGETHER = (1, 1, 1, 2, 3, 6, 12, 25)

SECTION = re.compile(r"^ (\.text\.\S+)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) \S", re.MULTILINE)
JUMP = re.compile(
    r"^\s+([0-9a-f]+):\t[0-9a-f ]+\tr?(?:call|jmp)\t(0x[0-9a-f]+|\.[+-]\d+)", re.MULTILINE
)
# A clone of a function is called after it; the compiler numbers clones anew with each change.
CLONE = re.compile(r"^(\.text\.(?!libgcc\.|startup\.|unlikely\.)[^.]+)\..*$")

HEAD = """\
/* SPDX-License-Identifier: MIT
   The order of the functions in the image; made by tools/checks/place_functions.py. What stands in
   front of the functions stands there as the linker's own script has it, and all that is not named
   here follows. */
SECTIONS
{
  .text :
  {
    *(.vectors)
    KEEP(*(.vectors))
    *(.progmem*)
    . = ALIGN(2);
    *(.lowtext*)
"""
TAIL = """\
  }
}
INSERT AFTER .rela.plt;
"""


@dataclass(frozen=True)
class Section:
    """A function's section: where it is now, and its bytes."""

    at: int
    size: int
    name: str


@dataclass(frozen=True)
class Call:
    """Calls from one section to another, by their numbers and the places inside them."""

    caller: int
    from_byte: int
    callee: int
    to_byte: int


def sections_of(map_text: str) -> list[Section]:
    """The sections of functions, by their addresses."""
    placed = map_text[map_text.index("Linker script and memory map") :]
    found = {
        Section(int(at, 16), int(size, 16), name)
        for name, at, size in SECTION.findall(placed)
        if int(size, 16) != 0
    }
    return sorted(found, key=lambda section: section.at)


def calls_between(sections: list[Section], disassembly: str) -> Counter[Call]:
    """How often each call from section to section stands in the image."""
    starts = [section.at for section in sections]

    def number_at(address: int) -> int | None:
        number = bisect.bisect_right(starts, address) - 1
        inside = number >= 0 and address < starts[number] + sections[number].size
        return number if inside else None

    found: Counter[Call] = Counter()
    for place, operand in JUMP.findall(disassembly):
        address = int(place, 16)
        end = int(operand, 16) if operand[0] == "0" else address + 2 + int(operand[1:])
        caller, callee = number_at(address), number_at(end)
        if caller is not None and callee is not None and caller != callee:
            found[Call(caller, address - starts[caller], callee, end - starts[callee])] += 1
    return found


def short_calls(order: list[int], sizes: list[int], calls: list[tuple[int, int, int, int]]) -> int:
    """How many calls are short in this order. A call: caller, callee, bytes between both, count."""
    at = [0] * len(order)
    place = 0
    for number in order:
        at[number] = place
        place += sizes[number]
    return sum(
        count
        for caller, callee, offset, count in calls
        if -REACH < at[callee] - at[caller] + offset < REACH
    )


def best_order(sections: list[Section], found: Counter[Call], tries: int) -> tuple[list[int], int]:
    """The best order of the sections that so many tries find, and its short calls."""
    sizes = [section.size for section in sections]
    calls = [
        (call.caller, call.callee, call.to_byte - call.from_byte, count)
        for call, count in found.items()
    ]
    chance = random.Random(1)
    order = list(range(len(sections)))
    now = short_calls(order, sizes, calls)
    best, most = order, now
    for number in range(tries):
        warmth = HOT * (1 - number / tries) ** 1.5 + COLD
        together = min(chance.choice(MOST_TOGETHER), len(order) - 1)
        first = chance.randrange(len(order) - together)
        moved = order[first : first + together]
        rest = order[:first] + order[first + together :]
        to = chance.randrange(len(rest) + 1)
        tried = rest[:to] + moved + rest[to:]
        short = short_calls(tried, sizes, calls)
        if short >= now or chance.random() < math.exp((short - now) / warmth):
            order, now = tried, short
            if now > most:
                best, most = order, now
    return best, most


def script(sections: list[Section], order: list[int]) -> str:
    """The linker script with the functions in this order."""
    names = dict.fromkeys(CLONE.sub(r"\1", sections[number].name) for number in order)
    return HEAD + "".join(f"    *({name} {name}.*)\n" for name in names) + TAIL


def main() -> None:
    """Search, and write the script."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("image", type=Path)
    parser.add_argument("script", type=Path)
    parser.add_argument("--tries", type=int, default=600_000)
    options = parser.parse_args()
    sections = sections_of(options.image.with_suffix(".map").read_text())
    found = calls_between(sections, run(["avr-objdump", "-d", str(options.image)]))
    order, short = best_order(sections, found, options.tries)
    options.script.write_text(script(sections, order))
    print(f"{len(sections)} sections, {short} of {found.total()} calls are short")


if __name__ == "__main__":
    main()
