# SPDX-License-Identifier: MIT
"""A machine file as bytes: a job's copy, or today's. Keys that are not known are kept, not refused.

A copy may come from another version of pixstep, and a comparison has to show what it does not know.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pixstep import tomltext
from pixstep.errors import RefusedError
from pixstep.lines.units import Quantity
from pixstep.machine import files
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable, contradictions

Keys = tuple[str, ...]
NOTHING = "-"
_UNKNOWN = "extra_forbidden"


@dataclass(frozen=True)
class MachineCopy:
    """A machine, and what stands in its file.

    `data` are the file's bytes, `values` those of all keys as they are written; `unknown` are the
    keys that mean nothing here.
    """

    data: bytes
    tables: MachineFile
    values: dict[Keys, Any]
    unknown: tuple[Keys, ...]

    @classmethod
    def of(cls, data: bytes, path: Path) -> MachineCopy:
        """Return the machine of a file's bytes. Raises RefusedError naming the first wrong key."""
        text, content = tomltext.parse(data, path)
        values = dict(_leaves(content))
        unknown: list[Keys] = []
        while True:
            try:
                made = files.of_content(content, path)
                break
            except ValidationError as error:
                unknown += _without_unknown(text, content, error, path)
        for keys, reason in contradictions(made):
            raise _wrong(text, content, path, keys, reason)
        return cls(data, made, values, tuple(unknown))

    def value(self, keys: Keys) -> Any:
        """Return what a key means, however it is written: equal means have equal values."""
        table, name = keys[:2]
        if table == "motors":
            return _of_motor(self.tables, self.tables[name], keys[2:])
        if keys == ("clock", "divider"):
            return self.tables.clock.edges
        held: Any = self.tables
        for key in keys:
            held = held[key] if isinstance(held, dict) else getattr(held, key)
        return (held.value, held.length) if isinstance(held, Quantity) else held

    def text(self, keys: Keys) -> str:
        """Return a value as it is written, what holds without it, or that there is none."""
        if keys in self.values:
            return str(self.values[keys])
        held = self.value(keys)
        if isinstance(held, tuple):
            held = held[0]
        return NOTHING if held is None or held == "" else f"{held} (default)"

    def under(self, keys: Keys) -> str:
        """Return what stands at a key; of a table all that stands in it."""
        found = {one: value for one, value in self.values.items() if one[: len(keys)] == keys}
        if list(found) == [keys]:
            return str(found[keys])
        inside = (f"{'.'.join(one[len(keys) :])} = {value}" for one, value in found.items())
        return ", ".join(inside) or NOTHING


def _of_motor(machine: MachineFile, motor: MotorTable, keys: Keys) -> Any:
    if keys == ("board",):
        return machine.board_name(motor)
    if keys == ("backlash",):
        return motor.backlash_steps
    if keys[0] == "limits":
        limit = motor.limit(keys[1])
        return None if limit is None else (limit.value, limit.per_second)
    if keys[0] == "profiles":
        return getattr(motor.profiles, keys[1])
    return getattr(motor, keys[0])


def _wrong(
    text: str, content: dict[str, Any], path: Path, keys: Sequence[str | int], reason: str
) -> RefusedError:
    """Return the refusal of what stands at some keys."""
    held: Any = content
    for key in keys:
        held = held.get(key) if isinstance(held, dict) else None
    return RefusedError(files.told(text, path, [(keys, reason, held)])[0])


def _without_unknown(
    text: str, content: dict[str, Any], error: ValidationError, path: Path
) -> list[Keys]:
    """Take the keys that are not known out of a content; raise for any other mistake."""
    found = error.errors(include_url=False, include_context=False)
    wrong = next((one for one in found if one["type"] != _UNKNOWN), None)
    if wrong is not None:
        said = files.reason(wrong["type"], wrong["msg"])
        raise _wrong(text, content, path, wrong["loc"], said)
    keys = [tuple(map(str, one["loc"])) for one in found]
    for place in keys:
        table = content
        for key in place[:-1]:
            table = table[key]
        del table[place[-1]]
    return keys


def _leaves(table: dict[str, Any], place: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """Yield every key that is no table, with its value."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _leaves(value, (*place, key))
        else:
            yield (*place, key), value
