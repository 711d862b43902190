# SPDX-License-Identifier: MIT
"""Both wheels, built by `pixstep-dev wheels` and installed by pip alone, do the demo.

    wheels.py FOLDER

What the wheels need comes from the package index that pip is configured for. The environment is
empty, its PATH has neither compiler nor this clone. First the package by itself, then the
simulator, then the drawings; prints the sizes and times of each.
"""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from common import ROOT, finish
from wheel import call, packages, run

MOST_MB = 60  # of the package by itself and all that it needs
MOST_S = 0.15  # of processor time, until a name of the interface is there
# Each step of the installation: what pip is asked for, by the names of the wheels.
PACKAGE, SIMULATOR, DRAWINGS = ("pixstep",), ("pixstep_sim", "pixstep"), ("pixstep[plot]",)
NAMES = """
import subprocess, sys
import pixstep
CODE = "import time; began = time.process_time(); import pixstep; pixstep.{}; " \\
    "print(time.process_time() - began)"
def seconds(name):
    words = [sys.executable, "-c", CODE.format(name)]
    return float(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
print(max((min(seconds(name) for _ in range(3)), name) for name in pixstep.__all__))
"""


def environment(folder: Path) -> Path:
    """Make an environment without pip; return its folder of programs."""
    place = folder / "venv"
    shutil.rmtree(place, ignore_errors=True)
    call([sys.executable, "-m", "venv", "--without-pip", place])
    return place / "bin"


def install(programs: Path, wheels: Path, names: tuple[str, ...]) -> float:
    """Install wheels by name with what they need; return how many seconds it took."""
    began = time.monotonic()
    call([
        sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--python",
        programs / "python", "install", "--find-links", wheels, *names,
    ])  # fmt: skip
    return time.monotonic() - began


def megabytes(folder: Path) -> float:
    """Return the room that a folder takes, as du counts it."""
    return int(call(["du", "-sk", folder]).stdout.split()[0]) / 1024


def step(programs: Path, wheels: Path, names: tuple[str, ...]) -> float:
    """Install, compile and print what it took; return the size."""
    seconds = install(programs, wheels, names)
    size = megabytes(packages(programs))
    print(f"pip install {' '.join(names)}: {size:.0f} MB in site-packages, {seconds:.1f} s")
    return size


def demonstrate(programs: Path, home: Path, out: str, drawn: bool) -> list[str]:
    """Run the demo in an empty folder; return what is wrong."""
    began = time.monotonic()
    if text := run(programs, home, ("demo", "--out", out)):
        return [text]
    print(f"pixstep demo: {time.monotonic() - began:.1f} s")
    summary = json.loads((home / out / "summary.json").read_text())
    found = [] if summary["verdict"] == "pass" else [f"the demo: {summary['verdict']}"]
    if (home / out / "motion.png").is_file() != drawn:
        found.append(f"{out}: drawings: {not drawn}")
    return found


def slow_names(programs: Path, home: Path) -> list[str]:
    """Return the slowest name of the interface if it takes too long."""
    own = {"PATH": str(programs), "HOME": str(home), "LANG": "C.UTF-8"}
    words = [programs / "python", "-c", NAMES]
    done = subprocess.run(words, env=own, cwd=home, capture_output=True, text=True, check=False)
    if done.returncode:
        return [done.stderr]
    print(f"slowest name of the interface (s of processor time, name): {done.stdout.strip()}")
    seconds = float(done.stdout.strip("(").partition(",")[0])
    return [] if seconds < MOST_S else [f"a name takes {seconds:.3f} s, not {MOST_S} s"]


def main() -> None:
    """Build, install, run."""
    folder = Path(sys.argv[1]).resolve()
    wheels, home = folder / "dist", folder / "home"
    for one in (wheels, home):
        shutil.rmtree(one, ignore_errors=True)
        one.mkdir(parents=True)
    for name in [*os.environ]:
        if name.startswith("PIXSTEP_"):
            del os.environ[name]
    print(call([ROOT / "tools" / "pixstep-dev", "wheels", "--out", wheels]).stdout, end="")
    programs = environment(folder)
    found = []
    if (size := step(programs, wheels, PACKAGE)) > MOST_MB:
        found.append(f"the package takes {size:.0f} MB, not {MOST_MB} MB")
    text = run(programs, home, ("demo",))
    if "exit status 2" not in text or "pixstep-sim" not in text:
        found.append(f"without the simulator: {text or 'nothing said'}")
    found += slow_names(programs, home)
    step(programs, wheels, SIMULATOR)
    found += demonstrate(programs, home, "plain", drawn=False)
    found += [text] if (text := run(programs, home, ("--help",), "pixstep-sim")) else []
    step(programs, wheels, DRAWINGS)
    found += demonstrate(programs, home, "drawn", drawn=True)
    finish("wheels", "both wheels, installed in three steps", found)


if __name__ == "__main__":
    main()
