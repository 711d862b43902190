# SPDX-License-Identifier: MIT
"""Rule: who may include whom. The table below is the architecture; everything else is checked.

Also: every quoted include is found, none goes round in a circle, and in the firmware an include of
another folder's header says what it is for (`#include "hal/uart.h" // uart_put`).
"""

import re
from pathlib import Path

from common import ROOT, finish, repository_files

FREESTANDING = {"limits.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
AVR = {"avr/*", "util/*"}
HOSTED = {"*"}

# What the interrupts and the main loop hand each other: the contracts are written in it.
STEP_TYPES = {
    "firmware/core/ring/captured_edge.h",
    "firmware/core/ring/parked.h",
    "firmware/core/ring/step_codes.h",
    "firmware/core/ring/step_engine.h",
    "firmware/core/ring/step_ring.h",
}

# The rooms of core for motion and those of app, each above those that it may use.
MOTION_ROOMS = ("base", "ring", "clock", "line", "stream", "account", "steps", "axis")
APP_ROOMS = ("settings", "bus", "axes", "watch", "motion", "registers")
BELOW_APP = {"firmware/config.h", "firmware/build_features.h", "firmware/core", "firmware/hal"}

Rows = dict[str, tuple[set[str], set[str]]]


def downwards(folder: str, rooms: tuple[str, ...], also: set[str]) -> Rows:
    """Rows of a folder's rooms: each may include the rooms before it, and what all of them may."""
    paths = [f"{folder}/{room}" for room in rooms]
    return {path: ({*paths[:at], *also}, FREESTANDING) for at, path in enumerate(paths)}


# Folder: (folders whose headers it may include, besides its own; system headers it may include).
# The longest matching folder decides. A single header may stand where a folder would be too much.
LAYERS: Rows = {
    **downwards("firmware/core", MOTION_ROOMS, {"firmware/build_features.h"}),
    "firmware/core/wire": ({"firmware/core/base", "firmware/build_features.h"}, FREESTANDING),
    "firmware/hal": ({"firmware/config.h", *STEP_TYPES}, FREESTANDING),
    "firmware/avr/boards": (set(), set()),
    # The assembly half of core.
    "firmware/avr/core": (
        {"firmware/build_features.h", "firmware/core", "generated"},
        FREESTANDING | AVR,
    ),
    "firmware/avr/hal": (
        {"firmware/config.h", "firmware/hal", "firmware/core/base", "generated", *STEP_TYPES},
        FREESTANDING | AVR,
    ),
    # What the assembly has to know of all structs.
    "firmware/avr": (
        {"firmware/build_features.h", "firmware/core", "firmware/avr/hal"},
        FREESTANDING,
    ),
    **downwards("firmware/app", APP_ROOMS, BELOW_APP),
    # main, the round and what starts them.
    "firmware/app": (BELOW_APP, FREESTANDING),
    # Its fakes stand behind the hal's contracts, for the axes that the image has.
    "host_tests": (
        {"firmware/config.h", "firmware/core", "firmware/hal", "firmware/app", "unity"},
        HOSTED,
    ),
    # What stands in the place of the hal's assembly under the real firmware.
    "host_tests/explore": (
        {
            "firmware/config.h",
            "firmware/core",
            "firmware/hal",
            "firmware/avr/hal",
            "firmware/app",
            "host_tests",
        },
        HOSTED,
    ),
    # The images' own interrupts beside a twin, on the simulator's model of the timer.
    "host_tests/late": ({"firmware/core", "firmware/avr/boards", "host_tests", "sim"}, HOSTED),
    "host_tests/handlers": ({"firmware/avr/boards", "host_tests", "sim"}, HOSTED),
    "sim": ({"firmware/avr/boards", "firmware/core/base"}, HOSTED),
    "tools/native": (
        {"firmware/config.h", "firmware/core", "firmware/app", "host_tests/fakes"},
        HOSTED,
    ),
    "fuzz": (
        {"firmware/config.h", "firmware/core", "firmware/app", "host_tests/fakes"},
        HOSTED,
    ),
}

# Nobody reaches into these from outside, whatever the table says of the folder above, but for the
# folders named with them.
PRIVATE = {
    "firmware/avr/core": set(),
    "firmware/avr/hal": {"firmware/avr", "host_tests/explore"},
}

# Folders that an include path may start from.
SEARCHED = ["firmware/core", "firmware", "host_tests", "sim", "fuzz"]

# Headers that are in no folder of the tree: others' and generated ones.
EXTERNAL = {"unity.h": "unity/unity.h", "layout.h": "generated/layout.h"}

INCLUDE = re.compile(r'^\s*#\s*include\s+(?P<open>["<])(?P<name>[^">]+)[">](?P<rest>.*)$')


def layer_of(path: str) -> str | None:
    """The longest row of the table that the path lies under."""
    fitting = [layer for layer in LAYERS if path.startswith(layer + "/")]
    return max(fitting, key=len, default=None)


def within(path: str, places: set[str]) -> bool:
    """Whether the path is one of the places or lies under one."""
    return any(path == place or path.startswith(place + "/") for place in places)


def system_header_allowed(name: str, allowed: set[str]) -> bool:
    """Whether <name> is in the list; 'avr/*' stands for a folder and '*' for everything."""
    folder = name.split("/")[0] + "/*" if "/" in name else name
    return "*" in allowed or name in allowed or folder in allowed


def find_header(name: str, includer: Path) -> str | None:
    """Repository path of a quoted include, looked for as the compiler does."""
    if name in EXTERNAL:
        return EXTERNAL[name]
    for folder in [includer.parent, *(ROOT / start for start in SEARCHED)]:
        candidate = (folder / name).resolve()
        if candidate.is_file() and candidate.is_relative_to(ROOT):
            return candidate.relative_to(ROOT).as_posix()
    return None


def private_to_others(target: str, path: str) -> bool:
    """Whether the target lies in a private folder and the includer neither there nor named."""
    return any(
        within(target, {room}) and not within(path, {room, *named})
        for room, named in PRIVATE.items()
    )


def needs_purpose(path: str, target: str) -> bool:
    """Whether an include must say what it is for: not its own header, a neighbour or a table."""
    own, other = Path(path), Path(target)
    return own.parent != other.parent and own.stem != other.stem and other.suffix != ".def"


def check_quoted(path: str, target: str | None, name: str, rest: str) -> list[str]:
    """Complaints about one quoted include of a file in the table."""
    if target is None:
        return [f'includes "{name}", which is in no known folder']
    layer = layer_of(path)
    allowed = LAYERS[layer][0] | {layer} if layer else set()
    complaints = []
    if not within(target, allowed) or private_to_others(target, path):
        complaints.append(f"{layer} must not include {target}")
    if path.startswith("firmware/") and needs_purpose(path, target) and "//" not in rest:
        complaints.append(f'the include of "{name}" does not say what it is for')
    return complaints


def check_file(file: Path) -> tuple[list[str], list[str]]:
    """Problems of one file, and the repository files that it includes."""
    path = file.relative_to(ROOT).as_posix()
    layer = layer_of(path)
    problems: list[str] = []
    targets: list[str] = []
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        match = INCLUDE.match(line)
        if not match:
            continue
        name, complaints = match["name"], []
        if match["open"] == '"':
            target = find_header(name, file)
            complaints = check_quoted(path, target, name, match["rest"])
            if target:
                targets.append(target)
        elif not system_header_allowed(name, LAYERS[layer][1]):
            complaints = [f"{layer} must not include <{name}>"]
        problems += [f"{path}:{number}: {complaint}" for complaint in complaints]
    return problems, targets


def find_circles(graph: dict[str, list[str]]) -> list[str]:
    """Every circle of includes, named once, from a depth-first walk."""
    circles: list[str] = []
    state: dict[str, str] = {}

    def walk(node: str, trail: list[str]) -> None:
        state[node] = "open"
        for target in graph.get(node, []):
            if state.get(target) == "open":
                circle = [*trail[trail.index(target) :], target]
                circles.append("circle of includes: " + " -> ".join(circle))
            elif target not in state:
                walk(target, [*trail, target])
        state[node] = "closed"

    for start in sorted(graph):
        if start not in state:
            walk(start, [start])
    return circles


def main() -> None:
    """Check every C file that a row of the table covers."""
    problems: list[str] = []
    graph: dict[str, list[str]] = {}
    for file in repository_files():
        path = file.relative_to(ROOT).as_posix()
        if file.suffix in {".c", ".h", ".def", ".S", ".inc"} and layer_of(path):
            found, graph[path] = check_file(file)
            problems += found
    finish("layers", f"{len(graph)} C files", problems + find_circles(graph))


if __name__ == "__main__":
    main()
