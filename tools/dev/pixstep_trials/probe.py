# SPDX-License-Identifier: MIT
"""Looks into a simulated board and disturbs it, for what proves the project: RAM, EEPROM, hangs."""

from typing import NamedTuple

from pixstep.simulation.simulator import Simulator


class EepromState(NamedTuple):
    """Writes of EEPROM bytes begun so far, and the one on its way."""

    writes: int
    address: int | None  # None: no byte is being written
    left_cycles: int


class Symbol(NamedTuple):
    """A place in a board's image: "flash", "ram" or "eeprom", byte address, bytes (0: unknown)."""

    space: str
    address: int
    size: int


class BoardProbe:
    """Reads and disturbs the boards of a simulator."""

    def __init__(self, simulator: Simulator) -> None:
        self.command = simulator.command

    def peek(self, board: int, place: int | str, count: int | None = None) -> bytes:
        """Return RAM or registers as they stand, without a read's side effects.

        `place` is an address or a symbol of the image, "name" or "name+2"; without `count` to the
        symbol's end.
        """
        return _bytes(self.command(_words("peek", board, place, count)))

    def poke(self, board: int, place: int | str, data: bytes) -> None:
        """Put bytes into RAM at an address or symbol."""
        self.command(_words("poke", board, place, data.hex()))

    def symbol(self, board: int, name: str) -> Symbol:
        """Return where a symbol of the board's image is."""
        space, address, size = self.command(f"symbol {board} {name}").split()[1:]
        return Symbol(space, int(address, 0), int(size))

    def eeprom_read(self, board: int, place: int | str, count: int | None = None) -> bytes:
        """Return bytes of the EEPROM; a byte that is being written is still the old one."""
        return _bytes(self.command(_words("eeprom", board, "read", place, count)))

    def eeprom_write(self, board: int, place: int | str, data: bytes) -> None:
        """Put bytes into the EEPROM, at once and from outside."""
        self.command(_words("eeprom", board, "write", place, data.hex()))

    def eeprom_state(self, board: int) -> EepromState:
        """Return how many bytes the program has written, and which one is on its way."""
        writes, address, left = self.command(f"eeprom {board} state").split()[1:]
        return EepromState(int(writes), None if address == "-" else int(address), int(left))

    def hang(self, board: int, what: str, *, kept: bool = False) -> None:
        """Make a board's program go astray until it is reset, or `kept` through resets too.

        `what` is "main" (the main loop stands still, interrupts go on), "interrupts" (a loop with
        interrupts off), "for CYCLES" (the processor stands still once, timers go on), "axis N" (its
        step interrupt returns at once), "at SYMBOL" (the instruction there jumps to itself) or
        "off" (every hang ends, the program goes on from where it stands).
        """
        self.command(f"hang {board} {what}{' kept' if kept else ''}")


def _words(*words: object) -> str:
    return " ".join(str(word) for word in words if word is not None)


def _bytes(answer: str) -> bytes:
    return bytes.fromhex(answer.split()[1].replace("-", ""))
