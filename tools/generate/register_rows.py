# SPDX-License-Identifier: MIT
"""The rows of the register map, of the codes and of the features, checked, as plain data."""

import re
from pathlib import Path

from deffiles import Row, TableError, read_rows

GROUPS = {
    "INPUT": "inputs",
    "INPUT_AXIS": "axis_inputs",
    "HOLDING": "holdings",
    "COMMAND": "holdings",
}
LIMITED = ("HOLDING", "COMMAND")  # rows that have a range and a default value
TYPES = {"u16": 1, "i16": 1, "u32": 2, "i32": 2}  # registers that a value takes
FAULT = ("code", "name", "text", "argument", "position", "cause", "cure")
LINE_ERROR = ("code", "name", "text", "cure")
FEATURE = ("bit", "name", "meaning")

_COUNTED = ("bits", "state", "code")  # units of which each value or bit has a meaning
_CHOICE = re.compile(r"(?:^|[:,] )(\d+)(?: to (\d+))? ([^,;]+)")
_PER_AXIS = "four bits an axis"
_AXIS_BITS = 4

Codes = list[dict[str, int | str]]


def registers(path: Path) -> dict[str, list[dict]]:
    """Return the register map; raises TableError for an overlap or a row that is not right."""
    groups: dict[str, list[dict]] = {name: [] for name in GROUPS.values()}
    taken: dict[tuple[str, int], str] = {}
    for row in read_rows(path):
        if row.macro not in GROUPS:
            raise TableError(f"{row.where}: unknown row {row.macro}")
        found = _register(row)
        group = GROUPS[row.macro]
        for address in range(found["address"], found["address"] + TYPES[found["type"]]):
            other = taken.setdefault((group, address), found["name"])
            if other != found["name"]:
                raise TableError(f"{path}: {found['name']} overlaps {other} at {address}")
        groups[group].append(found)
    return groups


def codes(path: Path, macro: str, names: tuple[str, ...]) -> Codes:
    """Return a table of one macro's rows, whose first argument is a number of its own."""
    found: Codes = []
    for row in read_rows(path):
        if row.macro != macro or len(row.arguments) != len(names):
            raise TableError(f"{row.where}: expected {macro}({', '.join(names)})")
        code = dict(zip(names, row.arguments, strict=True))
        if any(other[names[0]] == code[names[0]] for other in found):
            raise TableError(f"{row.where}: {names[0]} {code[names[0]]} is used twice")
        found.append(code)
    return found


def add_meanings(groups: dict[str, list[dict]], named: dict[str, Codes], axes: int) -> None:
    """Give each register that has them the meanings of its values, or of its bits.

    `named` are the tables of registers that hold a code or a bit for each row of the table;
    `axes` is the most that a board has.
    """
    for register in (item for group in groups.values() for item in group):
        if register["unit"] in _COUNTED:
            if register["name"] in named:
                known = {next(iter(row.values())): row["name"] for row in named[register["name"]]}
            else:
                known = _choices(register["meaning"], axes)
            register["values"] = {str(value): text for value, text in known.items()}


def _register(row: Row) -> dict:
    """Return a register of a row of five arguments, or of eight if it has a range."""
    expected = 8 if row.macro in LIMITED else 5
    if len(row.arguments) != expected or not isinstance(row.arguments[0], int):
        raise TableError(f"{row.where}: {row.macro} takes {expected} arguments, an address first")
    address, name, kind, unit = row.arguments[:4]
    if kind not in TYPES:
        raise TableError(f"{row.where}: unknown type {kind}")
    found = {
        "address": address,
        "name": name,
        "type": kind,
        "unit": unit,
        "meaning": row.arguments[-1],
    }
    if row.macro in LIMITED:
        found |= dict(zip(("minimum", "maximum", "default"), row.arguments[4:7], strict=True))
    return found


def _choices(meaning: str, axes: int) -> dict[int, str]:
    """Return the values or bits that a meaning lists: "0 empty, 1 loading, 8 to 11 axis n ..."."""
    found: dict[int, str] = {}
    for first, last, text in _CHOICE.findall(meaning):
        for number in range(int(first), int(last or first) + 1):
            found[number] = re.sub(r"\b(axis) n\b", rf"\1 {number - int(first)}", text).strip()
    if _PER_AXIS not in meaning:
        return found
    return {
        _AXIS_BITS * axis + bit: f"axis {axis} {text}"
        for axis in range(axes)
        for bit, text in found.items()
    }
