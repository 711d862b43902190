# SPDX-License-Identifier: MIT
"""A board by every Modbus function that its image serves, also those that no command needs."""

import struct

from pixstep.board import rtu
from pixstep.board.device import Device

COUNTERS = {  # function 08: name and sub-function
    "bus_messages": 11,
    "crc_errors": 12,
    "exceptions": 13,
    "requests": 14,
    "no_replies": 15,
    "naks": 16,
    "busy_replies": 17,
    "rx_overruns": 18,
}
_RESTART, _LISTEN_ONLY, _CLEAR_COUNTERS = 1, 4, 10  # sub-functions
_COIL_ON = 0xFF00


class EveryFunction(Device):
    """A board that is asked in every way."""

    def mask_write(self, address: int, keep: int, put: int) -> None:
        """Make a holding register (old AND keep) OR (put AND NOT keep) (function 22)."""
        with self._needs("diagnosis"):
            self._ask("mask write", rtu.MASK_WRITE, ">HHH", address, keep, put)

    def write_and_read(
        self, write_address: int, words: list[int], address: int, count: int
    ) -> list[int]:
        """Write holding registers, then read some, in one request (function 23)."""
        form = f">HHHHB{len(words)}H"
        head = (address, count, write_address, len(words), 2 * len(words))
        with self._needs("diagnosis"):
            data = self._ask("write and read", rtu.WRITE_AND_READ, form, *head, *words)
            return list(struct.unpack(f">{count}H", data[1:]))

    def read_coils(self, address: int, count: int) -> list[bool]:
        """Return `count` coils (function 01)."""
        with self._needs("bits"):
            data = self._ask("read of coils", rtu.READ_COILS, ">HH", address, count)
            return bits(data, count)

    def read_discretes(self, address: int, count: int) -> list[bool]:
        """Return `count` discrete inputs (function 02)."""
        with self._needs("bits"):
            data = self._ask("read of inputs", rtu.READ_DISCRETES, ">HH", address, count)
            return bits(data, count)

    def write_coil(self, address: int, value: bool) -> None:
        """Write one coil (function 05)."""
        with self._needs("bits"):
            word = _COIL_ON if value else 0
            self._ask("write of a coil", rtu.WRITE_COIL, ">HH", address, word)

    def echo(self, word: int) -> int:
        """Return what comes back of a word sent by function 08, sub-function 0."""
        return self._diagnosis("echo", 0, word)

    def counters(self) -> dict[str, int]:
        """Return the bus's counters by name (function 08, sub-functions 11 to 18)."""
        return {
            name: self._diagnosis(f"counter {name}", number) for name, number in COUNTERS.items()
        }

    def clear_counters(self) -> None:
        """Set the bus's counters to 0 (function 08, sub-function 10)."""
        self._diagnosis("clear counters", _CLEAR_COUNTERS)

    def listen_only(self) -> None:
        """Make the unit silent until it is restarted (function 08, sub-function 4); no reply."""
        self._tell(self.unit, rtu.DIAGNOSE, ">HH", _LISTEN_ONLY, 0)

    def restart(self) -> None:
        """End listen-only (function 08, sub-function 1); a silent unit does not reply."""
        self._tell(self.unit, rtu.DIAGNOSE, ">HH", _RESTART, 0)

    def _diagnosis(self, what: str, sub: int, word: int = 0) -> int:
        """Return the data word of a diagnostic answer (function 08)."""
        with self._needs("diagnosis"):
            data = self._ask(what, rtu.DIAGNOSE, ">HH", sub, word)
            return int.from_bytes(data[2:4])


def bits(data: bytes, count: int) -> list[bool]:
    """Return the bits behind a byte count."""
    return [bool(data[1 + index // 8] >> index % 8 & 1) for index in range(count)]
