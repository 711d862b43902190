# SPDX-License-Identifier: MIT
"""Draws who imports whom among the Python packages, the product's and the proof's.

    package_graph.py                   the drawing as text, users above what they import
    package_graph.py --all             the same with every import, not only the nearest
    package_graph.py --tree FOLDER     the packages of another checkout
    package_graph.py --write FILE      rewrites the drawing in FILE between its markers
    package_graph.py --check FILE      fails if the drawing in FILE is out of date

A package stands one level above the highest one that it imports. Where packages import each other
in a circle, the import with the fewest places is listed below the drawing; imports.toml refuses it.
"""

import argparse
from pathlib import Path

from circles import Uses
from common import ROOT, finish
from imports import imported_names, module_name
from module_graph import text
from modules import Graph, circles

from pixstep_dev import markdown

FOLDERS = ("tools/src/pixstep", "tools/dev/pixstep_dev", "tools/dev/pixstep_trials")
MARKER = "python-packages"


def package_graph(root: Path = ROOT) -> Graph:
    """The graph of a checkout; a module beside the packages counts as one."""
    folders = [root / one for one in FOLDERS if (root / one).is_dir()]
    names = {folder.name for folder in folders}
    graph = Graph()
    for folder in folders:
        for file in sorted(folder.rglob("*.py")):
            name = module_name(folder, file)
            user = _package(name, names)
            if not user or user.endswith("__main__"):
                continue
            graph.add(user)
            for used in imported_names(file, name):
                target = _package(used, names)
                if target and _is_there(root, target):
                    graph.note(user, target, name)
    return graph


def _package(name: str, roots: set[str]) -> str:
    """The package that a dotted name lies in, as "pixstep/board"; empty for anything else."""
    parts = name.split(".")
    return "/".join(parts[:2]) if parts[0] in roots and len(parts) > 1 else ""


def _is_there(root: Path, package: str) -> bool:
    """Whether a package or module has a file: `from pixstep import VALUE` names neither."""
    parents = (root / Path(one).parent / package for one in FOLDERS)
    return any(one.is_dir() or one.with_suffix(".py").is_file() for one in parents)


def against_the_levels(graph: Graph) -> Uses:
    """The imports to leave out until there is no circle, the one with the fewest places first."""
    found: Uses = {}
    while left := circles(graph.without(found)):
        circle = left[0]
        uses = list(zip(circle, [*circle[1:], circle[0]], strict=True))
        user, used = min(uses, key=lambda use: (len(graph.uses[use[0]][use[1]]), use))
        places = graph.uses[user][used]
        found[user, used] = f"a circle, by {len(places)} module{'s' if len(places) > 1 else ''}"
    return found


def drawing(root: Path = ROOT, *, every: bool = False) -> str:
    """The drawing as text."""
    graph = package_graph(root)
    return text(graph, against_the_levels(graph), every)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Who imports whom among the Python packages.")
    parser.add_argument("--all", action="store_true", help="every import, not only the nearest")
    parser.add_argument("--tree", type=Path, default=ROOT, help="another checkout")
    parser.add_argument("--write", type=Path, metavar="FILE", help="rewrite the drawing in FILE")
    parser.add_argument("--check", type=Path, metavar="FILE", help="is that in FILE up to date?")
    return parser.parse_args()


def main() -> None:
    """Draw, write or check."""
    options = arguments()
    drawn = f"```\n{drawing(options.tree, every=options.all)}```\n"
    if options.write:
        markdown.write(options.write, MARKER, drawn)
    elif options.check:
        again = f"tools/checks/package_graph.py --write {options.check}"
        good = markdown.check(options.check, MARKER, drawn)
        stale = [] if good else [f"{options.check}: the drawing is out of date: {again}"]
        finish("package_graph", f"{drawn.count(chr(10)) - 2} packages", stale)
    else:
        print(drawing(options.tree, every=options.all), end="")


if __name__ == "__main__":
    main()
