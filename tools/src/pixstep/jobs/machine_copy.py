# SPDX-License-Identifier: MIT
"""A machine file as bytes: a job's copy, or today's. Keys that are not known are kept, not refused.

A copy may come from another version of pixstep, and a comparison has to show what it does not know.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pixstep.errors import RefusedError, one_line
from pixstep.machine import files
from pixstep.machine.files import MachineFile
from pixstep.machine.model import contradictions

Keys = tuple[str, ...]
_UNKNOWN = "extra_forbidden"


@dataclass(frozen=True)
class MachineCopy:
    """A machine, and what stands in its file.

    `values` are those of all keys as they are written; `unknown` are the keys that mean nothing
    here.
    """

    tables: MachineFile
    values: dict[Keys, Any]
    unknown: tuple[Keys, ...]

    @classmethod
    def of(cls, data: bytes, path: Path) -> MachineCopy:
        """Return the machine of a file's bytes. Raises RefusedError naming the first wrong key."""
        try:
            content = tomllib.loads(data.decode("utf-8-sig"))
        except ValueError as error:
            raise RefusedError(f"{path}: {one_line(str(error))}") from None
        values = dict(_leaves(content))
        unknown: list[Keys] = []
        while True:
            try:
                made = files.of_content(content, path)
                break
            except ValidationError as error:
                unknown += _without_unknown(content, error, path)
        for keys, reason in contradictions(made):
            raise RefusedError(f"{path}: {'.'.join(keys)}: {one_line(reason)}")
        return cls(made, values, tuple(unknown))


def _without_unknown(content: dict[str, Any], error: ValidationError, path: Path) -> list[Keys]:
    """Take the keys that are not known out of a content; raise for any other mistake."""
    found = error.errors(include_url=False, include_context=False)
    wrong = next((one for one in found if one["type"] != _UNKNOWN), None)
    if wrong is not None:
        raise RefusedError(f"{path}: {'.'.join(map(str, wrong['loc']))}: {one_line(wrong['msg'])}")
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
