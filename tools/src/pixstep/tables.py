# SPDX-License-Identifier: MIT
"""The firmware's own tables, as the build generated them from its .def files.

Registers with the meanings of their values, faults, line errors, features, boards: plain data.
"""

import json
from functools import cache
from typing import NotRequired, TypedDict

from pixstep import natives
from pixstep.errors import UserError


class RegisterRow(TypedDict):
    """A register; limits only of a holding register, JSON's keys of `values` are texts."""

    address: int
    name: str
    type: str
    unit: str
    meaning: str
    minimum: NotRequired[int]
    maximum: NotRequired[int]
    default: NotRequired[int]
    values: NotRequired[dict[str, str]]


class RegisterRows(TypedDict):
    """The register map."""

    inputs: list[RegisterRow]
    axis_inputs: list[RegisterRow]
    holdings: list[RegisterRow]


class CodeRow(TypedDict):
    """A line error or warning."""

    code: int
    name: str
    text: str
    cure: str


class FaultRow(CodeRow):
    """A fault."""

    argument: str
    position: str
    cause: str


class FeatureRow(TypedDict):
    """A feature of a build."""

    bit: int
    name: str
    meaning: str


class PinRow(TypedDict):
    """A signal of a board."""

    signal: str
    axis: int
    port: str
    bit: int
    header: str


class BoardRow(TypedDict):
    """A board file; the keys of `timers` are axes."""

    name: str
    label: str
    part: str
    mcu: str
    avrdude_part: str
    avrdude_programmer: str
    avrdude_baud: int
    id: int
    cpu_hz: int
    flash_bytes: int
    ram_bytes: int
    queue_entries: int
    all_features: int
    min_interval_ticks: int
    smooth_min_interval_ticks: int
    seek_min_interval_ticks: int
    reversal_margin_ticks: int
    min_intervals_ticks: list[int]
    smooth_min_intervals_ticks: list[int]
    timers: dict[str, int]
    pins: list[PinRow]


class Tables(TypedDict):
    """All tables by name."""

    registers: RegisterRows
    faults: list[FaultRow]
    line_errors: list[CodeRow]
    features: list[FeatureRow]
    boards: list[BoardRow]


@cache
def load() -> Tables:
    """Read the tables that the build has made."""
    path = natives.made("tables.json")
    try:
        found: Tables = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: not the tables that the build makes: {error}") from None
    return found
