# SPDX-License-Identifier: MIT
"""Rule: the modules of the firmware and of the simulator use each other in no circle, and so do the
folders of the firmware.

    circles.py [HOST_BUILD]      reads includes, and the symbols in the objects of the native build
                                 (default: build/host) and of every board's build

The tables below list the uses that may close a circle, each with its reason; module_graph.py also
writes them into docs/MODULES.md. A row that closes no circle is an error.
"""

import sys
from pathlib import Path

from common import ROOT, board_names, build_folder, finish, repository_files
from modules import (
    KEEPERS,
    Graph,
    ModuleError,
    build_symbols,
    circles,
    declares,
    include_graph,
    module_files,
    note_symbols,
    short,
    shortest_way,
)

# A port declares functions that a layer needs and that a higher layer implements. A call of such a
# function is a use of the port's header, not of the module that implements the function.
PORTS = {
    "firmware/core/base/require.h": "a broken promise: the firmware's fault, a test's failure",
    "firmware/core/line/line_divider.h": "setting `divider` behind the start mark of a line",
    "firmware/core/wire/server_data.h": "the data behind the server's registers and coils",
}

Uses = dict[tuple[str, str], str]

# (user, used): why this use may close a circle.
FIRMWARE: Uses = {
    ("firmware/avr/hal/step_isr", "firmware/hal/step_timer"): "one engine in two languages",
}
SIM: Uses = {}


def firmware_graph(host: Path, boards: list[Path], root: Path = ROOT) -> Graph:
    """The firmware's graph, by its includes and by the symbols of all builds."""
    graph = include_graph(module_files(repository_files(root), "firmware", root), root)
    for build in (host, *boards):
        note_symbols(graph, build_symbols(build, root=root), PORTS, root)
    return graph


def folder_graph(graph: Graph) -> Graph:
    """The folders of a graph's modules: one uses another if a module of it does.

    The contracts of the hal and what keeps them are one.
    """
    folders = Graph()
    for user, targets in graph.uses.items():
        for used, reasons in targets.items():
            folders.note(folder_of(user), folder_of(used), reasons[0])
    return folders


def folder_of(module: str) -> str:
    """The folder of a module, or the one of the contracts that its sources keep."""
    folder = module.rpartition("/")[0]
    return KEEPERS.get(folder, folder)


def sim_graph(host: Path, root: Path = ROOT) -> Graph:
    """The simulator's graph, by its includes and by the symbols of the native build."""
    graph = include_graph(module_files(repository_files(root), "sim", root), root)
    note_symbols(graph, build_symbols(host, "sim", root), root=root)
    return graph


def complaints(graph: Graph, allowed: Uses) -> list[str]:
    """Circles that the table does not allow, and rows of the table that close no circle."""
    left = graph.without(allowed)
    found = [f"circle of modules: {describe(graph, circle)}" for circle in circles(left)]
    for user, used in allowed:
        closes = used in graph.uses.get(user, {}) and shortest_way(left, used, user)
        if not closes:
            found.append(f"the table's {short(user)} -> {short(used)} closes no circle: remove it")
    return found


def describe(graph: Graph, circle: list[str]) -> str:
    """A circle in words, each use with one thing that is used."""
    words = [short(circle[0])]
    for user, used in zip(circle, [*circle[1:], circle[0]], strict=True):
        words.append(f"-> {short(used)} ({graph.uses[user][used][0].removeprefix('firmware/')})")
    return " ".join(words)


def bad_ports(graph: Graph, ports: dict[str, str], root: Path = ROOT) -> list[str]:
    """Rows of the ports' table that are wrong: gone, a module of its own, or called by nobody."""
    found = []
    for port in ports:
        path = root / port
        if not path.is_file():
            found.append(f"the port {port} is gone: remove it from the table")
        elif any(path.with_suffix(suffix).is_file() for suffix in (".c", ".S")):
            found.append(f"the port {port} has a source beside it: it is a module")
        elif not any(_calls(why, port, root) for to in graph.uses.values() for why in to.values()):
            found.append(f"the port {port} is called by nobody: remove it from the table")
    return found


def _calls(reasons: list[str], port: str, root: Path) -> bool:
    """Whether one of the reasons for a use is a call of a port's function."""
    return any(why.endswith("()") and declares(port, why[:-2], root) for why in reasons)


def main() -> None:
    """Look at both graphs."""
    host = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "host"
    try:
        firmware = firmware_graph(host, [build_folder(board) for board in board_names()])
        sim = sim_graph(host)
    except ModuleError as error:
        finish("circles", "nothing looked at", [str(error)])
    problems = complaints(firmware, FIRMWARE) + bad_ports(firmware, PORTS) + complaints(sim, SIM)
    problems += complaints(folder_graph(firmware.without(FIRMWARE)), {})
    uses = sum(len(targets) for graph in (firmware, sim) for targets in graph.uses.values())
    modules = f"{len(firmware.uses)} modules of the firmware, {len(sim.uses)} of sim"
    finish("circles", f"{modules}, {uses} uses", problems)


if __name__ == "__main__":
    main()
