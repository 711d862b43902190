# SPDX-License-Identifier: MIT
"""A wheel of the Python package, installed into an empty environment, works without the clone.

    wheel.py FOLDER

Builds the wheel with the images of this clone, makes an environment in FOLDER that has the wheel
and what it declares to need and nothing else, and runs commands there in an empty folder, with a
PATH that has only the environment. What needs the simulator or an extra says so in one line, and
runs when the simulator is named and the extras are there.
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
    ("machine", "new", "--board", "mega", "--pixel-hz", "30", "--motor", "X:plain", "-o", "x.toml"),
    ("machine", "check", "x.toml"),
    ("limits", "--board", "mega", "--pixel-hz", "200"),
    ("ticks", *LINE, "-o", "ticks.csv"),
    ("flash", "--board", "uno", "--port", "/dev/null", "--dry-run"),
    ("board", "--help"),
    ("board", "set", "--help"),
)  # fmt: skip
EXTRAS = ("numpy", "matplotlib")
# What needs something more, and what its one line names.
LACKING = (
    (("line", "show", *LINE, "--plot", "line.png"), "pixstep[plot]"),
    (("trajectory", "circle", "--radius", "3200", "-o", "circle.trj"), "pixstep[numpy]"),
)
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
    site = packages(python.parent)
    (metadata,) = site.glob("pixstep-*.dist-info/METADATA")
    always = re.findall(r"^Requires-Dist: ([\w-]+)[^;\n]*$", metadata.read_text(), re.MULTILINE)
    for name in needed(always):
        link(name, site)
    return python.parent


def packages(programs: Path) -> Path:
    """Return an environment's folder of packages."""
    (site,) = programs.parent.glob("lib/python*/site-packages")
    return site


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
    boards = [path.stem for path in (ROOT / "firmware" / "avr" / "boards").glob("*.def")]
    wanted = [f"pixstep/_built/pixstep-{board}.hex" for board in boards]
    wanted += ["pixstep/_built/tables.json", "pixstep/_built/_core.abi3.so"]
    wanted.append("pixstep/py.typed")
    found = [f"the wheel lacks {name}" for name in wanted if name not in names]
    tops = {name.split("/")[0] for name in names} - {"pixstep"}
    return found + [f"the wheel has {top}" for top in tops if not top.endswith(".dist-info")]


def lacks(text: str, name: str) -> list[str]:
    """Return what is wrong with the words of a command that lacks something."""
    fine = "exit status 2" in text and name in text and text.count("\n") == 1
    return [] if fine else [f"without {name}: {text or 'nothing said'}"]


def simulates(programs: Path, home: Path) -> list[str]:
    """Return what is wrong with simulations: without the simulator, without numpy, with both."""
    simulator = ROOT / "build" / "host" / "bin" / "pixstep-sim"
    found = lacks(run(programs, home, SIMULATE), "pixstep-sim")
    found += lacks(run(programs, home, ("demo",)), "pixstep-sim")
    found += lacks(run(programs, home, SIMULATE, PIXSTEP_SIM=str(simulator)), "pixstep[numpy]")
    for name in needed([*EXTRAS]):
        link(name, packages(programs))
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
    for words, name in LACKING:
        found += lacks(run(programs, home, words), name)
    found += simulates(programs, home)
    finish("wheel", f"{wheel.name}, {len(COMMANDS) + len(LACKING) + 6} commands", found)


if __name__ == "__main__":
    main()
