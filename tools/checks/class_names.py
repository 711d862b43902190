# SPDX-License-Identifier: MIT
"""Rule: no class name stands twice in the Python packages. One word means one thing."""

import ast
from collections import defaultdict

from common import ROOT, finish
from imports import PACKAGES


def main() -> None:
    """Collect the classes of every package, those inside functions too."""
    places: dict[str, list[str]] = defaultdict(list)
    for file in sorted(file for package in PACKAGES for file in package.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(f"{file.relative_to(ROOT)}:{node.lineno}")
    problems = [
        f"class {name} stands {len(found)} times: {', '.join(found)}"
        for name, found in sorted(places.items())
        if len(found) > 1
    ]
    finish("class_names", f"{len(places)} classes", problems)


if __name__ == "__main__":
    main()
