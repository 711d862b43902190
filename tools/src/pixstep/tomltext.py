# SPDX-License-Identifier: MIT
"""TOML files that people write: what they hold, and in which line a key stands."""

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.errors import RefusedError, UserError
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import tomllib
else:
    tomllib = lazy("tomllib")

_LONG_NUMBER = re.compile(r"\d{1000}")
_MARK = "pixstep-looks-for-this-line"


def read(path: Path) -> tuple[str, dict[str, object]]:
    """Return a file's text, and what it says. Raises UserError naming file, line and column."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    return parse(data, path)


def parse(data: bytes, path: Path) -> tuple[str, dict[str, object]]:
    """Return the text of a file's bytes, and what it says. Raises RefusedError in the same way."""
    try:
        content = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig").read()
    except UnicodeDecodeError as error:
        raise RefusedError(f"{path}: not UTF-8 at byte {error.start}") from None
    try:
        return content, tomllib.loads(content)
    except tomllib.TOMLDecodeError as error:
        raise RefusedError(f"{path}{_place_and_reason(error)}") from None
    except RecursionError:
        raise RefusedError(f"{path}: values are nested too deeply") from None
    except ValueError:  # Python's own limit of digits
        lines = enumerate(content.splitlines(), 1)
        place = next((f":{number}" for number, line in lines if _LONG_NUMBER.search(line)), "")
        raise RefusedError(f"{path}{place}: a number has too many digits") from None


def line_of(text: str, keys: Sequence[str | int]) -> int | None:
    """Return the line, from 1, of a key or table of a valid file; None if it has no line.

    tomlkit writes a file back character by character. So a comment that is put behind the item
    shows in which line the item ends.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(text)
        item: Any = document  # tomlkit's types do not say which of its items have which methods
        for key in keys:
            item = item[key] if isinstance(key, int) else item.item(key)
        item.comment(_MARK)
        written = document.as_string()
    except (TOMLKitError, AttributeError, IndexError, KeyError, TypeError, ValueError):
        return None
    before, found, _behind = written.partition(_MARK)
    if not found:
        return None
    inside = item.as_string() if not hasattr(item, "is_super_table") else ""
    return before.count("\n") + 1 - inside.count("\n")


def _place_and_reason(error: "tomllib.TOMLDecodeError") -> str:
    """Return ":line:column: what", which the parser says the other way round."""
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", str(error))
    return f":{found[2]}:{found[3]}: {found[1]}" if found else f": {error}"
