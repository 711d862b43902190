# SPDX-License-Identifier: MIT
"""Settings as a TOML file: each with its unit, range and meaning as a comment; read back checked.

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

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import atomic, tomltext
from pixstep.board import registers as regs
from pixstep.board import values
from pixstep.board.device import Identity
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import tomlkit
else:
    tomlkit = lazy("tomlkit")

TABLE = "settings"
_VERSION = "map_version"
_BOARD, _COUNT = "board", "count"
_KEYS = {_VERSION, _BOARD, "firmware", _COUNT, TABLE}
_VERSIONS = range(3, regs.MAP_VERSION + 1)  # older maps have settings of the same meaning, or fewer
_MOST_SHOWN = 40  # characters of a value in a message


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


def write(path: Path, who: Identity, settings: dict[str, int]) -> None:
    """Write a file, whole or not at all."""
    atomic.write_text(path, text(who, settings))


def text(who: Identity, settings: dict[str, int]) -> str:
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


def read(path: Path) -> SettingsFile:
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
            values.check(name, value)
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
    text = values.number_text(value) if type(value) is int else repr(value)
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."


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


def _unit(item: regs.Register) -> str:
    return "" if item.unit in ("1", "") else f"{item.unit}, "


def _range(item: regs.Register) -> str:
    return f"{item.minimum} to {item.maximum}"
