# SPDX-License-Identifier: MIT
"""A wheel of the Python package, installed into an empty environment, works without the clone.

    wheel.py FOLDER

Builds the wheel with the images of this clone, makes an environment in FOLDER that has the wheel
and what it declares to need and nothing else, and runs commands there in an empty folder, with a
PATH that has only the environment. What needs the simulator says so in one line, and runs when
the simulator is named.
"""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import distribution
from pathlib import Path

from common import ROOT, finish

# Where byte code is kept: the libraries are links, and not to be written to.
BYTE_CODE = ("PYTHONPYCACHEPREFIX",)
PROFILE = "AccProfM39-30Hz-1.PRN"
LINE = ("line.csv", "--decode", "smooth", "--pixel-hz", "30")
COMMANDS = (
    ("--version",),
    ("line", "make", "--profile", PROFILE, "--speed", "1000", "--pixels", "60",
     "--pixel-hz", "30", "-o", "line.csv"),
    ("line", "check", *LINE, "--board", "mega"),
    ("line", "show", *LINE),
    ("ticks", *LINE, "-o", "ticks.csv"),
    ("flash", "--board", "uno", "--port", "/dev/null", "--dry-run"),
    ("board", "--help"),
    ("board", "set", "--help"),
)  # fmt: skip
SIMULATE = ("sim", *LINE, "--board", "mega", "--out", "run")


def build(folder: Path) -> Path:
    """Build the wheel and return its file."""
    made = folder / "dist"
    shutil.rmtree(made, ignore_errors=True)
    images = f"cmake.define.PIXSTEP_IMAGES={ROOT / 'build'}"
    call([
        sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check",
        "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", made,
        "--config-settings", f"build-dir={folder / 'build'}", "--config-settings", images, ROOT,
    ])  # fmt: skip
    (wheel,) = made.glob("*.whl")
    return wheel


def call(words: list, **options) -> subprocess.CompletedProcess:
    """Run a program; what it says is shown if it fails."""
    done = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, check=False, **options
    )
    if done.returncode:
        finish("wheel", "", [f"{words[0]} failed:\n{done.stdout}{done.stderr}"])
    return done


def environment(folder: Path, wheel: Path) -> Path:
    """Make an environment with the wheel and what it needs; return its folder of programs."""
    place = folder / "venv"
    shutil.rmtree(place, ignore_errors=True)
    call([sys.executable, "-m", "venv", "--without-pip", place])
    python = place / "bin" / "python"
    call([
        sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--python", python,
        "install", "--no-deps", "--no-index", wheel,
    ])  # fmt: skip
    (site,) = place.glob("lib/python*/site-packages")
    (metadata,) = site.glob("pixstep-*.dist-info/METADATA")
    for name in needed(re.findall(r"^Requires-Dist: ([\w-]+)", metadata.read_text(), re.MULTILINE)):
        link(name, site)
    return python.parent


def needed(names: list[str]) -> set[str]:
    """Return the distributions of some names and of all that they need in turn."""
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name.lower() not in found:
            found.add(name.lower())
            for text in distribution(name).requires or ():
                if ";" not in text:
                    waiting.append(re.match(r"[\w.-]+", text).group())
    return found


def link(name: str, site: Path) -> None:
    """Put a distribution that this Python has into another's folder of packages."""
    dist = distribution(name)
    for part in {file.parts[0] for file in dist.files or ()} - {"..", "__pycache__"}:
        if not (site / part).exists():
            whole = Path(dist.locate_file(part)).resolve()
            (site / part).symlink_to(whole)
            if whole.is_dir():
                share_byte_code(whole, site / part)


def share_byte_code(package: Path, linked: Path) -> None:
    """Keep a linked package's byte code with the package's own: it takes ten seconds to compile."""
    for name in BYTE_CODE:
        if name in os.environ:
            own, other = (
                Path(os.environ[name], *path.absolute().parts[1:]) for path in (package, linked)
            )
            own.mkdir(parents=True, exist_ok=True)
            if not other.exists():
                other.parent.mkdir(parents=True, exist_ok=True)
                other.symlink_to(own)


def run(
    programs: Path, home: Path, words: tuple[str, ...], program: str = "pixstep", **more: str
) -> str:
    """Run a command with an environment of its own; return what it did, empty if that is fine."""
    own = {"PATH": str(programs), "HOME": str(home), "LANG": "C.UTF-8", **more}
    own |= {name: os.environ[name] for name in BYTE_CODE if name in os.environ}
    done = subprocess.run(
        [program, *words], env=own, cwd=home, capture_output=True, text=True, check=False,
        executable=programs / program,
    )  # fmt: skip
    if done.returncode == 0:
        return ""
    return f"{program} {' '.join(words)}: exit status {done.returncode}: {done.stdout}{done.stderr}"


def wrong_files(wheel: Path) -> list[str]:
    """Return what a wheel has too many or too few."""
    names = zipfile.ZipFile(wheel).namelist()
    boards = [path.stem for path in (ROOT / "firmware" / "hal" / "boards").glob("*.def")]
    wanted = [f"pixstep/_built/pixstep-{board}.hex" for board in boards]
    wanted += ["pixstep/_built/tables.json", "pixstep/_built/_core.abi3.so"]
    wanted.append("pixstep/py.typed")
    found = [f"the wheel lacks {name}" for name in wanted if name not in names]
    tops = {name.split("/")[0] for name in names} - {"pixstep"}
    return found + [f"the wheel has {top}" for top in tops if not top.endswith(".dist-info")]


def simulates(programs: Path, home: Path) -> list[str]:
    """Return what is wrong with simulations, without and with the simulator."""
    text = run(programs, home, SIMULATE)
    found = []
    if "exit status 2" not in text or "pixstep-sim" not in text or text.count("\n") != 1:
        found.append(f"without the simulator: {text or 'nothing said'}")
    simulator = ROOT / "build" / "host" / "bin" / "pixstep-sim"
    by_path = os.pathsep.join((str(programs), str(simulator.parent)))
    for more in ({"PIXSTEP_SIM": str(simulator)}, {"PATH": by_path}):
        if text := run(programs, home, SIMULATE, **more):
            found.append(text)
    example = (str(ROOT / "docs" / "examples" / "own_profile.py"),)
    if text := run(programs, home, example, "python", PIXSTEP_SIM=str(simulator)):
        found.append(text)
    return found


def main() -> None:
    """Build, install, run."""
    folder = Path(sys.argv[1]).resolve()
    wheel = build(folder)
    found = wrong_files(wheel)
    programs = environment(folder, wheel)
    home = folder / "home"
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    shutil.copy(ROOT / "tools" / "data" / PROFILE, home)
    for words in COMMANDS:
        if text := run(programs, home, words):
            found.append(text)
    found += simulates(programs, home)
    finish("wheel", f"{wheel.name}, {len(COMMANDS) + 4} commands", found)


if __name__ == "__main__":
    main()
