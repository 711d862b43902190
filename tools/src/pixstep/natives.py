# SPDX-License-Identifier: MIT
"""Where the clone, its native programs and its board images are."""

import os
import subprocess
from pathlib import Path

from pixstep.errors import UserError


def root() -> Path:
    """Return the root of the clone: PIXSTEP_ROOT, else the folder above this package's `tools`."""
    given = os.environ.get("PIXSTEP_ROOT")
    return Path(given).resolve() if given else Path(__file__).resolve().parents[3]


def source(relative: str) -> Path:
    """Return a source file of the clone; raises UserError if it is not there."""
    path = root() / relative
    if not path.is_file():
        raise UserError(f"{path}: missing; pixstep runs from a clone (or set PIXSTEP_ROOT)")
    return path


def program(name: str) -> Path:
    """Return a native program of the host build, e.g. pixstep-plan or pixstep-sim."""
    return _built(root() / "build" / "host" / "bin" / name)


def image(board: str) -> Path:
    """Return the board's firmware image (ELF)."""
    return _built(root() / "build" / board / "firmware" / f"pixstep-{board}.elf")


def have(name: str) -> bool:
    """True if the native program `name` has been built."""
    return (root() / "build" / "host" / "bin" / name).is_file()


def have_image(board: str) -> bool:
    """True if the board's image has been built."""
    return (root() / "build" / board / "firmware" / f"pixstep-{board}.elf").is_file()


def run(arguments: list[str], *, stdin: str = "") -> subprocess.CompletedProcess:
    """Run a program to its end and return its output as text; the status is the caller's."""
    try:
        return subprocess.run(
            [str(argument) for argument in arguments],
            input=stdin,
            capture_output=True,
            text=True,
            check=False,
        )
    except OSError as error:
        raise UserError(f"{arguments[0]}: {error.strerror or error}") from None


def _built(path: Path) -> Path:
    if not path.is_file():
        raise UserError(
            f"{path} is not built: run tools/setup, then `cmake --workflow --preset default`"
        )
    return path
