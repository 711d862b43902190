# SPDX-License-Identifier: MIT
"""Where the simulator's program is: the package `pixstep` asks, and `pixstep-sim` runs it."""

import os
import sys
from pathlib import Path


def program() -> Path:
    """Return the path of the program."""
    return Path(__file__).resolve().parent / "bin" / "pixstep-sim"


def run() -> None:
    """Become the program, with the words of the command line."""
    path = str(program())
    os.execv(path, [path, *sys.argv[1:]])
