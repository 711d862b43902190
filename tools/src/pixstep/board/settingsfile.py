# SPDX-License-Identifier: MIT
"""Settings as a TOML file: each with its unit, range and meaning as a comment; read back checked.

map_version = 3

[settings]
# direction output to the next STEP edge, at least
# us, 1 to 1000, default 20
dir_setup_us = 20
"""

import re
import tomllib
from pathlib import Path

import tomlkit

from pixstep import atomic
from pixstep.board import registers as regs
from pixstep.board import values
from pixstep.board.device import Identity
from pixstep.errors import UserError

TABLE = "settings"
_VERSION = "map_version"
_KEYS = {_VERSION, "board", "firmware", TABLE}


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
    table = tomlkit.table()
    for item in regs.settings():
        table.add(tomlkit.nl())
        table.add(tomlkit.comment(item.meaning))
        table.add(tomlkit.comment(f"{_unit(item)}{_range(item)}, default {item.default}"))
        table[item.name] = settings[item.name]
    document[TABLE] = table
    return tomlkit.dumps(document)


def read(path: Path) -> dict[str, int]:
    """Read a file and check all of it.

    Raises UserError naming file, line, setting and value for what is no TOML, unknown, of another
    type or out of range, and for a file of another register map.
    """
    try:
        content = path.read_text(encoding="utf-8-sig")
        found = tomllib.loads(content)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}{_place_and_reason(error)}") from None
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not UTF-8 at byte {error.start}") from None
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    lines = content.splitlines()
    _check_head(path, lines, found)
    chosen: dict[str, int] = {}
    for name, value in found[TABLE].items():
        where = f"{path}:{_line_of(lines, name)}"
        if type(value) is not int:
            raise UserError(f"{where}: {name} = {value!r}: a whole number is wanted")
        try:
            values.check(name, value)
        except UserError as error:
            raise UserError(f"{where}: {error}") from None
        chosen[name] = value
    return chosen


def _check_head(path: Path, lines: list[str], found: dict) -> None:
    """Refuse what is not a file of settings for this register map."""
    for key in found:
        if key not in _KEYS:
            raise UserError(f"{path}:{_line_of(lines, key)}: unknown key {key!r}")
    if not isinstance(found.get(TABLE), dict) or not found[TABLE]:
        raise UserError(f"{path}: no table [{TABLE}] with settings in it")
    version = found.get(_VERSION, regs.MAP_VERSION)
    if version != regs.MAP_VERSION:
        raise UserError(
            f"{path}:{_line_of(lines, _VERSION)}: settings of register map {version}, this tool "
            f"knows map {regs.MAP_VERSION}"
        )


def _line_of(lines: list[str], name: str) -> int:
    """Return the number of the line that sets a key, or begins a table, of this name."""
    key = rf"\s*(\[\s*)?[\"']?{re.escape(name)}[\"']?\s*[=.\]]"
    for number, line in enumerate(lines, 1):
        if re.match(key, line):
            return number
    return 1


def _place_and_reason(error: tomllib.TOMLDecodeError) -> str:
    """Return ":line:column: what", which the parser says the other way round."""
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", str(error))
    return f":{found[2]}:{found[3]}: {found[1]}" if found else f": {error}"


def _unit(item: regs.Register) -> str:
    return "" if item.unit in ("1", "") else f"{item.unit}, "


def _range(item: regs.Register) -> str:
    return f"{item.minimum} to {item.maximum}"
