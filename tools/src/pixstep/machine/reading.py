# SPDX-License-Identifier: MIT
"""Read a machine file; every mistake has the line, the key and the value."""

import difflib
import tomllib
from collections.abc import Sequence
from pathlib import Path

from pydantic import BaseModel, ValidationError

from pixstep import tomltext
from pixstep.errors import RefusedError, one_line
from pixstep.machine import model
from pixstep.machine.model import Tables, contradictions

_MOST_SHOWN = 40  # characters of a value in a message
_UNKNOWN = "unknown key"
_REASONS = {"missing": "is missing", "extra_forbidden": _UNKNOWN, "too_short": "is empty"}


class Machine(Tables):
    """A machine that a file describes: Machine.load("machine.toml")["M39"]."""

    @classmethod
    def load(cls, path: str | Path) -> "Machine":
        """Read a file. Raises UserError naming file, line, key and value of the first mistake."""
        machine, found = _read(Path(path))
        if machine is None or found:
            raise RefusedError(found[0])
        return machine


def parse(text: str) -> Machine:
    """Return the machine of a text that is valid."""
    return Machine.model_validate(_with_names(tomllib.loads(text)))


def problems(path: Path) -> list[str]:
    """Return every mistake of a file, a line of text each, in the order of the file.

    Raises UserError for a file that is no TOML at all.
    """
    return _read(path)[1]


def _read(path: Path) -> tuple[Machine | None, list[str]]:
    """Return the machine, None if a value is wrong, and the mistakes."""
    text, content = tomltext.read(path)
    found: list[tuple[Sequence[str | int], str, object]]
    machine = None
    try:
        machine = Machine.model_validate(_with_names(content))
        machine._path = path
        found = [(keys, reason, _value(content, keys)) for keys, reason in contradictions(machine)]
    except ValidationError as error:
        found = [
            (item["loc"], _reason(item["type"], item["msg"]), _value(content, item["loc"]))
            for item in error.errors(include_url=False, include_context=False)
        ]
    placed = sorted(_placed(text, *item) for item in found)
    return machine, [f"{path}:{line}: {message}" for line, message in placed]


def _with_names(content: dict[str, object]) -> dict[str, object]:
    """Return the content with the name of each motor inside of its table, where it has none."""
    motors = content.get("motors")
    if not isinstance(motors, dict):
        return content
    named = {
        name: {"name": name} | table if isinstance(table, dict) else table
        for name, table in motors.items()
    }
    return content | {"motors": named}


def _reason(kind: str, message: str) -> str:
    """Return in our words what pydantic says."""
    return _REASONS.get(kind) or message.removeprefix("Value error, ").replace(
        "Input should be", "expected"
    )


def _value(content: object, keys: Sequence[str | int]) -> object:
    """Return what the file has at some keys; None if it has nothing there."""
    for key in keys:
        if not isinstance(content, dict) or key not in content:
            return None
        content = content[key]
    return content


def _placed(text: str, keys: Sequence[str | int], reason: str, value: object) -> tuple[int, str]:
    """Return the line of some keys, or of the nearest table around them, and the message."""
    depth = len(keys)
    line = None
    while depth and line is None:
        line = tomltext.line_of(text, keys[:depth])
        depth -= 1
    if reason == _UNKNOWN and (close := _alike(keys)):
        reason = f"{_UNKNOWN}: is {close} meant?"
    name = ".".join(one_line(str(key), _MOST_SHOWN) for key in keys)
    shown = "" if value is None or isinstance(value, dict) else f" = {_shown(value)}"
    return line or 1, f"{name}{shown}: {one_line(reason.removeprefix(f'{value!r}: '))}"


def _alike(keys: Sequence[str | int]) -> str:
    """Return the key that a mistyped one may have meant; "" if none looks like it."""
    tables = [one for one in vars(model).values() if isinstance(one, type(BaseModel))]
    known = {name for table in tables for name in table.model_fields}
    return next(iter(difflib.get_close_matches(str(keys[-1]), sorted(known), 1)), "")


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."
