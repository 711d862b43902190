# SPDX-License-Identifier: MIT
"""A machine file, machine.toml: pixel clock, boards, motors; read, checked, found, begun.

`model` is what a file holds, `files` reads one, names line and key of what is wrong, and writes;
`describe` shows one. Here is which file is in force: this is cheap to import, unlike the rest.
"""

from pathlib import Path

FILE_NAME = "machine.toml"
VARIABLE = "PIXSTEP_MACHINE"
NO_FILE = "none"  # instead of a file: no defaults, whatever lies in the folder


def find_file(given: str | None) -> Path | None:
    """Return the file that is named, else the one in the current folder, if there is one."""
    if given == NO_FILE:
        return None
    if given:
        return Path(given)
    here = Path(FILE_NAME)
    return here if here.is_file() else None
