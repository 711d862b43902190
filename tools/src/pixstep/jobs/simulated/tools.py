# SPDX-License-Identifier: MIT
"""What a verdict depends on besides the job: this code, the simulator, the boards' images.

Each is named with its version or the first digits of its SHA-256. Processes that do not have the
same give other verdicts, so they are refused.
"""

from __future__ import annotations

import hashlib
import socket
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from pixstep import natives
from pixstep.errors import UserError
from pixstep.version import __version__

Tools = Mapping[str, str]
Images = Mapping[str, Path]  # by kind of board, where it is not the built one
_DIGITS = 16
_SIMULATOR = "pixstep-sim"


class OtherToolsError(UserError):
    """A process has other tools than the one that asks it."""


def tools(kinds: tuple[str, ...], images: Images | None = None) -> dict[str, str]:
    """Return the tools of this process, by name, for boards of these kinds."""
    found = {"pixstep": f"{__version__} {_code()}", _SIMULATOR: _sum(natives.program(_SIMULATOR))}
    for kind in kinds:
        found[f"firmware of {kind}"] = _sum(image(kind, images or {}))
    return found


def image(kind: str, images: Images) -> Path:
    """Return the image of a kind of board."""
    return images.get(kind) or natives.image(kind)


def differences(mine: Tools, others: Tools) -> str:
    """Return in words which tools somebody else has; nothing if they are the same."""
    found = (
        f"{name} {others.get(name, '(none)')} instead of {wanted}"
        for name, wanted in mine.items()
        if others.get(name) != wanted
    )
    return ", ".join(found)


def require(mine: Tools, others: Tools, who: str) -> None:
    """Raise OtherToolsError if somebody else has other tools."""
    if told := differences(mine, others):
        raise OtherToolsError(f"{who} has {told}")


def host() -> str:
    """Return the name of this computer."""
    return socket.gethostname()


@cache
def _code() -> str:
    """Return the sum of this package's sources and of the tables that the build makes."""
    folder, content = Path(__file__).parents[2], hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        content.update(f"{path.relative_to(folder)}\n".encode() + path.read_bytes())
    content.update(natives.made("tables.json").read_bytes())
    return content.hexdigest()[:_DIGITS]


@cache
def _sum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:_DIGITS]
