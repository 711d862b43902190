# SPDX-License-Identifier: MIT
"""Rule: the modules of a Python package do not import each other in a circle.

An import inside a function or under TYPE_CHECKING counts too: it only hides a circle. Prints how
large the packages are. The packages' directions are import-linter's business (imports.toml); that
the product's tests import nothing of pixstep_dev is seen to here.
"""

import ast
from pathlib import Path

from common import ROOT, finish
from layers import find_circles

PACKAGES = (
    ROOT / "tools" / "src" / "pixstep",
    ROOT / "tools" / "dev" / "pixstep_dev",
    ROOT / "tools" / "dev" / "pixstep_trials",
)
TESTS = ROOT / "tools" / "tests"
PROOF = "pixstep_dev"


def module_name(package: Path, file: Path) -> str:
    """Dotted name of a file of a package."""
    parts = [package.name, *file.relative_to(package).with_suffix("").parts]
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


def of_proof(tests: Path) -> list[str]:
    """Files of the product's tests that import the proof; it has tests of its own."""
    return [
        f"{file.name} imports {name}"
        for file in sorted(tests.glob("*.py"))
        for name in sorted(imported_names(file, file.stem))
        if name.partition(".")[0] == PROOF
    ]


def main() -> None:
    """Build each package's graph of modules and look for circles; look into the tests."""
    sizes, problems = [], of_proof(TESTS)
    for package in PACKAGES:
        files = {module_name(package, file): file for file in sorted(package.rglob("*.py"))}
        graph = {
            name: sorted((imported_names(file, name) & files.keys()) - {name, package.name})
            for name, file in files.items()
        }
        lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files.values())
        sizes.append(f"{package.name} {len(files)} modules, {lines} lines")
        problems += find_circles(graph)
    finish("imports", "; ".join(sizes), problems)


if __name__ == "__main__":
    main()
