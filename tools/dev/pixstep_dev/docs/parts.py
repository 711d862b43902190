# SPDX-License-Identifier: MIT
"""Tables of docs/WIRING.md about other people's parts: drivers and shields (data/wiring.toml)."""

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import PlainError
from pixstep_dev.markdown import table

_DATA = Path(__file__).resolve().parents[1] / "data" / "wiring.toml"
_STEPS = (1, 2, 4, 8, 16, 32, 64)
_LEVELS = {"0": "L", "1": "H"}


@cache
def _data() -> dict[str, Any]:
    return tomllib.loads(_DATA.read_text(encoding="utf-8"))


def low_us() -> float:
    """Return how long STEP is low between two steps at least: CONFIG_PULSE_LOW_TICKS."""
    text = natives.source("firmware/config.h").read_text(encoding="utf-8")
    found = re.search(r"define CONFIG_PULSE_LOW_TICKS .*CONFIG_TIMER_HZ / (\d+)uL - 1u", text)
    if found is None:
        raise PlainError("firmware/config.h: CONFIG_PULSE_LOW_TICKS is not what it was")
    return 1e6 / int(found[1])


def high_us(name: str) -> float:
    """Return how long STEP is high at a board's highest rate."""
    board = boards.load(name)
    shortest = min(board.min_interval_ticks, *board.min_intervals_ticks)
    return shortest * 1e6 / board.tick_hz - low_us()


def drivers() -> str:
    """Return two tables: pulse widths beside what pixstep makes, and microstep pins."""
    low = low_us()
    high = min(high_us(name) for name in boards.BOARD_NAMES)
    rows = [
        (
            one["name"],
            f"{one['high_us']:g}",
            f"{one['low_us']:g}",
            f"{one['setup_us']:g}",
            _verdict(one, high, low),
        )
        for one in _data()["driver"]
    ]
    rows.append(
        ("**pixstep makes at least**", f"{high:.2f}", f"{low:.2f}", "`dir_setup_us`: 20", "")
    )
    widths = table(
        ("driver", "STEP high, µs", "STEP low, µs", "DIR before STEP, µs", "with pixstep"), rows
    )
    return f"{widths}\n\n{_microsteps()}"


def _verdict(driver: dict[str, Any], high: float, low: float) -> str:
    """Return whether a driver sees every pulse, and up to which rate."""
    said = []
    if driver["low_us"] > low:
        said.append(f"STEP is low {driver['low_us'] - low:g} µs too short: see below")
    if driver["high_us"] > high or driver.get("most_hz", 1e9) < 1e6 / (high + low):
        most = min(driver.get("most_hz", 1e9), 1e6 / (driver["high_us"] + low))
        said.append(f"up to {most:,.0f} steps/s")
    return "; ".join(said) or "fits at every rate"


def _microsteps() -> str:
    """Return a row for each driver whose microsteps are set by pins."""
    head = ("driver", "pins", *[f"1/{step}" for step in _STEPS])
    rows = []
    for one in _data()["driver"]:
        if one["pins"]:
            cells = ["".join(_LEVELS[bit] for bit in one["steps"].get(str(step), ""))
                     for step in _STEPS]  # fmt: skip
            rows.append((one["name"], one["pins"], *[cell or "-" for cell in cells]))
    return table(head, rows)


def shields() -> str:
    """Return a table for each shield: every pin of pixstep, and what the shield has there."""
    parts = []
    for shield in _data()["shield"]:
        board = boards.load(shield["board"])
        mine = {pin.header: pin.signal for pin in board.pins}
        steps = {header for header, signal in mine.items() if signal == "STEP"}
        reached = [name for name, pin in shield["sockets"].items() if pin in steps]
        rows = [
            (
                pin.header,
                f"{pin.signal} {pin.axis}" if _many(board, pin) else pin.signal,
                shield["pins"][pin.header],
            )
            for pin in board.pins
        ]
        sockets = ", ".join(f"{name} {pin}" for name, pin in shield["sockets"].items())
        parts += [
            f"**{shield['name']}, made for the {board.label}.** STEP of its sockets: {sockets}. "
            f"Sockets that a STEP pin of pixstep reaches: {', '.join(reached) or 'none'}.\n",
            table(("header pin", "pixstep", "the shield"), rows),
            "",
        ]
    return "\n".join(parts)


def _many(board: boards.BoardKind, pin: boards.Pin) -> bool:
    """True if other axes have the same signal."""
    return sum(other.signal == pin.signal for other in board.pins) > 1
