# SPDX-License-Identifier: MIT
"""Registers by name: what there is, read with units and words, written with their ranges checked.

Names are those of the register map; those of an axis are written axis0.position_steps, and without
the axis they mean all axes.
"""

import difflib
import fnmatch
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import clock_hz, stretches
from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.port import PARITIES
from pixstep.board.registers import Register
from pixstep.board.stretches import Place
from pixstep.errors import UserError
from pixstep.lines.units import parse_hz

PIXEL_HZ, BAUD, PARITY = "pixel_hz", "baud", "parity"
_PARITIES = {word: PARITIES[word[0]] for word in ("N", "NONE", "O", "ODD", "E", "EVEN")}
_WIDE = "*"
_MOST_BITS = 64  # of a number that is shown
_MOST_SHOWN = 40  # characters of a text
_BARE = ("1", "", "bits", "code", "state")  # units that say nothing behind a number
INPUT, AXIS, SETTING = "input", "axis", "setting"


@dataclass(frozen=True)
class Item:
    """One register of a board under its full name."""

    name: str
    kind: str  # INPUT, AXIS or SETTING
    register: Register
    address: int


@dataclass(frozen=True)
class Reading:
    """A register and its value."""

    item: Item
    value: int

    @property
    def words(self) -> str:
        """The value in words, empty if it has none."""
        return regs.words(self.item.register, self.value)

    def as_json(self) -> dict[str, object]:
        """Return plain data; limits only for a setting."""
        register = self.item.register
        row = {
            "name": self.item.name,
            "value": self.value,
            "unit": register.unit,
            "words": self.words,
            "address": self.item.address,
            "type": register.type,
            "meaning": register.meaning,
        }
        if self.item.kind == SETTING:
            row |= {
                "minimum": register.minimum,
                "maximum": register.maximum,
                "default": register.default,
            }
        return row


def catalogue(axes: int) -> list[Item]:
    """Return all registers of a board: settings, inputs, those of its axes."""
    table = regs.register_map()
    items = [Item(item.name, SETTING, item, item.address) for item in regs.settings()]
    items += [Item(item.name, INPUT, item, item.address) for item in table.inputs]
    for axis in range(axes):
        base = regs.AXIS_BASE + regs.AXIS_STRIDE * axis
        items += [
            Item(f"axis{axis}.{item.name}", AXIS, item, base + item.address)
            for item in table.axis_inputs
        ]
    return items


def select(patterns: Iterable[str], axes: int) -> list[Item]:
    """Return the registers that names and wild cards (* ? [..]) mean, each once; none means all.

    Raises UserError for a name that means nothing, with those that look like it.
    """
    items = catalogue(axes)
    wanted = tuple(patterns) or (_WIDE,)
    chosen: dict[str, Item] = {}
    for pattern in wanted:
        found = [item for item in items if _means(pattern, item)]
        if not found:
            raise UserError(f"no register {pattern!r}{_like(pattern, items)}")
        chosen |= {item.name: item for item in found}
    return list(chosen.values())


def read(board: Board, items: list[Item]) -> list[Reading]:
    """Read registers, those that adjoin in one request; in the order given."""
    found: dict[str, int] = {}
    for area, of_settings in ((board.read_holdings, True), (board.read_inputs, False)):
        wanted = [item for item in items if (item.kind == SETTING) == of_settings]
        found |= stretches.values(
            [Place(item.name, item.address, item.register) for item in wanted], area
        )
    return [Reading(item, found[item.name]) for item in items]


def assignments(texts: Iterable[str]) -> dict[str, int]:
    """Return the settings that NAME=VALUE texts ask for, checked against their ranges.

    pixel_hz takes 30, 29.97 or 30000/1001, baud a rate, parity a letter or word; all else whole
    numbers, decimal or 0x hexadecimal. Raises UserError naming the setting and its range.
    """
    wanted: dict[str, int] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name or not value:
            raise UserError(f"{text!r}: NAME=VALUE is wanted")
        for one, number in _assignment(name, value).items():
            if one in wanted:
                raise UserError(f"{one} is given twice")
            check(one, number)
            wanted[one] = number
    return wanted


def check(name: str, value: int) -> Register:
    """Return the setting of a name; raises UserError if there is none or the value is no good."""
    known = {item.name: item for item in regs.settings()}
    if name not in known:
        table = regs.register_map()
        if name in {item.name for item in (*table.inputs, *table.axis_inputs)}:
            raise UserError(f"{name} is what the board measures: it cannot be set")
        raise UserError(f"no setting {name!r}{_like(name, catalogue(0))}")
    register = known[name]
    if not (register.minimum or 0) <= value <= (register.maximum or 0):
        raise UserError(
            f"{name} = {number_text(value)}: {range_text(register)}, default {register.default}"
        )
    return register


def number_text(value: int) -> str:
    """Return a number for a message; of a very long one only how long it is."""
    bits = value.bit_length()
    return str(value) if bits <= _MOST_BITS else f"a number of {bits} bits"


def range_text(register: Register) -> str:
    """Return the range of a setting with its unit: "1 to 1000 us"."""
    return f"{register.minimum} to {register.maximum}{unit_text(register)}"


def unit_text(register: Register) -> str:
    """Return a unit behind a blank; nothing for a number without one."""
    return "" if register.unit in _BARE else f" {register.unit}"


def _assignment(name: str, value: str) -> dict[str, int]:
    """Return what one text sets."""
    if name == PIXEL_HZ:
        hz = parse_hz(value)
        return {"pixel_hz_num": hz.numerator, "pixel_hz_den": hz.denominator}
    if name == BAUD:
        rate = _whole(name, value)
        if rate % 100:
            raise UserError(f"baud = {number_text(rate)}: a multiple of 100 is wanted")
        return {"baud_100": rate // 100}
    if name == PARITY and value.upper() in _PARITIES:
        return {PARITY: _PARITIES[value.upper()]}
    return {name: _whole(name, value)}


def _whole(name: str, value: str) -> int:
    try:
        return int(value, 0)
    except ValueError:
        shown = value if len(value) <= _MOST_SHOWN else f"{value[:_MOST_SHOWN]}..."
        raise UserError(f"{name} = {shown}: a whole number is wanted") from None


def hz_of(values: dict[str, int]) -> Fraction:
    """Return the exact pixel frequency of settings; raises BoardError if they are none."""
    return clock_hz.set_hz(values["pixel_hz_num"], values["pixel_hz_den"])


def _means(pattern: str, item: Item) -> bool:
    """True if a name or wild card means a register, with or without its axis."""
    if pattern == PIXEL_HZ:
        return item.name.startswith(PIXEL_HZ)
    short = item.name.partition(".")[2]
    return fnmatch.fnmatchcase(item.name, pattern) or (
        item.kind == AXIS and fnmatch.fnmatchcase(short, pattern)
    )


def _like(name: str, items: list[Item]) -> str:
    """Return what a mistyped name may have meant, as the end of a message."""
    names = {item.name.rpartition(".")[2] for item in items} | {item.name for item in items}
    close = difflib.get_close_matches(name, sorted(names), 3, 0.6)
    return f"; do you mean {' or '.join(close)}?" if close else "; `pixstep board get` lists all"
