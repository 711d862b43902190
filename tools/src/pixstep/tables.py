# SPDX-License-Identifier: MIT
"""The firmware's own tables, as the build generated them from its .def files.

Registers with the meanings of their values, faults, line errors, features, boards: plain data.
"""

import json
from functools import cache
from typing import Any

from pixstep import natives
from pixstep.errors import UserError


@cache
def table(name: str) -> Any:  # each has rows of its own kind
    """Return a table: "registers", "faults", "line_errors", "features" or "boards"."""
    return _load()[name]


@cache
def _load() -> dict[str, Any]:
    path = natives.made("tables.json")
    try:
        tables: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: not the tables that the build makes: {error}") from None
    return tables
