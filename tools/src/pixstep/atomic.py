# SPDX-License-Identifier: MIT
"""Output files appear whole or not at all: written beside their place, then renamed."""

import contextlib
import json
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path


@contextlib.contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yield a temporary path beside `target`; rename it into place if the block succeeds.

    The folder is made if it is missing. On an exception the temporary file is removed and the
    old `target`, if any, stays as it was.
    """
    target = Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(
        prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent
    )
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(target: Path, data: bytes) -> None:
    """Write `data` to `target` atomically."""
    with replacing(target) as temporary:
        temporary.write_bytes(data)


def write_text(target: Path, text: str) -> None:
    """Write UTF-8 `text` to `target` atomically, line ends as given."""
    write_bytes(target, text.encode("utf-8"))


def write_json(target: Path, value: object) -> None:
    """Write `value` as indented JSON to `target` atomically."""
    write_text(target, json.dumps(value, indent=2) + "\n")


def write_with(target: Path, writer: Callable[[Path], object]) -> None:
    """Let `writer(path)` make the file at a temporary path, then rename it to `target`."""
    with replacing(target) as temporary:
        writer(temporary)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
