# SPDX-License-Identifier: MIT
"""Files that are to be written: none that exists, is an input, or is written twice."""

import os
from collections.abc import Iterable
from pathlib import Path

from pixstep import atomic
from pixstep.operations.asked import AskedError


def refuse(named: Iterable[tuple[str, Path]]) -> None:
    """Refuse outputs that the rules forbid, or that share a file or a stream.

    The names are those of fields, or what a front end calls them.
    """
    seen: dict[str, str] = {}
    for name, path in named:
        stream = atomic.is_stdout(path)
        place = str(atomic.STDOUT) if stream else os.path.realpath(path)
        if place in seen and (stream or not path.is_char_device()):  # a device takes both
            both = f"{{{seen[place]}}} and {{{name}}}"
            raise AskedError(f"{{path}}: {both} are the same file", path=path)
        seen[place] = name
        atomic.refuse(path)
