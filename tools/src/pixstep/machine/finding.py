# SPDX-License-Identifier: MIT
"""Which machine file is in force; this module is cheap to import, unlike the reading of one."""

from pathlib import Path

NAME = "machine.toml"
VARIABLE = "PIXSTEP_MACHINE"
NONE = "none"  # instead of a file: no defaults, whatever lies in the folder


def find(given: str | None) -> Path | None:
    """Return the file that is named, else the one in the current folder, if there is one."""
    if given == NONE:
        return None
    if given:
        return Path(given)
    here = Path(NAME)
    return here if here.is_file() else None
