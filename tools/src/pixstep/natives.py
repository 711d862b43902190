# SPDX-License-Identifier: MIT
"""Where the package finds what the build makes for it, in a clone and installed alike.

                         in a clone                    installed from a wheel
tables, C core           build/host/python             pixstep/_built
images of the boards     build/BOARD/firmware          pixstep/_built
the demo's profile       tools/data                    pixstep/_built
pixstep-sim              PIXSTEP_SIM, build/host/bin   PIXSTEP_SIM, package pixstep_sim, PATH

The tables are the firmware's own, generated from its .def files: registers with the meanings of
their values, faults, line errors, features, boards.
"""

import importlib
import json
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

from pixstep.errors import UserError

_SIMULATOR = "pixstep-sim"
_INSTALLED = Path(__file__).resolve().parent / "_built"


def root() -> Path:
    """Return the root of the clone: PIXSTEP_ROOT, else the folder above this package's `tools`."""
    given = os.environ.get("PIXSTEP_ROOT")
    return Path(given).resolve() if given else Path(__file__).resolve().parents[3]


def installed() -> bool:
    """True if the package came by a wheel, which has all that the build makes inside."""
    return _INSTALLED.is_dir() and "PIXSTEP_ROOT" not in os.environ


def source(relative: str) -> Path:
    """Return a source file of the clone; raises UserError if it is not there."""
    path = root() / relative
    if installed() or not path.is_file():
        raise UserError(f"{relative}: this needs a clone of pixstep (or set PIXSTEP_ROOT)")
    return path


def example(name: str) -> Path:
    """Return a file of tools/data that a wheel has too."""
    return _built(_INSTALLED / name) if installed() else source(f"tools/data/{name}")


def made(name: str) -> Path:
    """Return a file that the build makes for the package: tables, the C core."""
    return _built(_made(name))


def have_made(name: str) -> bool:
    """True if the build has made this file for the package."""
    return _made(name).is_file()


def program(name: str) -> Path:
    """Return a native program of the host build, e.g. pixstep-native-board, or the simulator."""
    found = _program(name)
    if found is None:
        raise UserError(
            f"{name} is not installed: simulations need pixstep's other wheel, pip install "
            f"{name} (or let PIXSTEP_SIM name the program)"
        )
    return _built(found)


def image(board: str) -> Path:
    """Return the board's firmware image for the simulator (ELF)."""
    return _built(_place(board, "elf"))


def hex_image(board: str) -> Path:
    """Return where the board's firmware image for a boot loader is (Intel HEX)."""
    return _place(board, "hex")


def have(name: str) -> bool:
    """True if the native program `name` is there."""
    found = _program(name)
    return found is not None and found.is_file()


def commit() -> str:
    """Return the commit that this is made of, with "-dirty" where files differ; "" if unknown.

    A wheel brings it, a clone asks git.
    """
    if installed():
        path = _INSTALLED / "commit.txt"
        return path.read_text(encoding="ascii").strip() if path.is_file() else ""
    if not (root() / ".git").exists():  # else git would name the commit of a folder above
        return ""
    words = ["git", "-C", str(root()), "describe", "--always", "--dirty", "--exclude=*"]
    try:
        done = subprocess.run([*words, "--abbrev=10"], capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip()


def have_image(board: str) -> bool:
    """True if the board's image is there."""
    return _place(board, "elf").is_file()


def run(arguments: list[str], *, stdin: str = "") -> subprocess.CompletedProcess[str]:
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


def _program(name: str) -> Path | None:
    """Return where a program is or should be; None if PATH was searched in vain."""
    if name == _SIMULATOR and "PIXSTEP_SIM" in os.environ:
        return Path(os.environ["PIXSTEP_SIM"])
    if not installed():
        return root() / "build" / "host" / "bin" / name
    found = (_packaged() if name == _SIMULATOR else None) or shutil.which(name)
    return Path(found) if found else None


def _packaged() -> Path | None:
    """Return the simulator of the package pixstep_sim; None where it is not installed."""
    try:
        program: Path = importlib.import_module("pixstep_sim").program()
    except ModuleNotFoundError:
        return None
    return program


def _made(name: str) -> Path:
    folder = _INSTALLED if installed() else root() / "build" / "host" / "python"
    return folder / name


def _place(board: str, suffix: str) -> Path:
    """Return where a board's image is or should be."""
    name = f"pixstep-{board}.{suffix}"
    return _INSTALLED / name if installed() else root() / "build" / board / "firmware" / name


def _built(path: Path) -> Path:
    if path.is_file():
        return path
    if path.parent == _INSTALLED:
        raise UserError(f"{path.name}: this wheel of pixstep was built without it")
    if str(path) == os.environ.get("PIXSTEP_SIM"):
        raise UserError(f"{path}: no such file (PIXSTEP_SIM)")
    raise UserError(
        f"{path} is not built: run tools/setup, then `cmake --workflow --preset default`"
    )


@cache
def tables() -> dict[str, Any]:
    """Return the tables that the build has made, by name: rows of plain data.

    Rows are lists of dicts, those of `registers` one list a kind; JSON's keys are texts.
    """
    path = made("tables.json")
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: not the tables that the build makes: {error}") from None
    return found
