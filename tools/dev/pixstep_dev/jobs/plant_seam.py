# SPDX-License-Identifier: MIT
"""Faults planted at seams: blocks of chained lines find them, lines simulated alone do not.

A wrong take-up is planted in the job: a line is made as if its motor came from the other side, so
it takes no play up, or takes it up twice; the job says so, and says the positions that follow.
Alone such a line is as its job has it. A lost part of a tick is planted in the firmware of a board:
a chained line begins its grid anew, on the tick before. Alone a line begins on a whole tick anyway.
"""

from __future__ import annotations

import random
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path

from pixstep import natives
from pixstep.errors import UserError
from pixstep.jobs import job as jobs
from pixstep.jobs.job import Job
from pixstep.jobs.shapes import MINUS, PLUS, Shape
from pixstep.jobs.simulated import crews, cuts
from pixstep.jobs.simulated.campaign import Campaign
from pixstep.jobs.simulated.crews import Crew
from pixstep.jobs.simulated.cuts import SimulatedWorld
from pixstep.jobs.simulated.folder import SimFolder
from pixstep.progress import Progress, unseen
from pixstep_dev.jobs.press import Press
from pixstep_dev.mutants.programs import Build, Workshop

_HZ = Fraction(110)  # a pixel is no whole number of ticks
_MOTOR, _BOARD = "M39", "mega"
_AXIS = "axis.c"  # in the firmware's core, wherever its rooms are
# A chained line's grid: whatever keeps it, only a locked one is kept.
_KEEPS = re.compile(r"(BEFORE_ALL : BEFORE_UNKNOWN\);\n).*?(        return;\n)", re.DOTALL)
_LOSES = r"""\1        if (line_grid_locked(&edges)) {
            axis->line.edges = edges;
        }
\2"""
NONE_TAKEN, TAKEN_TWICE, LOST_PART = "no take-up", "take-up twice", "lost part of a tick"


@dataclass(frozen=True)
class PlantSeamPlan:
    """So many faults of a take-up, each in a job of so many lines, and one in the firmware."""

    times: int = 4
    lines: int = 12
    seed: int = 1
    firmware: bool = True


@dataclass
class SeamPlant:
    """A fault, the line after the seam that has it, the lines that fail in blocks and alone."""

    what: str
    line: int
    in_blocks: list[int]
    alone: list[int]
    reason: str


@dataclass
class PlantSeamOutcome:
    """What was planted, and what was found."""

    plants: list[SeamPlant] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)


def run(plan: PlantSeamPlan, show: Progress = unseen) -> PlantSeamOutcome:
    """Plant faults and look for them, in blocks and line by line."""
    outcome, chance = PlantSeamOutcome(), random.Random(plan.seed)
    with tempfile.TemporaryDirectory() as name, crews.processes(2) as crew:
        folder = Path(name)
        fast = press(folder / "take-up", plan.lines, "lock")
        _control(outcome, fast.job, folder, crew)
        for number in range(plan.times):
            what = (NONE_TAKEN, TAKEN_TWICE)[number % 2]
            line = chance.randrange(3, plan.lines)
            planted = wrong_take_up(fast.job, line, what, folder / f"{number}.pxjob")
            look(outcome, what, line, planted, folder / str(number), crew)
            show((number + 1) / (plan.times + 1))
        if plan.firmware:
            slow = press(folder / "part", plan.lines, "start")
            _control(outcome, slow.job, folder, crew)
            lost = {_BOARD: losing_image(folder)}
            look(outcome, LOST_PART, 2, slow.job, folder / "lost", crew, lost)
    return outcome


def press(folder: Path, lines: int, sync: str) -> Press:
    """Return a press on whose pixel clock a pixel is no whole number of ticks."""
    folder.mkdir()
    return Press.make(folder, lines, pixels=8, sync=sync, pixel_hz=_HZ)


def _control(outcome: PlantSeamOutcome, job: Job, folder: Path, crew: Crew) -> None:
    """Require that nothing is found where nothing was planted."""
    failed, why = _failing(job, SimulatedWorld(), folder / f"control-{job.header.id[:8]}", crew)
    if failed:
        outcome.complaints.append(f"nothing was planted, and lines {failed} fail: {why}")


def look(
    outcome: PlantSeamOutcome, what: str, line: int, job: Job, folder: Path, crew: Crew,
    images: Mapping[str, Path] | None = None,
) -> None:  # fmt: skip
    """Look for a fault in blocks and line by line; complain if not just the blocks find it."""
    in_blocks, why = _failing(job, SimulatedWorld(images=images or {}), folder / "blocks", crew)
    alone, _ = _failing(
        job, SimulatedWorld(lines=1, run_in=False, images=images or {}), folder / "alone", crew
    )
    outcome.plants.append(SeamPlant(what, line, in_blocks, alone, why))
    if min(in_blocks, default=0) != line:
        outcome.complaints.append(f"{what} at line {line}: blocks find lines {in_blocks}")
    if alone:
        outcome.complaints.append(f"{what} at line {line}: lines alone find it too: {alone}")


def _failing(job: Job, world: SimulatedWorld, folder: Path, crew: Crew) -> tuple[list[int], str]:
    """Return the lines of a job that fail, and the first reason."""
    campaign = Campaign(job, world, cuts.tools_of(job, world), SimFolder(folder))
    campaign.folder.begin({"job": str(job.path)})
    campaign.run(crew, campaign.missing())
    told = campaign.folder.assemble(job, campaign.cuts())
    lines = sorted({row["line"] for row in told.first_failed})
    return lines, told.first_failed[0]["reason"] if told.first_failed else ""


def wrong_take_up(job: Job, line: int, what: str, path: Path) -> Job:
    """Return a job, read from a file, of which one line is made for the wrong side of the play.

    The line turns round and takes nothing up; or it goes on as the line before and takes play up
    once more, and all lines after it turn round. All positions and sides after it follow.
    """
    runs, shapes = (
        [],
        {key: job.shapes[key] for key in dict.fromkeys(one.shape for one in job.runs)},
    )
    where, turned = 0, False
    for run in job.runs:
        if run.motor != _MOTOR:
            runs.append(run)
            continue
        turned = turned or (what == TAKEN_TWICE and run.line == line)
        made = replace(run, negative=run.negative != turned)
        if run.line >= line:
            # Lines go forth and back, so each says that it comes from the other side.
            made = replace(made, start_steps=where, play_side=_side(negative=not made.negative))
        if what == NONE_TAKEN and run.line == line:
            shape = Shape.of(shapes[run.shape].counts, shapes[run.shape].decode, 0)
            shapes[shape.key] = shape
            made = replace(made, shape=shape.key, play_side=_side(negative=made.negative))
        runs.append(made)
        travel = shapes[made.shape].travel
        where = made.start_steps + (-travel if made.negative else travel)
    header = job.header.model_copy(update={"id": jobs.id_of(runs)})
    Job(header, job.copies, tuple(runs), shapes).write(path)
    return Job.read(path)


def _side(*, negative: bool) -> str:
    return MINUS if negative else PLUS


def losing_image(folder: Path) -> Path:
    """Return an image whose chained lines lose the part of a tick that their grid has."""
    (source,) = (natives.root() / "firmware" / "core").rglob(_AXIS)
    text, changed = _KEEPS.subn(_LOSES, source.read_text(encoding="utf-8"))
    if changed != 1:
        raise UserError(f"{_AXIS}: the place where a chained line's grid is kept is not there once")
    (folder / "workshop").mkdir()
    shop = Workshop(folder / "workshop")
    shop.change(source, text)
    return shop.link(Build(_BOARD).program(f"firmware/pixstep-{_BOARD}.elf"))
