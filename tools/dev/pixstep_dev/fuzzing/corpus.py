# SPDX-License-Identifier: MIT
"""A corpus as one text file: an input is a paragraph of bytes in hexadecimal, # begins a comment.

libFuzzer wants a folder with a file for each input; the tree keeps one file that can be read,
compared and reviewed.
"""

import hashlib
import textwrap
from pathlib import Path

from pixstep import atomic, natives
from pixstep.errors import UserError

_WIDTH = 96


def path(target: str) -> Path:
    """Return where the corpus of a target is kept."""
    return natives.root() / "fuzz" / "corpus" / f"{target}.hex"


def read(source: Path) -> list[bytes]:
    """Return the inputs of a corpus file; raises UserError that names a malformed line."""
    inputs: list[bytes] = []
    current = b""
    try:
        lines = source.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{source}: {error}") from None
    for number, line in enumerate([*lines, ""], 1):
        if line.startswith("#"):
            continue
        try:
            current += bytes.fromhex(line)
        except ValueError:
            raise UserError(f"{source}:{number}: {line!r} is not a row of bytes") from None
        if not line and current:
            inputs.append(current)
            current = b""
    return inputs


def write(target: Path, inputs: list[bytes]) -> None:
    """Write a corpus file, shortest input first."""
    ordered = sorted(set(inputs), key=lambda item: (len(item), item))
    paragraphs = ["\n".join(textwrap.wrap(item.hex(), _WIDTH)) for item in ordered]
    head = f"# {len(ordered)} inputs; fuzz/script.h says what they mean.\n\n"
    atomic.write_text(target, head + "\n\n".join(paragraphs) + "\n")


def unpack(inputs: list[bytes], folder: Path) -> None:
    """Write each input to a file of its own, named by its hash."""
    folder.mkdir(parents=True, exist_ok=True)
    for item in inputs:
        (folder / hashlib.sha1(item).hexdigest()).write_bytes(item)


def pack(folder: Path) -> list[bytes]:
    """Return what is in the files of a folder."""
    return [entry.read_bytes() for entry in sorted(folder.iterdir()) if entry.stat().st_size]
