# SPDX-License-Identifier: MIT
"""Rule: every feature switch compiles both ways for each board; and what each switch costs.

    features.py BUILD              builds every image with each switch turned over, and prints the costs
    features.py BUILD --write FILE     puts the table between FILE's markers `features`
    features.py BUILD --check FILE     the same, but complains when the table there is another

BUILD is a folder for the images; an image that is up to date is not built again. The switches are
the rows of firmware/build_features.def, their defaults those of firmware/build_features.h.
"""

import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from common import ROOT, board_names, finish, write_between
from sizes import memory_bytes

ROW = re.compile(r'^FEATURE\((?P<bit>\d+), (?P<name>\w+), "(?P<meaning>[^"]*)"\)$', re.MULTILINE)
WORKERS = 2


@dataclass(frozen=True)
class Feature:
    """One row of build_features.def."""

    bit: int
    name: str
    meaning: str

    @property
    def switch(self) -> str:
        """Name of its macro."""
        return f"FEATURE_{self.name.upper()}"


class BuildError(Exception):
    """An image that could not be built, with the compiler's first words."""


def read_features(text: str) -> list[Feature]:
    """The rows of the table."""
    return [Feature(int(m["bit"]), m["name"], m["meaning"]) for m in ROW.finditer(text)]


def run(command: list[str]) -> str:
    """Output of a program; BuildError with the lines that name an error."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, check=False, text=True)
    if done.returncode:
        said = (done.stdout + done.stderr).splitlines()
        errors = [line for line in said if "error" in line.lower()] or said[-3:]
        raise BuildError("; ".join(errors[:3]))
    return done.stdout


def build(folder: Path, board: str, setting: str) -> Path:
    """The image of a board with one switch set (or none: ""); its ELF file."""
    where = folder / board / (setting or "default").replace("=", "_")
    run(["cmake", "--preset", board, "-B", str(where), f"-DPIXSTEP_FEATURES={setting}"])
    run(["cmake", "--build", str(where), "--target", f"pixstep-{board}", "--", "-j1"])
    return where / "firmware" / f"pixstep-{board}.elf"


def defaults(board: str) -> dict[str, bool]:
    """Which features the board's image has, as the compiler sees it."""
    macros = run(
        ["avr-gcc", "-E", "-dM", "-Ifirmware", "-Ifirmware/core", "-include"]
        + [f"firmware/hal/boards/{board}.def", "-include", "firmware/build_features.h"]
        + ["-x", "c", "/dev/null"]
    )
    found = dict(re.findall(r"^#define (FEATURE_\w+) (\S+)$", macros, re.MULTILINE))
    return {name: found.get(found[name], found[name]) == "1" for name in found}


@dataclass(frozen=True)
class Cost:
    """What a feature takes of a board, in bytes, and whether its default has it."""

    flash: int
    ram: int
    default: bool


def cost(folder: Path, board: str, feature: Feature, has: bool) -> Cost:
    """Build the image with the switch turned over and compare it with the default."""
    usual = memory_bytes(board, build(folder, board, ""))
    other = memory_bytes(board, build(folder, board, f"{feature.switch}={0 if has else 1}"))
    sign = 1 if has else -1
    return Cost(sign * (usual[0] - other[0]), sign * (usual[1] - other[1]), has)
