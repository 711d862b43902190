# SPDX-License-Identifier: MIT
"""Small changes of the simulator's models, drawn by a seed: which tests of the project notice?

    build/venv/bin/python tools/checks/sim_mutants.py BUILD SEED [COUNT]

BUILD is a finished build of the host preset. Each mutant changes one operator, constant,
condition, statement or returned value of a model (the files that sim_plants.py plants defects
in), as `pixstep-dev mutants` does in the firmware. It is tried by the suites of sim/tests, by the
crosscheck with the second simulator, and by Python tests that run images. Mutants that do not
compile, or that make the same object code, are drawn again. Prints each survivor; a campaign, not
a test: about a minute a mutant.
"""

import json
import os
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import sim_plants
from common import ROOT, finish
from planting import compile_words, link_words

from pixstep_dev.mutants import operators
from pixstep_dev.mutants.operators import Mutant

COUNT = 24
JOBS = 2
TEST_SECONDS = 600
# Beside sim/tests: what else of the quick check runs on the simulator, the quickest first.
PYTHON_TESTS = (
    "exact", "simctl", "simpipe", "simrun", "sim_baud", "clock_input", "seek_bounces", "powercuts",
    "switches", "board_run",
)  # fmt: skip
CROSSCHECKS = (("locked", "uno"), ("locked", "mega"), ("homing", "mega"), ("saturated", "uno"))


def sources() -> list[Path]:
    """Return the models, in which sim_plants.py plants defects too."""
    return [ROOT / "sim" / name for name in sorted({one.file for one in sim_plants.PLANTS})]


def drawn(seed: int) -> list[Mutant]:
    """Return every mutant of the models in the order of a seed."""
    found = [
        mutant
        for path in sources()
        for mutant in operators.mutants(
            str(path.relative_to(ROOT)), path.read_text(encoding="utf-8")
        )
    ]
    random.Random(seed).shuffle(found)
    return found


class Workplace:
    """A folder in which one mutant is compiled, linked and tried."""

    def __init__(self, build: Path, folder: Path) -> None:
        self._build = build
        self._folder = folder

    def compile(self, mutant: Mutant) -> bool:
        """Compile the changed model; False if it does not compile or makes the same code."""
        kept = ROOT / mutant.file
        source = self._folder / kept.name
        source.write_text(mutant.apply(kept.read_text(encoding="utf-8")), encoding="utf-8")
        changed = self._object(kept, source, "code.o", "-g0")
        same = self._object(kept, kept, "plain.o", "-g0")
        if changed is None or same is None:
            return False
        return changed.read_bytes() != same.read_bytes()

    def _object(self, kept: Path, source: Path, name: str, *options: str) -> Path | None:
        words = compile_words(self._build, kept, sim_plants.TARGET)
        made = self._folder / name
        words[words.index("-o") + 1] = str(made)
        words[words.index(str(kept))] = str(source)
        # No line numbers, and the same name of the file, whatever its folder.
        words[1:1] = [f"-I{kept.parent}", f"-ffile-prefix-map={source.parent}={kept.parent}"]
        done = subprocess.run(
            [*words, *options], cwd=self._build, check=False, stderr=subprocess.DEVNULL
        )
        return made if done.returncode == 0 else None

    def link(self, mutant: Mutant) -> Path:
        """Return the simulator with the changed model."""
        words = compile_words(self._build, ROOT / mutant.file, sim_plants.TARGET)
        replaced = words[words.index("-o") + 1]
        program = self._folder / "pixstep-sim"
        made = str(self._folder / "code.o")
        words = [
            made if word == replaced else word
            for word in link_words(self._build, sim_plants.TARGET)
        ]
        words[words.index(sim_plants.TARGET)] = str(program)
        subprocess.run(words, cwd=self._build, check=True)
        return program

    def find(self, program: Path) -> str:
        """Return the first test that fails with this program; nothing when none does."""
        found = sim_plants.find(program)
        if found:
            return found
        environment = os.environ | {"PIXSTEP_SIM": str(program), "PIXSTEP_REQUIRE_BUILT": "1"}
        for run, board in CROSSCHECKS:
            if not self._crosscheck(run, board, environment):
                return f"crosscheck.{run}.{board}"
        for name in PYTHON_TESTS:
            if not self._pytest(name, environment):
                return f"py.{name}"
        return ""

    def _crosscheck(self, run: str, board: str, environment: dict[str, str]) -> bool:
        kept = str(self._build / "sim/crosscheck" / f"{run}-{board}")
        for name in (f"crosscheck.record.{run}.{board}", f"crosscheck.{run}.{board}"):
            test = _tests(self._build)[name]
            own = dict(word.split("=", 1) for word in test.environment)
            words = [
                word.replace(kept, str(self._folder / f"{run}-{board}")) for word in test.command
            ]
            if not _passes(words, environment | own):
                return False
        return True

    def _pytest(self, name: str, environment: dict[str, str]) -> bool:
        file = ROOT / "tools/tests" / f"test_{name}.py"
        if not file.is_file():
            file = ROOT / "tools/dev/tests" / file.name
        words = [
            sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider",
            "-c", str(ROOT / "tools/pyproject.toml"), "--basetemp", str(self._folder / "scratch"),
            str(file),
        ]  # fmt: skip
        return _passes(words, environment)


@dataclass(frozen=True)
class _Test:
    command: tuple[str, ...]
    environment: tuple[str, ...]


@cache
def _tests(build: Path) -> dict[str, _Test]:
    """Return the tests of the crosscheck as the build has them."""
    listed = subprocess.run(
        ["ctest", "--test-dir", str(build), "--show-only=json-v1", "-R", "^crosscheck[.]"],
        capture_output=True,
        text=True,
        check=True,
    )
    found = {}
    for test in json.loads(listed.stdout)["tests"]:
        own = {one["name"]: one["value"] for one in test.get("properties", ())}
        found[test["name"]] = _Test(tuple(test["command"]), tuple(own.get("ENVIRONMENT", ())))
    return found


def _passes(words: list[str], environment: dict[str, str]) -> bool:
    try:
        done = subprocess.run(
            words,
            cwd=ROOT,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=TEST_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def tried(build: Path, mutant: Mutant) -> str | None:
    """Return what found a mutant, nothing if none did; None if it is no change."""
    with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
        place = Workplace(build, Path(name))
        return place.find(place.link(mutant)) if place.compile(mutant) else None


def main() -> None:
    """Draw mutants until enough of them are a change, and try each."""
    build, seed = Path(sys.argv[1]).resolve(), int(sys.argv[2])
    count = int(sys.argv[3]) if len(sys.argv) > 3 else COUNT
    with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
        plain = Workplace(build, Path(name)).find(build / sim_plants.TARGET)
    if plain:
        finish("sim_mutants", "no mutant", [f"{plain} fails without a change"])
    order, missed, valid = drawn(seed), [], 0
    with ThreadPoolExecutor(JOBS) as pool:
        while valid < count and order:
            batch, order = order[: count - valid], order[count - valid :]
            for mutant, found in zip(
                batch, pool.map(lambda one: tried(build, one), batch), strict=True
            ):
                if found is None:
                    continue
                valid += 1
                place = f"{mutant.file}:{mutant.line}: {mutant.was}"
                print(f"{place} -> {mutant.becomes}: {found or 'NOT FOUND'}", flush=True)
                if not found:
                    missed.append(f"{place}: not found as {mutant.becomes}")
    finish("sim_mutants", f"{valid} mutants, {len(missed)} not found", missed)


if __name__ == "__main__":
    main()
