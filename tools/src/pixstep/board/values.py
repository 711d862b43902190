# SPDX-License-Identifier: MIT
"""Registers by name: what there is, read with units and words, written with their ranges checked.

Names are those of the register map; those of an axis are written axis0.position_steps, and without
the axis they mean all axes.

A file of settings is TOML, each with its unit, range and meaning as a comment; read back checked.

map_version = 4
board = "mega"
count = 16

[settings]
# direction output to the next STEP edge, at least
# us, 1 to 1000, default 20
dir_setup_us = 20

`count` shows a file that was cut off; one written by hand may leave out all but the settings.
"""

from __future__ import annotations

import difflib
import fnmatch
import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import atomic, tomltext
from pixstep.board import registers
from pixstep.board import registers as regs
from pixstep.board.device import Device, Identity
from pixstep.board.port import PARITIES
from pixstep.board.registers import PlacedRegister, RegisterEntry
from pixstep.board.state import set_hz
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import lazy
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
    register: RegisterEntry
    address: int


@dataclass(frozen=True)
class RegisterReading:
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


def read(board: Device, items: list[Item]) -> list[RegisterReading]:
    """Read registers, those that adjoin in one request; in the order given."""
    found: dict[str, int] = {}
    for area, of_settings in ((board.read_holdings, True), (board.read_inputs, False)):
        wanted = [item for item in items if (item.kind == SETTING) == of_settings]
        found |= registers.read_by_name(
            [PlacedRegister(item.name, item.address, item.register) for item in wanted], area
        )
    return [RegisterReading(item, found[item.name]) for item in items]


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


def check(name: str, value: int) -> RegisterEntry:
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


def range_text(register: RegisterEntry) -> str:
    """Return the range of a setting with its unit: "1 to 1000 us"."""
    return f"{register.minimum} to {register.maximum}{unit_text(register)}"


def unit_text(register: RegisterEntry) -> str:
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
    return set_hz(values["pixel_hz_num"], values["pixel_hz_den"])


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


if TYPE_CHECKING:
    import tomlkit
else:
    tomlkit = lazy("tomlkit")

TABLE = "settings"
_VERSION = "map_version"
_BOARD, _COUNT = "board", "count"
_KEYS = {_VERSION, _BOARD, "firmware", _COUNT, TABLE}
_VERSIONS = range(3, regs.MAP_VERSION + 1)  # older maps have settings of the same meaning, or fewer
_MOST_OF_VALUE = 40  # characters of a value in a message


@dataclass(frozen=True)
class SettingsFile:
    """What a file asks for: settings by name, for which board (empty: any)."""

    path: Path
    settings: dict[str, int]
    board: str = ""

    def refuse_other(self, who: Identity) -> None:
        """Raise RefusedError for a board that the file is not of."""
        if self.board and self.board != who.board:
            raise RefusedError(
                f"{self.path}: board = {self.board!r}: board {who.unit} is a {who.board} "
                f"(--skip board imports it all the same)"
            )


def write_file(path: Path, who: Identity, settings: dict[str, int]) -> None:
    """Write a file, whole or not at all."""
    atomic.write_text(path, file_text(who, settings))


def file_text(who: Identity, settings: dict[str, int]) -> str:
    """Return the content of a file."""
    document = tomlkit.document()
    document.add(tomlkit.comment("Settings of a pixstep board: `pixstep board settings import`."))
    document[_VERSION] = who.map_version
    document["board"] = who.board
    document["firmware"] = who.firmware
    document[_COUNT] = len(settings)
    document[_COUNT].comment("settings below; a file with fewer was cut off")
    table = tomlkit.table()
    for item in regs.settings():
        table.add(tomlkit.nl())
        table.add(tomlkit.comment(item.meaning))
        table.add(tomlkit.comment(f"{_unit(item)}{_range(item)}, default {item.default}"))
        table[item.name] = settings[item.name]
    document[TABLE] = table
    return tomlkit.dumps(document)


def read_file(path: Path) -> SettingsFile:
    """Read a file and check all of it.

    Raises UserError naming file, line, setting and value for what is no TOML, unknown, of another
    type or out of range, for a file of another register map, and for one that was cut off.
    """
    content, found = tomltext.read(path)
    lines = content.splitlines()
    table = _checked_table(path, lines, found)
    chosen: dict[str, int] = {}
    for name, value in table.items():
        where = f"{path}:{_line_of(lines, name)}"
        if type(value) is not int:
            raise RefusedError(f"{where}: {name} = {_shown(value)}: a whole number is wanted")
        try:
            check(name, value)
        except UserError as error:
            raise RefusedError(f"{where}: {error}") from None
        chosen[name] = value
    if _COUNT in found:
        _refuse_cut_off(path, content, found[_COUNT], len(table))
    return SettingsFile(path, chosen, str(found.get(_BOARD, "")))


def _refuse_cut_off(path: Path, content: str, announced: object, has: int) -> None:
    """Refuse a file that says how many settings it has, and ends before them."""
    if announced != has or not content.endswith("\n"):
        raise RefusedError(
            f"{path}: cut off: {has} of {_shown(announced)} settings, or the end of the last "
            f"line is missing (a file that is to hold some only has no line {_COUNT!r})"
        )


def _shown(value: object) -> str:
    """Return a value for a message, shortened."""
    file_text = number_text(value) if type(value) is int else repr(value)
    return file_text if len(file_text) <= _MOST_OF_VALUE else f"{file_text[:_MOST_OF_VALUE]}..."


def _checked_table(path: Path, lines: list[str], found: dict[str, object]) -> dict[str, object]:
    """Return the table of settings; refuse what is not a file of them for this register map."""
    for key in found:
        if key not in _KEYS:
            raise RefusedError(f"{path}:{_line_of(lines, key)}: unknown key {key!r}")
    if _BOARD in found and found[_BOARD] not in regs.BOARD_IDS.values():
        *others, last = (repr(name) for name in regs.BOARD_IDS.values())
        known = f"{', '.join(others)} or {last}" if others else last
        raise RefusedError(
            f"{path}:{_line_of(lines, _BOARD)}: board = {_shown(found[_BOARD])}: {known} is wanted"
        )
    table = found.get(TABLE)
    if not isinstance(table, dict) or not table:
        raise RefusedError(f"{path}: no table [{TABLE}] with settings in it")
    version = found.get(_VERSION, regs.MAP_VERSION)
    if type(version) is not int or version not in _VERSIONS:
        raise RefusedError(
            f"{path}:{_line_of(lines, _VERSION)}: settings of register map {_shown(version)}, "
            f"this tool knows map {regs.MAP_VERSION}"
        )
    return table


def _line_of(lines: list[str], name: str) -> int:
    """Return the number of the line that sets a key, or begins a table, of this name."""
    key = rf"\s*(\[\s*)?[\"']?{re.escape(name)}[\"']?\s*[=.\]]"
    for number, line in enumerate(lines, 1):
        if re.match(key, line):
            return number
    return 1


def _unit(item: regs.RegisterEntry) -> str:
    return "" if item.unit in ("1", "") else f"{item.unit}, "


def _range(item: regs.RegisterEntry) -> str:
    return f"{item.minimum} to {item.maximum}"
