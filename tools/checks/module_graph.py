# SPDX-License-Identifier: MIT
"""Draws who uses whom among the modules of the firmware, or of the simulator.

    module_graph.py                    the drawing as text, users above what they use
    module_graph.py --all              the same with every use, not only the nearest
    module_graph.py --dot              the same for Graphviz: | dot -Tsvg -o modules.svg
    module_graph.py --sim              the simulator's modules
    module_graph.py --write FILE       rewrites the drawings in FILE between their markers
    module_graph.py --check FILE       fails if the drawings in FILE are out of date

A module stands one level above the highest module that it uses. Uses that close a circle (the
tables of circles.py) are left out of the levels and listed below the drawing with their reasons.
"""

import argparse
import textwrap
from pathlib import Path

from circles import FIRMWARE, SIM, Uses, firmware_graph, sim_graph
from common import ROOT, board_names, build_folder, finish
from modules import Graph, ModuleError, short

from pixstep.errors import UserError
from pixstep_dev import markdown

WIDTH = 100
TABLES = ("firmware-modules", "sim-modules")


def reached(graph: Graph) -> dict[str, set[str]]:
    """For each module all that it uses, directly or by others; the graph has no circle."""
    found: dict[str, set[str]] = {}

    def visit(module: str) -> set[str]:
        if module not in found:
            found[module] = set(graph.uses[module])
            for used in graph.uses[module]:
                found[module] |= visit(used)
        return found[module]

    for module in graph.uses:
        visit(module)
    return found


def levels(graph: Graph) -> dict[str, int]:
    """For each module its level: 0 if it uses none, else one above the highest that it uses."""
    found: dict[str, int] = {}

    def level(module: str) -> int:
        if module not in found:
            found[module] = 1 + max((level(used) for used in graph.uses[module]), default=-1)
        return found[module]

    for module in graph.uses:
        level(module)
    return found


def nearest(graph: Graph) -> Graph:
    """The graph less the uses that follow from others."""
    below = reached(graph)
    implied = [
        (user, used)
        for user, targets in graph.uses.items()
        for used in targets
        if any(used in below[other] for other in targets)
    ]
    return graph.without(implied)


def text(graph: Graph, allowed: Uses, every: bool = False) -> str:
    """The drawing as text: a line for each module, by level from the top."""
    open_graph = graph.without(allowed)
    shown = open_graph if every else nearest(open_graph)
    level = levels(open_graph)
    width = max((len(short(module)) for module in level), default=0)
    lines: list[str] = []
    for module in sorted(level, key=lambda one: (-level[one], one)):
        head = f"{level[module]:2}  {short(module):{width}}  "
        used = " ".join(near_name(module, one) for one in sorted(shown.uses[module])) or "-"
        lines += textwrap.wrap(
            head + used, WIDTH, subsequent_indent=" " * len(head), drop_whitespace=True
        )
    for (user, used), why in allowed.items():
        lines += ["", "against the levels:"] if (user, used) == next(iter(allowed)) else []
        lines.append(f"    {short(user)} -> {short(used)}: {why}")
    return "\n".join(lines) + "\n"


def near_name(user: str, used: str) -> str:
    """A module's name as its user would say it: without a folder that both are in."""
    folder = user.rpartition("/")[0]
    inside = used.removeprefix(folder + "/")
    return inside if "/" not in inside else short(used)


def dot(graph: Graph, allowed: Uses) -> str:
    """The drawing for Graphviz, the uses that close a circle in red."""
    open_graph = graph.without(allowed)
    lines = ["digraph modules {", "    rankdir=TB; node [shape=box, fontname=sans];"]
    for folder in sorted({module.rpartition("/")[0] for module in graph.uses}):
        lines.append(f'    subgraph "cluster_{folder}" {{ label="{short(folder)}";')
        inside = (module for module in sorted(graph.uses) if module.rpartition("/")[0] == folder)
        lines += [f'        "{module}" [label="{Path(module).name}"];' for module in inside]
        lines.append("    }")
    for user, targets in sorted(nearest(open_graph).uses.items()):
        lines += [f'    "{user}" -> "{used}";' for used in sorted(targets)]
    lines += [f'    "{user}" -> "{used}" [color=red];' for user, used in allowed]
    return "\n".join([*lines, "}"]) + "\n"


def part_graph(sim: bool) -> Graph:
    """The graph of the simulator or of the firmware, by the builds where they usually are."""
    host = ROOT / "build" / "host"
    if sim:
        return sim_graph(host)
    return firmware_graph(host, [build_folder(board) for board in board_names()])


def drawings() -> dict[str, str]:
    """Both drawings as a document holds them, by the names of their markers."""
    drawn = (text(part_graph(sim=False), FIRMWARE), text(part_graph(sim=True), SIM))
    return {name: f"```\n{one}```\n" for name, one in zip(TABLES, drawn, strict=True)}


def deliver(options: argparse.Namespace) -> list[str]:
    """Write or check the drawings of a document; return what is out of date."""
    stale = []
    for name, drawn in drawings().items():
        if options.write:
            markdown.write(options.write, name, drawn)
        elif not markdown.check(options.check, name, drawn):
            stale.append(
                f"{options.check}: the drawing {name} is out of date: "
                f"build/venv/bin/python tools/checks/module_graph.py --write {options.check}"
            )
    return stale


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Who uses whom among the modules.")
    parser.add_argument("--all", action="store_true", help="every use, not only the nearest")
    parser.add_argument("--dot", action="store_true", help="for Graphviz")
    parser.add_argument("--sim", action="store_true", help="the simulator's modules")
    parser.add_argument("--write", type=Path, metavar="FILE", help="rewrite the drawings in FILE")
    parser.add_argument("--check", type=Path, metavar="FILE", help="are those in FILE up to date?")
    return parser.parse_args()


def main() -> None:
    """Draw, write or check."""
    options = arguments()
    try:
        if options.write or options.check:
            finish("module_graph", f"{len(TABLES)} drawings", deliver(options))
        graph = part_graph(options.sim)
    except (ModuleError, UserError) as error:
        finish("module_graph", "nothing drawn", [str(error)])
    allowed = SIM if options.sim else FIRMWARE
    print(dot(graph, allowed) if options.dot else text(graph, allowed, options.all), end="")


if __name__ == "__main__":
    main()
