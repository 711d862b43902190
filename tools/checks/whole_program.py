# SPDX-License-Identifier: MIT
"""Which module the bytes of core and app belong to, which the linker makes as one object.

The image's symbols say where each function and table begins and how long it is; the objects that
the compiler made before (fat: each with its own code) say which module defines a symbol of that
name.
Code that was moved into its caller counts there. Several modules may have a local symbol of one
name: each of the image's then belongs to the module whose own is nearest in length. What no symbol
covers is shared by all.
"""

import bisect
import re
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from map_file import Bytes, MapError, Part

SHARED = "shared"
SYMBOL = re.compile(r"^(?P<at>[0-9a-f]+) (?P<size>[0-9a-f]+) [A-Za-z] (?P<name>\S+)$", re.MULTILINE)

Owners = dict[str, dict[str, int]]  # by name: the length in each module that defines it


@dataclass(frozen=True)
class Symbol:
    """A function, table or variable, its name without what the compiler appended (.constprop.0)."""

    at: int
    size: int
    name: str


def parse_symbols(listing: str) -> list[Symbol]:
    """Read the output of nm -S; symbols without a length are no objects."""
    return [
        Symbol(int(row["at"], 16), int(row["size"], 16), row["name"].partition(".")[0])
        for row in SYMBOL.finditer(listing)
    ]


def read_symbols(path: Path) -> list[Symbol]:
    """Let nm list an object or an image."""
    try:
        listed = subprocess.run(
            ["avr-nm", "-S", str(path)], capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError) as error:
        words = getattr(error, "stderr", "") or str(error)
        raise MapError(f"{path}: {words.strip()}: build first") from None
    return parse_symbols(listed.stdout)


def owners(objects: Iterable[tuple[str, list[Symbol]]]) -> Owners:
    """The modules that define each name, with the lengths there; modules with their symbols."""
    found: Owners = {}
    for module, symbols in objects:
        for one in symbols:
            lengths = found.setdefault(one.name, {})
            lengths[module] = max(lengths.get(module, 0), one.size)
    return found


def assign(symbols: list[Symbol], lengths: dict[str, int]) -> list[str]:
    """The module of each of several symbols of one name, nearest in length, each module once.

    Copies of one module's function for some of its callers share the module once all have one.
    """
    pairs = sorted(
        (abs(one.size - length), index, module)
        for index, one in enumerate(symbols)
        for module, length in lengths.items()
    )
    chosen: dict[int, str] = {}
    for _, index, module in pairs:
        if index not in chosen and module not in chosen.values():
            chosen[index] = module
    for _, index, module in pairs:
        chosen.setdefault(index, module)
    return [chosen[index] for index in range(len(symbols))]


def by_module(parts: list[Part], symbols: list[Symbol], defined: Owners) -> dict[str, Bytes]:
    """Bytes of each module in the parts of the one object; what is left is SHARED."""
    found: dict[str, Bytes] = {}
    named: dict[str, list[Symbol]] = {}
    ordered = sorted(parts, key=lambda part: part.at)
    starts = [part.at for part in ordered]

    def part_of(one: Symbol) -> Part | None:
        index = bisect.bisect_right(starts, one.at) - 1
        part = ordered[index] if index >= 0 else None
        return part if part and one.at + one.size <= part.at + part.size else None

    for one in {(symbol.at, symbol.size): symbol for symbol in symbols}.values():
        if one.name in defined and part_of(one):
            named.setdefault(one.name, []).append(one)
    for name, several in named.items():
        for one, module in zip(several, assign(several, defined[name]), strict=True):
            flash, ram = part_of(one).section.bytes(one.size)
            found.setdefault(module, Bytes()).add(flash, ram)
    rest = Bytes()
    for part in parts:
        rest.add(*part.section.bytes(part.size))
    for taken in found.values():
        rest.add(-taken.flash, -taken.ram)
    if rest.flash < 0 or rest.ram < 0:
        raise MapError(f"symbols are longer than what the linker placed, by {rest}")
    return found | ({SHARED: rest} if rest != Bytes() else {})
