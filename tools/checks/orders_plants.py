# SPDX-License-Identifier: MIT
"""The state machine of tools/dev/tests/test_orders.py finds what is planted in the Uno's image.

    orders_plants.py [PLANT...]

Each defect below is planted in copies of its sources, which are compiled and linked with the rest
of a finished build of the image; then the machine runs until a rule is broken. Not part of
tools/check: some minutes. `cmake --build BUILD --target orders_plants` runs it.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import explore_plants
from common import ROOT, finish
from explore_plants import AXES, Change, Plant
from planting import compile_words, link_words, swapped

BUILD = ROOT / "build" / "uno"
IMAGE = "firmware/pixstep-uno.elf"
STEP_ISR = "firmware/avr/hal/step_isr.S"
EXAMPLES = 600
FOUND = 9  # exit status

PLACES = ("dev/tests", "tests", "dev", "src")  # where the test and what it needs are
RUN = f"""
import sys
sys.path[:0] = {[str(ROOT / "tools" / place) for place in PLACES]!r}
from hypothesis import Phase, settings
from hypothesis.stateful import run_state_machine_as_test
import test_orders
how = settings(test_orders.FIXED, max_examples={EXAMPLES}, phases=[Phase.generate])
said = []
class Uno(test_orders.Uno):
    def teardown(self):
        said.extend(self.guard.complaints[:1])
        super().teardown()
        said.extend(self.guard.complaints[:1])
try:
    run_state_machine_as_test(Uno, settings=how)
except AssertionError:
    print(said[0])
    sys.exit({FOUND})
"""

# Those of the explorer that can be seen from outside (an emergency stop that leaves PERMIT and the
# axes to the main loop cannot: both come within the stated bound), and what needs the assembly.
SHARED = (
    "settle while the timer holds a step",
    "permit set before the emergency stop is looked at",
    "a halt that does not cut a pulse train",
    "a stop that leaves permit on",
    "a refused order that is kept",
    "a settled axis whose interrupt stays off",
)
OWN = (
    Plant(
        "an idle period that leaves the edge's register alone",
        "",
        (
            Change(
                STEP_ISR,
                "    sts \\edge_high, r24\n    sts \\edge_low, r24\n",
                "",
            ),
        ),
    ),
    Plant(
        "a discard that forgets the timer",
        "",
        (
            Change(
                AXES,
                "    }\n    step_timer_halt(i);\n}",
                "    }\n}",
            ),
        ),
    ),
)


def plants() -> list[Plant]:
    """Return all plants."""
    return [one for one in explore_plants.PLANTS if one.about in SHARED] + list(OWN)


def write_changed(defect: Plant, folder: Path) -> list[Path]:
    """Write the changed files; return the sources to compile."""
    if any(change.file == STEP_ISR for change in defect.changes):
        (change,) = defect.changes
        text = (ROOT / change.file).read_text(encoding="utf-8")
        target = folder / change.file
        target.parent.mkdir(parents=True)
        changed = swapped(text, change.right, change.wrong, change.file)
        target.write_text(changed, encoding="utf-8")
        return [target]
    return [Path(name) for name in explore_plants.plant(defect, folder)]


def compile_changed(sources: list[Path], folder: Path) -> dict[str, Path]:
    """Compile the sources; return each one's object by the name of the object it replaces."""
    made = {}
    for number, source in enumerate(sources):
        relative = source.relative_to(folder if folder in source.parents else ROOT)
        words = compile_words(BUILD, ROOT / relative, IMAGE)
        built, replaced = folder / f"{number}.obj", words[words.index("-o") + 1]
        words[words.index("-o") + 1] = str(built)
        words[-1] = str(source)
        words[1:1] = [f"-I{folder / 'firmware'}", f"-I{folder / 'firmware' / 'core'}"]
        subprocess.run(words, cwd=BUILD, check=True)
        made[replaced] = built
    return made


def link(made: dict[str, Path], image: Path) -> None:
    """Link the image with the objects; those of an archive's members stand before the archives."""
    words = [str(made.pop(word, word)) for word in link_words(BUILD, IMAGE)]
    words[words.index(IMAGE)] = str(image)
    words = [word for word in words if not word.startswith("-Wl,-Map")]
    first = words.index("-o")
    subprocess.run(
        [*words[:first], *map(str, made.values()), *words[first:]], cwd=BUILD, check=True
    )


def link_all(kept: Path, made: Path, but: str) -> None:
    """Make `made` a folder of links to what is in `kept`, but for one name."""
    made.mkdir()
    for entry in kept.iterdir():
        if entry.name != but:
            (made / entry.name).symlink_to(entry)


def root_with(image: Path, folder: Path) -> Path:
    """Return a clone's root whose Uno image is this one."""
    root = folder / "root"
    link_all(ROOT, root, "build")
    link_all(ROOT / "build", root / "build", "uno")
    link_all(BUILD, root / "build" / "uno", "firmware")
    link_all(BUILD / "firmware", root / "build" / "uno" / "firmware", Path(IMAGE).name)
    (root / "build" / "uno" / IMAGE).symlink_to(image)
    return root


def find(defect: Plant) -> str:
    """Return the first broken rule; nothing when the machine finds none."""
    with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
        folder = Path(name)
        image = folder / "planted.elf"
        link(compile_changed(write_changed(defect, folder), folder), image)
        done = subprocess.run(
            [sys.executable, "-c", RUN],
            env=os.environ | {"PIXSTEP_ROOT": str(root_with(image, folder))},
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode not in (0, FOUND):
        raise ValueError(f"{defect.about}: the machine ended otherwise: {done.stderr[-800:]}")
    return done.stdout.strip()


def main() -> None:
    """Plant each defect, or those named."""
    chosen = sys.argv[1:]
    missed = []
    defects = [one for one in plants() if not chosen or one.about in chosen]
    for defect in defects:
        found = find(defect)
        print(f"{defect.about}: {found or 'NOT FOUND'}", flush=True)
        if not found:
            missed.append(f"{defect.about}: not found")
    finish("orders_plants", f"{len(defects)} defects planted", missed)


if __name__ == "__main__":
    main()
