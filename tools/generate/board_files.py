# SPDX-License-Identifier: MIT
"""The boards as plain data: constants, `#define BOARD_NAME value`, and rows for axes and pins."""

import re
from pathlib import Path

from deffiles import TableError, read_rows

_CONSTANT = re.compile(r"^#define[ \t]+BOARD_(\w+)[ \t]+(\"[^\"\n]*\"|\w+)", re.MULTILINE)
_TEXTS = ("NAME", "LABEL", "PART", "MCU", "AVRDUDE_PART", "AVRDUDE_PROGRAMMER")
_NUMBERS = (
    "ID",
    "CPU_HZ",
    "FLASH_BYTES",
    "RAM_BYTES",
    "QUEUE_ENTRIES",
    "ALL_FEATURES",
    "MIN_INTERVAL_TICKS",
    "SMOOTH_MIN_INTERVAL_TICKS",
    "SEEK_MIN_INTERVAL_TICKS",
    "REVERSAL_MARGIN_TICKS",
    "AVRDUDE_BAUD",
)
# Shortest intervals while 1, 2, 3 axes move: a board has them where it has more axes than that.
_BY_AXES = ("MIN_INTERVAL", "SMOOTH_MIN_INTERVAL")
_PIN = ("signal", "axis", "port", "bit", "header")


def boards(folder: Path) -> list[dict]:
    """Return every board of a folder, in the order of their numbers."""
    return sorted((board(path) for path in folder.glob("*.def")), key=lambda item: item["id"])


def board(path: Path) -> dict:
    """Return one board; raises TableError for a missing constant or a wrong row."""
    found: dict = {name.lower(): _text(path, name) for name in _TEXTS}
    found |= {name.lower(): _number(path, name) for name in _NUMBERS}
    timers: dict[str, int] = {}
    pins = []
    for row in read_rows(path):
        if row.macro == "BOARD_AXIS" and len(row.arguments) == 2:
            timers[str(row.arguments[0])] = row.arguments[1]
        elif row.macro == "BOARD_PIN" and len(row.arguments) == len(_PIN):
            pins.append(dict(zip(_PIN, row.arguments, strict=True)))
        else:
            raise TableError(f"{row.where}: unknown row {row.macro}")
    axes = _number(path, "AXES")
    if len(timers) != axes:
        raise TableError(f"{path}: BOARD_AXES is {axes}, {len(timers)} rows BOARD_AXIS")
    for name in _BY_AXES:
        found[f"{name.lower()}s_ticks"] = [
            *(_number(path, f"{name}_{count}_TICKS") for count in range(1, axes)),
            _number(path, f"{name}_TICKS"),
        ]
    return found | {"timers": timers, "pins": pins}


def _text(path: Path, name: str) -> str:
    constants = dict(_CONSTANT.findall(path.read_text(encoding="utf-8")))
    if name not in constants:
        raise TableError(f"{path}: BOARD_{name} is missing")
    return constants[name].strip('"')


def _number(path: Path, name: str) -> int:
    text = _text(path, name)
    try:
        return int(text, 0)
    except ValueError:
        raise TableError(f"{path}: BOARD_{name} is not a number") from None
