# SPDX-License-Identifier: MIT
"""Values that are said of a motor: NAME=VALUE, again for more motors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

from pixstep import arguments
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import DISTANCE, SPEED, Quantity
from pixstep.machine.model import MachineTables
from pixstep.operations.kinds import Kind
from pixstep.operations.request import option

Value = TypeVar("Value")
Pair = tuple[str, Any]


class OfMotor(Kind):
    """A motor and a value of it."""

    python = "str | tuple[str, object]"

    def __init__(self, name: str, reader: Callable[[str], Any]):
        self.name, self._reader = name, reader

    def parse(self, text: str) -> Pair:
        """Return the motor and the value of a text."""
        divide = text.partition if self.name.endswith("FILE") else text.rpartition
        motor, _, value = divide("=")  # a motor's name may have the sign, or a file's
        if not motor or not value:
            raise UserError(f"{text!r}: expected {self.name}")
        return motor, self._reader(value)

    def judge(self, value: Any) -> Pair:
        """Return a pair that Python has: ("M39", 1000), ("M39", "12mm/s")."""
        if not isinstance(value, tuple) or len(value) != 2 or not isinstance(value[0], str):
            raise UserError(f"{arguments.shown(value)}: expected a text, {self.name}")
        motor, held = value
        plain = isinstance(held, (str, os.PathLike, int, float)) and not isinstance(held, bool)
        return motor, self._reader(str(held)) if plain else held


def _speed(text: str) -> Quantity:
    return units.parse(text, SPEED)


def _distance(text: str) -> Quantity:
    return units.parse(text, DISTANCE, signed=True)


SCAN = OfMotor("NAME=SPEED", _speed)
AXIS_OF = OfMotor("NAME=AXIS", str)
DISTANCE_OF = OfMotor("NAME=DISTANCE", _distance)
FILE_OF = OfMotor("NAME=FILE", Path)


def of_motors(kind: Kind, about: str, *names: str, **more: Any) -> Any:
    """Return the field of a value that several motors may have."""
    return option(kind, about, *names, many=True, shown=kind.name, **more)


def pairs(field: str, values: Iterable[tuple[str, Value]]) -> dict[str, Value]:
    """Return the values by motor. Raises UserError for a motor that is named twice."""
    found: dict[str, Value] = {}
    for name, value in values:
        if name in found:
            raise UserError(f"{field}: motor {name} is named twice")
        found[name] = value
    return found


def in_steps(machine: MachineTables, distances: dict[str, Quantity]) -> dict[str, int]:
    """Return distances as whole steps of their motors. Raises UserError naming the motor."""
    found = {}
    for name, distance in distances.items():
        try:
            found[name] = distance.in_steps(machine[name].steps_per_unit).whole_steps()
        except UserError as error:
            raise UserError(f"motor {name}: {error}") from None
    return found
