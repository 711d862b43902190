# SPDX-License-Identifier: MIT
"""pixstep-explore finds what is planted: each defect below, under the name of the rule it breaks.

    explore_plants.py COMPILER WORDS SEARCH FIRMWARE [PLANT...]

WORDS is a file of compiler options, SEARCH and FIRMWARE the libraries of the explorer and of the
firmware under it. A defect is planted in copies of the files that hold it; the sources named with
it are compiled again and linked before the rest.
"""

import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from common import ROOT, finish
from planting import swapped

ENGINE = "firmware/core/ring/step_engine.c"
ENGINE_H = "firmware/core/ring/step_engine.h"
TIMER = "firmware/avr/hal/step_timer.c"
ESTOP = "firmware/avr/hal/estop.c"
AXES = "firmware/app/axes/axes.c"
ASSEMBLY = "host_tests/explore/step_isr.c"

RUNAWAY = "runaway"
POSITION = "the position is not the edges made"
PERMIT = "permit is high"
REFUSED = "a refused command changed something"
UNHEARD = "the emergency stop went unheard"
STUCK = "the axis cannot be used again"


# The lines of a macro are one before anything is looked for.
_CONTINUED = re.compile(r"\s*\\\n\s*")


@dataclass(frozen=True)
class Change:
    """In `file`, `right` becomes `wrong`."""

    file: str
    right: str
    wrong: str


SINGLE = ("--actions", "1", "--pins", "1", "--from")

# What the tests explore, explore.pins and explore.periods run, from the situation in which a
# defect is found.
WIDE = ("--actions", "3", "--periods", "1", "--from")
PINS = ("--actions", "1", "--periods", "1", "--pins", "1", "--from")
PERIODS = ("--actions", "1", "--periods", "2", "--from")


@dataclass(frozen=True)
class Plant:
    """A defect: what it is, how it is reported, and where it is."""

    about: str
    rule: str
    changes: tuple[Change, ...]
    compiled: tuple[str, ...] = ()  # sources that include a changed header
    limits: tuple[str, ...] = ()  # of the search; empty: those of explore.long


PLANTS = (
    Plant(
        "settle while the timer holds a step",
        RUNAWAY,
        (
            Change(
                ENGINE,
                "if (step_engine_going((enum step_engine_state)engine->state)) {",
                "if (false) {",
            ),
            Change(AXES, "if (!step_engine_going(step_timer_state(i))) {", "if (true) {"),
        ),
        limits=(*WIDE, "before the first step"),
    ),
    Plant(
        "permit set before the emergency stop is looked at",
        PERMIT,
        (
            Change(
                ESTOP,
                "        if (!is_latched) {\n            pins_write_permit(true);\n"
                "        }\n    }",
                "    }\n    pins_write_permit(true);\n    if (is_latched) {\n"
                "        pins_write_permit(false);\n    }",
            ),
        ),
        limits=(*PINS, "empty"),
    ),
    Plant(
        "a halt that does not cut a pulse train",
        POSITION,
        (Change(ENGINE_H, "engine->cut = left;\n        engine->left = 0;", ""),),
        (TIMER,),
        limits=(*WIDE, "inside a run"),
    ),
    Plant(
        "a halt inside a command that does not give way",
        RUNAWAY,
        (Change(ASSEMBLY, "STEP_ENGINE_HALTING;\n        give_way();", "STEP_ENGINE_HALTING;"),),
        limits=(*SINGLE, "before the first step", "--periods", "3"),
    ),
    Plant(
        "a stale compare flag that loads an idle period too early",
        POSITION,
        (
            Change(
                TIMER,
                "_BV(TOV##timer)) == 0) { TIFR##timer = (uint8_t)_BV(OCF##timer##A);",
                "_BV(TOV##timer)) == 0) { TIFR##timer = 0;",
            ),
        ),
        limits=(*WIDE, "single periods"),
    ),
    Plant(
        "idle periods that leave the edge's register alone",
        RUNAWAY,
        (
            Change(
                ASSEMBLY,
                "    (void)axis;\n    OCR1BH = 0xFF;\n    OCR1BL = 0xFF;\n",
                "    (void)axis;\n",
            ),
        ),
        limits=(*WIDE, "before the first step"),
    ),
    Plant(
        "a command that does not see a halt",
        RUNAWAY,
        (
            Change(
                ENGINE_H,
                "step_engine_halt_soon(struct step_engine *engine)\n{\n    engine->stop = true;",
                "step_engine_halt_soon(struct step_engine *engine)\n{\n    (void)engine;",
            ),
        ),
        (TIMER,),
        limits=(*SINGLE, "before the first step", "--periods", "3"),
    ),
    Plant(
        "an emergency stop that leaves permit on",
        PERMIT,
        (Change(ESTOP, "    pins_write_permit(false);\n    is_latched", "    is_latched"),),
        limits=(*WIDE, "empty"),
    ),
    Plant(
        "a stop that leaves permit on",
        PERMIT,
        (
            Change(
                "firmware/app/registers/commands.c",
                "    permit_set(false);\n    if (state_of(i) != AXIS_FAULT) {",
                "    if (state_of(i) != AXIS_FAULT) {",
            ),
        ),
        limits=(*WIDE, "empty"),
    ),
    Plant(
        "an emergency stop that the main loop does not look for",
        UNHEARD,
        (Change("firmware/app/watch/safety.c", "    if (estop_latched()) {", "    if (false) {"),),
        limits=(*WIDE, "empty"),
    ),
    Plant(
        "a refused order that is kept",
        REFUSED,
        (
            Change(
                "firmware/app/registers/commands.c",
                "        return false;\n    }\n    commands_act(order);\n    last_order = *order;",
                "        last_order = *order;\n        return false;\n    }\n"
                "    commands_act(order);\n    last_order = *order;",
            ),
        ),
        limits=(*WIDE, "empty"),
    ),
    Plant(
        "a settled axis whose interrupt stays off",
        STUCK,
        (Change(TIMER, "            resume_axis(axis);", ""),),
        limits=(*WIDE, "empty"),
    ),
    Plant(
        "a late interrupt that forgets the rest of its pulse train",
        POSITION,
        (
            Change(
                TIMER,
                "GIVE_WAY(timer); step_engine_halt(&step_engines[axis]); late_axes",
                "GIVE_WAY(timer); step_engines[axis].state = STEP_ENGINE_HALTING; late_axes",
            ),
        ),
        limits=(*PERIODS, "inside a fast run"),
    ),
    Plant(
        "a sentinel written behind its entry",
        POSITION,
        (
            Change(
                "firmware/core/stream/stream.h",
                "    ring->high[next] = STEP_HIGH_EMPTY;\n    ring->low[slot] = (uint8_t)top;\n"
                "    ring->high[slot] = (uint8_t)(top >> 8);",
                "    ring->low[slot] = (uint8_t)top;\n"
                "    ring->high[slot] = (uint8_t)(top >> 8);\n"
                "    ring->high[next] = STEP_HIGH_EMPTY;",
            ),
        ),
        ("firmware/core/stream/stream.c", "firmware/core/axis/decode.c"),
        limits=("--actions", "2", "--periods", "2", "--from", "about to starve"),
    ),
)


def plant(defect: Plant, folder: Path) -> list[str]:
    """Write the changed files; return the sources to compile again."""
    sources = [str(ROOT / name) for name in defect.compiled]
    for change in defect.changes:
        target = folder / change.file
        kept = target if target.is_file() else ROOT / change.file
        text = _CONTINUED.sub(" ", kept.read_text(encoding="utf-8"))
        target.parent.mkdir(parents=True, exist_ok=True)
        changed = swapped(text, change.right, change.wrong, change.file)
        target.write_text(changed, encoding="utf-8")
        if target.suffix == ".c":
            sources.append(str(target))
    return sources


def build(defect: Plant, folder: Path, compiler: str, words: str, libraries: list[str]) -> Path:
    """Build the explorer with a defect, in a folder of its own."""
    before = [f"-I{folder / part}" for part in ("firmware", "firmware/core")]
    objects = []
    for source in plant(defect, folder):
        objects.append(str(folder / f"{len(objects)}.o"))
        command = [compiler, *before, f"@{words}", "-c", source, "-o", objects[-1]]
        subprocess.run(command, check=True)
    program = folder / "explore"
    group = ["-Wl,--start-group", *libraries, "-Wl,--end-group"]
    subprocess.run([compiler, *objects, *group, "-no-pie", "-o", str(program)], check=True)
    return program


def explore(defect: Plant, compiler: str, words: str, libraries: list[str]) -> str:
    """Run the explorer with a defect; return what was found first."""
    with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
        program = build(defect, Path(name), compiler, words, libraries)
        done = subprocess.run(
            [program, "--first", *defect.limits], capture_output=True, text=True, check=False
        )
        found = re.search(r"^broken: (.*)$", done.stdout, re.MULTILINE)
        return found[1] if found and done.returncode == 1 else ""


def main(plants: tuple[Plant, ...], check: str) -> None:
    """Plant each defect, or those named."""
    compiler, words, search, firmware, *chosen = sys.argv[1:]
    problems = []
    defects = [defect for defect in plants if not chosen or defect.about in chosen]
    for defect in defects:
        found = explore(defect, compiler, words, [search, firmware])
        print(f"{defect.about}: {found or 'not found'}", flush=True)
        if not found.startswith(defect.rule) or not found:
            problems.append(f"{defect.about}: {defect.rule!r} is expected")
    finish(check, f"{len(defects)} defects planted", problems)


if __name__ == "__main__":
    main(PLANTS, "explore.plants")
