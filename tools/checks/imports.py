# SPDX-License-Identifier: MIT
"""Rule: the modules of the Python package do not import each other in a circle.

An import inside a function or under TYPE_CHECKING counts too: it only hides a circle.
"""

import ast
from pathlib import Path

from common import ROOT, finish
from layers import find_circles

PACKAGE = ROOT / "tools" / "src" / "pixstep"


def module_name(file: Path) -> str:
    """Dotted name of a file of the package."""
    parts = [PACKAGE.name, *file.relative_to(PACKAGE).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_names(file: Path, name: str) -> set[str]:
    """Dotted names that the file imports, relative ones made absolute."""
    names: set[str] = set()
    package = name.split(".") if file.stem == "__init__" else name.split(".")[:-1]
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            names |= {base} | {f"{base}.{alias.name}" for alias in node.names}
    return names


def main() -> None:
    """Build the graph of modules and look for circles."""
    files = {module_name(file): file for file in sorted(PACKAGE.rglob("*.py"))}
    graph = {
        name: sorted((imported_names(file, name) & files.keys()) - {name, PACKAGE.name})
        for name, file in files.items()
    }
    finish("imports", f"{len(files)} Python modules", find_circles(graph))


if __name__ == "__main__":
    main()
