# SPDX-License-Identifier: MIT
"""Registers read by name, those that adjoin in one request."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from pixstep.board.registers import Register

MOST_WORDS = 125  # of one request
Read = Callable[[int, int], list[int]]  # first address and number of words


class Place(NamedTuple):
    """A register of a board under the name and at the address that it has there."""

    name: str
    address: int
    register: Register

    @property
    def end(self) -> int:
        """The address behind it."""
        return self.address + self.register.words


def places(registers: Iterable[Register]) -> list[Place]:
    """Return registers under their own names, where the map has them."""
    return [Place(item.name, item.address, item) for item in registers]


def values(wanted: Iterable[Place], read: Read) -> dict[str, int]:
    """Read registers of one area in one request per gapless stretch; return them by name."""
    found = {}
    for stretch in _stretches(wanted):
        first = stretch[0].address
        words = read(first, stretch[-1].end - first)
        for place in stretch:
            mine = words[place.address - first : place.end - first]
            found[place.name] = place.register.decode(mine)
    return found


def _stretches(wanted: Iterable[Place]) -> list[list[Place]]:
    """Group registers into gapless stretches, each fit for one request."""
    groups: list[list[Place]] = []
    for place in sorted(wanted, key=lambda item: item.address):
        last = groups[-1] if groups else []
        fits = last and place.address == last[-1].end
        if fits and place.end - last[0].address <= MOST_WORDS:
            last.append(place)
        else:
            groups.append([place])
    return groups
