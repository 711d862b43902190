# SPDX-License-Identifier: MIT
"""The firmware's variables in a simulated board's RAM, for tests that disturb them.

The simulator knows the variables' addresses; where a member lies in a struct says the compiler that
built the image, with the options it was built with.
"""

import json
import re
import shlex
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from pixstep import natives

_SOURCE = "app/machine.c"  # its options are those of the struct's own file
_PROBE = """
#include <stddef.h>
#include "app/machine.h"
const size_t probe[] = {{
    offsetof({struct}, {member}), sizeof((({struct} *)0)->{member})}};
"""


@cache
def member(board: str, struct: str, name: str) -> tuple[int, int]:
    """Return offset and size of a member, "axes[0].zero_ticks", in bytes."""
    with tempfile.TemporaryDirectory() as folder:
        probe = Path(folder) / "probe.c"
        probe.write_text(_PROBE.format(struct=struct, member=name))
        text = subprocess.run(
            [*_options(board), "-S", "-o", "-", str(probe)],
            capture_output=True,
            check=True,
            text=True,
        ).stdout
    low = [int(word) for word in re.findall(r"^\s*\.word\s+(\d+)$", text, re.MULTILINE)]
    offset, size = low
    return offset, size


@cache
def _options(board: str) -> list[str]:
    """Return the compiler and its options without source and output."""
    build = natives.root() / "build" / board / "compile_commands.json"
    (entry,) = [one for one in json.loads(build.read_text()) if one["file"].endswith(f"/{_SOURCE}")]
    words = shlex.split(entry["command"])
    del words[words.index("-o") : words.index("-o") + 2]
    return [word for word in words if word != "-c" and not word.endswith(_SOURCE)]


class Memory:
    """Reads and writes members of the firmware's variables; little-endian numbers."""

    def __init__(self, simulator, board: str) -> None:
        self._simulator, self._board = simulator, board

    def read(self, variable: str, struct: str, name: str) -> int:
        """Return a member as a number."""
        offset, size = member(self._board, struct, name)
        answer = self._simulator.command(f"peek 0 {variable}+{offset} {size}")
        return int.from_bytes(bytes.fromhex(answer.split()[1]), "little")

    def write(self, variable: str, struct: str, name: str, value: int) -> None:
        """Set a member."""
        offset, size = member(self._board, struct, name)
        data = (value % (1 << 8 * size)).to_bytes(size, "little")
        self._simulator.command(f"poke 0 {variable}+{offset} {data.hex()}")
