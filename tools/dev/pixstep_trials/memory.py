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
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pixstep import natives
from pixstep.simulation.simulator import Simulator
from pixstep_trials.probe import BoardProbe

_SOURCE = "app/axes/axes.c"  # every source of core and app is built with its options
_PROBE = """
#include <stddef.h>
#include "{header}"
const size_t probe[] = {{
    offsetof({struct}, {member}), sizeof((({struct} *)0)->{member})}};
"""


@dataclass(frozen=True)
class Variable:
    """A static variable of the firmware: its symbol, its type and the header of that type."""

    symbol: str
    struct: str
    header: str


# What tests may read and write, by the first word of a path such as "axes[0].ledger.loaded_ticks".
VARIABLES = {
    "axes": Variable("axes", "struct axis", "axis/axis.h"),
    "clock": Variable("edge_watch", "struct clock_watch", "clock/clock_watch.h"),
    "fault": Variable("first_fault", "struct fault_record", "app/axes/faults.h"),
    "limits": Variable("current_limits", "struct line_limits", "line/line_check_state.h"),
    "engine": Variable("step_engines", "struct step_engine", "ring/step_engine.h"),
}
_PATH = re.compile(r"(?P<variable>[a-z_]+)(?:\[(?P<index>\d+)\])?\.(?P<member>.+)")


@dataclass(frozen=True)
class MemberPlace:
    """Where a member lies: bytes behind its variable's symbol, and its size."""

    symbol: str
    offset: int
    size: int


@cache
def place(board: str, path: str) -> MemberPlace:
    """Return where a member of a variable lies, "axes[0].ledger.loaded_ticks"."""
    match = _PATH.fullmatch(path)
    if match is None:
        raise ValueError(f"{path!r} names no member of a variable")
    variable = VARIABLES[match["variable"]]
    source = _PROBE.format(header=variable.header, struct=variable.struct, member=match["member"])
    offset, size = _words(board, source)
    index = int(match["index"] or 0)
    stride = _size_of(board, variable) if index else 0
    return MemberPlace(variable.symbol, index * stride + offset, size)


def _size_of(board: str, variable: Variable) -> int:
    """Return the size of the variable's struct, in bytes."""
    text = f'#include "{variable.header}"\nconst unsigned probe = sizeof({variable.struct});\n'
    (size,) = _words(board, text)
    return size


def _words(board: str, source: str) -> list[int]:
    """Compile constants of 16 bits as the image's sources are, and return them."""
    with tempfile.TemporaryDirectory() as folder:
        probe = Path(folder) / "probe.c"
        probe.write_text(source)
        text = subprocess.run(
            [*_options(board), "-fno-lto", "-S", "-o", "-", str(probe)],
            capture_output=True,
            check=True,
            text=True,
        ).stdout
    return [int(word) for word in re.findall(r"^\s*\.word\s+(\d+)$", text, re.MULTILINE)]


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

    def __init__(self, simulator: Simulator, board: str) -> None:
        self._simulator, self._board = simulator, board

    def place(self, path: str) -> MemberPlace:
        """Return where a member lies."""
        return place(self._board, path)

    def address(self, path: str) -> int:
        """Return the address of a member in RAM."""
        found = self.place(path)
        return BoardProbe(self._simulator).symbol(0, found.symbol).address + found.offset

    def read(self, path: str) -> int:
        """Return a member as a number."""
        found = self.place(path)
        answer = self._simulator.command(f"peek 0 {found.symbol}+{found.offset} {found.size}")
        return int.from_bytes(bytes.fromhex(answer.split()[1]), "little")

    def write(self, path: str, value: int) -> None:
        """Set a member."""
        found = self.place(path)
        data = (value % (1 << 8 * found.size)).to_bytes(found.size, "little")
        self._simulator.command(f"poke 0 {found.symbol}+{found.offset} {data.hex()}")
