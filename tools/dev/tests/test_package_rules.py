# SPDX-License-Identifier: MIT
"""The rules about Python packages: the contracts and the drawing each find a planted offence."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import imports
import package_graph
import pytest

from pixstep import natives

CONTRACTS = "tools/checks/imports.toml"
TYPES = "tools/checks/mypy.ini"


@pytest.fixture
def lint(tmp_path):
    """Return a function that appends a line to some modules of a copy and judges the copy."""
    for folder in package_graph.FOLDERS:
        source = natives.root() / folder
        shutil.copytree(source, tmp_path / source.name, ignore=shutil.ignore_patterns("*.pyc"))

    def judged(planted):
        for name, line in planted.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a") as file:
                file.write(f"{line}\n")
        tool = Path(sys.executable).with_name("lint-imports")
        done = subprocess.run(
            [tool, "--config", natives.source(CONTRACTS), "--no-cache"],
            env=os.environ | {"PYTHONPATH": str(tmp_path), "COLUMNS": "200"},
            capture_output=True, text=True, check=False, cwd=tmp_path,
        )  # fmt: skip
        broken = [
            row.removesuffix(" BROKEN") for row in done.stdout.splitlines() if "BROKEN" in row
        ]
        assert (done.returncode != 0) == bool(broken), done.stdout + done.stderr
        return broken

    return judged


def test_the_packages_as_they_are(lint):
    assert lint({}) == []


LAYERS = "the layers of pixstep"
APART = "pixstep does not import what proves it"


@pytest.mark.parametrize(
    ("place", "line", "contract"),
    [
        ("pixstep/signals.py", "import pixstep_dev.markdown", APART),
        ("pixstep/lines/runs.py", "import pixstep.board.port", LAYERS),
        ("pixstep/board/port.py", "import pixstep.profiles.origin", LAYERS),
        ("pixstep/errors.py", "def late():\n    import pixstep.cli.main", LAYERS),
        ("pixstep/unheard_of.py", "VALUE = 1", LAYERS),
        ("pixstep_dev/unheard_of/__init__.py", "VALUE = 1", f"{LAYERS}-dev"),
        ("pixstep_dev/robustness/noise.py", "import pixstep_dev.docs.tables", f"{LAYERS}-dev"),
    ],
)
def test_an_offence_is_found(lint, place, line, contract):
    assert contract in lint({place: line})


def test_a_circle_of_packages_inside_is_found(lint):
    planted = {
        "pixstep/cli/board/person.py": "import pixstep.cli.main",
        "pixstep/cli/main.py": "import pixstep.cli.board.person",
    }
    assert lint(planted) == ["no circle between the packages inside"]


@pytest.fixture(scope="module")
def small_package(tmp_path_factory):
    """Return where a package as large as a test's can be judged by the rules for types."""
    root = tmp_path_factory.mktemp("types")
    (root / "checks").mkdir()
    shutil.copy(natives.source(TYPES), root / "checks")
    for place in ("src/pixstep", "src/pixstep/cli", "dev/pixstep_dev", "dev/pixstep_trials"):
        (root / place).mkdir(parents=True)
        (root / place / "__init__.py").touch()
    return root


@pytest.mark.parametrize(
    ("planted", "complaint"),
    [
        ("def half(value: int) -> float:\n    return value / 2", ""),
        ("def half(value):\n    return value / 2", "no-untyped-def"),
        ("def facts() -> dict:\n    return {}", "type-arg"),
        ("import json\ndef facts() -> list[int]:\n    return json.loads('[]')", "no-any-return"),
        ("STEPS = 1  # type: ignore", "unused-ignore"),
    ],
    ids=["fine", "untyped", "half a type", "any", "ignored"],
)
def test_the_types_of_a_command_are_judged_strictly(small_package, planted, complaint):
    (small_package / "src" / "pixstep" / "cli" / "planted.py").write_text(f"{planted}\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", "checks/mypy.ini"],
        env=os.environ | {"PYTHONPATH": ""},
        capture_output=True, text=True, check=False, cwd=small_package,
    )  # fmt: skip
    assert (done.returncode != 0) == bool(complaint), done.stdout + done.stderr
    assert done.stdout.count("error:") == bool(complaint)
    assert complaint in done.stdout


def tree(root, **modules):
    """Write modules, pixstep__board__port, with their text into a small checkout."""
    for name, text in modules.items():
        parts = name.split("__")
        path = root / package_graph.FOLDERS[parts[0] == "pixstep_dev"] / "/".join(parts[1:])
        path.parent.mkdir(parents=True, exist_ok=True)
        path.with_suffix(".py").write_text(text)
    return root


def test_the_drawing_has_levels_and_only_the_nearest(tmp_path):
    root = tree(
        tmp_path,
        pixstep__errors="",
        pixstep__lines__line="from pixstep import errors, VERSION\n",
        pixstep__cli__main="from pixstep.errors import E\nfrom pixstep.lines.line import Line\n",
        pixstep_dev__docs__of="def late():\n    import pixstep.cli.main\n",
    )
    assert package_graph.drawing(root).splitlines() == [
        " 3  pixstep_dev/docs  pixstep/cli",
        " 2  pixstep/cli       lines",
        " 1  pixstep/lines     errors",
        " 0  pixstep/errors    -",
    ]
    assert "pixstep/cli       errors lines" in package_graph.drawing(root, every=True)


def test_the_drawing_names_the_import_that_closes_a_circle(tmp_path):
    root = tree(
        tmp_path,
        pixstep__lines__line="import pixstep.board.port\n",
        pixstep__board__port="import pixstep.lines.line\n",
        pixstep__board__run="import pixstep.lines.line\n",
    )
    assert package_graph.drawing(root).splitlines() == [
        " 1  pixstep/board  lines",
        " 0  pixstep/lines  -",
        "",
        "against the levels:",
        "    pixstep/lines -> pixstep/board: a circle, by 1 module",
    ]


def test_the_products_tests_import_nothing_of_the_proof(tmp_path):
    assert imports.of_proof(imports.TESTS) == []
    (tmp_path / "test_some.py").write_text("def late():\n    from pixstep_dev import markdown\n")
    (tmp_path / "test_other.py").write_text("from pixstep_trials import lines\nimport pixstep\n")
    found = ["test_some.py imports pixstep_dev", "test_some.py imports pixstep_dev.markdown"]
    assert imports.of_proof(tmp_path) == found
