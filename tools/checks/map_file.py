# SPDX-License-Identifier: MIT
"""What the linker's map says of an AVR image: the bytes of flash and RAM that each object takes."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

# avr-gcc's one address space: flash from 0, RAM and EEPROM far above.
RAM_AT = 0x800000
EEPROM_AT = 0x810000

# Of the sections at addresses below RAM only this one is in the flash; the others describe it.
FLASH_SECTION = ".text"

# The object that the linker has made of all objects that are optimised as one program.
WHOLE_PROGRAM = "whole program"
LTO_OBJECT = re.compile(r"\.ltrans\d*(?:\.ltrans)?\.o$")

MEMORY_MAP = "Linker script and memory map"
GAPS = "gaps"
STUBS = "linker stubs"

PLACE = r"\s+0x(?P<at>[0-9a-f]+)\s+0x(?P<size>[0-9a-f]+)"
OUTPUT = re.compile(rf"^(?P<name>\.\S+){PLACE}(?P<load> load address)?")
INPUT = re.compile(rf"^ (?:\.\S+|COMMON|\*fill\*){PLACE} ?(?P<owner>.*)$")


class MapError(Exception):
    """The map cannot be read; the message says why."""


@dataclass
class Bytes:
    """Bytes of flash and of RAM; what is initialised takes both."""

    flash: int = 0
    ram: int = 0

    def add(self, flash: int, ram: int) -> None:
        """Add to both."""
        self.flash += flash
        self.ram += ram


@dataclass(frozen=True)
class Section:
    """An output section: whether its bytes are in flash, in RAM or in both."""

    in_flash: bool
    in_ram: bool

    def bytes(self, size: int) -> tuple[int, int]:
        """Flash and RAM that so many bytes of the section take."""
        return size * self.in_flash, size * self.in_ram


@dataclass(frozen=True)
class Part:
    """A stretch of the image that the program optimised as a whole takes."""

    at: int
    size: int
    section: Section


@dataclass
class Image:
    """The bytes of each object of an image by the object's name in the map, and of all of it."""

    objects: dict[str, Bytes] = field(default_factory=dict)
    total: Bytes = field(default_factory=Bytes)
    whole: list[Part] = field(default_factory=list)  # of WHOLE_PROGRAM


def unwrapped(text: str) -> Iterator[str]:
    """Lines of the memory map, with a long section name's second line joined to it."""
    _, found, body = text.partition(MEMORY_MAP)
    if not found:
        raise MapError("no memory map in it")
    held = ""
    for line in body.splitlines():
        if re.fullmatch(r" ?\.\S+", line):
            held = line
            continue
        yield held + line if held and line.startswith("  ") else line
        held = ""


def section_of(match: re.Match[str]) -> Section:
    """What an output section's head says of its place."""
    at, loaded = int(match["at"], 16), match["load"] is not None
    in_ram = RAM_AT <= at < EEPROM_AT
    return Section(match["name"] == FLASH_SECTION or (in_ram and loaded), in_ram)


def owner_of(text: str) -> str:
    """Name of an object in the map: a source's object file, or the library it comes from."""
    if not text or text == STUBS:
        return text or GAPS
    if LTO_OBJECT.search(text):
        return WHOLE_PROGRAM
    archive = re.search(r"([^/]+)\(([^)]+)\)$", text)
    if archive is None:
        return Path(text).name
    library, member = archive.groups()
    return member if re.search(r"\.(?:c|S)\.o(?:bj)?$", member) else library


def read_map(text: str) -> Image:
    """Sum up a map; MapError if what the objects take is not what the sections have."""
    image, section = Image(), Section(False, False)
    for line in unwrapped(text):
        head, part = OUTPUT.match(line), INPUT.match(line)
        if head:
            section = section_of(head)
            image.total.add(*section.bytes(int(head["size"], 16)))
        elif line[:1] == ".":
            section = Section(False, False)
        elif part and int(part["size"], 16):
            size, owner = int(part["size"], 16), owner_of(part["owner"].strip())
            taken = section.bytes(size)
            if any(taken):
                image.objects.setdefault(owner, Bytes()).add(*taken)
            if any(taken) and owner == WHOLE_PROGRAM:
                image.whole.append(Part(int(part["at"], 16), size, section))
    check_sum(image)
    return image


def check_sum(image: Image) -> None:
    """Raise MapError if something of a section has no owner."""
    summed = Bytes()
    for one in image.objects.values():
        summed.add(one.flash, one.ram)
    if summed != image.total:
        raise MapError(f"its objects take {summed}, its sections {image.total}")
