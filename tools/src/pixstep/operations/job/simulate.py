# SPDX-License-Identifier: MIT
"""Simulate a job as a whole, before the glass."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from pixstep import signals
from pixstep.errors import FINE, NEGATIVE, AskedText, PlainError
from pixstep.lazy import require_package
from pixstep.operations import shared
from pixstep.operations.bus import StoppedError
from pixstep.operations.clocks import FlawFields
from pixstep.operations.desk import Desk
from pixstep.operations.job.reading import job_file, read
from pixstep.operations.kinds import FOLDER, PATH, TEXT, Whole
from pixstep.operations.request import operation, option
from pixstep.operations.result import Page, Result

if TYPE_CHECKING:
    from pixstep.jobs.job import Job
    from pixstep.jobs.simulated.campaign import Campaign
    from pixstep.jobs.simulated.crews import Crew
    from pixstep.jobs.simulated.folder import SimFolder, Told

_MOST_PROCESSES, _MOST_LINES = 1024, 1000
_REMOTE_EDGES = Path("~/.cache/pixstep/edges")


class FailedLine(TypedDict):
    """A motor in a line that is not as it has to be, and why."""

    line: int
    motor: str
    reason: str


class SimulatedJob(TypedDict):
    """A job that was simulated: `verdict` is pass, or fail with the first lines that fail.

    Of `blocks`, `different` ones, `simulated` were simulated now and `known` before; `repeated`
    had a process that died. `hosts` are the different blocks by who simulated them; `sha256` is the
    sum of all lines' sums. `worst` has the largest error of each kind, without its sign, by the
    name of its column in `lines_file`, which has a row a motor and line.
    """

    job: str
    id: str
    verdict: str
    lines: int
    failed: int
    failures: list[FailedLine]
    steps: int
    worst: dict[str, float]
    blocks: int
    different: int
    simulated: int
    known: int
    repeated: int
    hosts: dict[str, int]
    seconds: float
    sha256: str
    out: str
    lines_file: str


@operation("job simulate")
class JobSimulate(FlawFields):
    """Simulate a whole job: every board, motor and line, cycle by cycle, on all cores.

    The job's own machine is simulated, with its boards on one clock and each motor's play. Lines
    run in blocks, as the boards chain them, each after the line before it, so that seams are real
    ones. Each line's edges, zero, positions and load are judged. Blocks that are finished are not
    simulated again: after an interruption, or a change of some lines, the same command goes on.
    Exit status 0 if all lines are as they have to be, 1 if one is not.
    """

    result = SimulatedJob

    job: Path = job_file()
    out: Path | None = option(
        FOLDER, "Folder of the simulation.", shown="NAME.pxsim", default_text="the job's name"
    )
    processes: int | None = option(
        Whole(1, _MOST_PROCESSES), "Processes of this computer.", default_text="one a core"
    )
    scheduler: str | None = option(
        TEXT, "Let the workers of a Dask cluster simulate: the address of its scheduler.",
        shown="ADDRESS",
    )  # fmt: skip
    edges: Path | None = option(
        PATH, "Folder for the edges, on the computer that simulates them.",
        default_text=f"edges in the simulation's folder; on a cluster {_REMOTE_EDGES}",
    )  # fmt: skip
    block: int = option(Whole(1, _MOST_LINES), "Lines of a block, at most.", default=32)
    seed: int = shared.seed()

    def run(self, desk: Desk) -> Result:
        """Simulate what is not finished, then put all rows together."""
        require_package("numpy")
        if self.scheduler is not None:
            require_package("distributed")
        found = read(self.job)
        from pixstep.jobs.simulated import cuts
        from pixstep.jobs.simulated.campaign import Campaign
        from pixstep.jobs.simulated.folder import SUFFIX, SimFolder

        began = time.monotonic()
        world = cuts.SimulatedWorld(self.pixel_ppm, self.flaws, self.seed, self.block)
        cuts.refuse(found, world)
        own = cuts.tools_of(found, world)
        edges = self.edges or (None if self.scheduler is None else _REMOTE_EDGES)
        folder = SimFolder(self.out or Path(self.job.name).with_suffix(SUFFIX), edges)
        about = {"job": str(self.job), "id": found.header.id, "tools": dict(own)}
        with signals.once(), desk.progress("simulating") as show:
            campaign = Campaign(found, world, own, folder, show)
            missing = campaign.missing()
            if missing:
                with _swept(folder), self._crew(campaign, found) as crew:
                    folder.begin(about)
                    with _told_on_stop(campaign):
                        campaign.run(crew, missing)
            told = folder.assemble(found, campaign.cuts())
        data = self._data(found, campaign, told, time.monotonic() - began)
        folder.write_about({**about, **data})
        status = NEGATIVE if told.failed else FINE
        return Result(data, partial(_write, data), status)

    def _crew(self, campaign: Campaign, job: Job) -> contextlib.AbstractContextManager[Crew]:
        from pixstep.jobs.simulated import crews
        from pixstep.jobs.simulated.cuts import MotorPlaces

        if self.scheduler is not None:
            return crews.cluster(self.scheduler, campaign.tools, MotorPlaces.of(job).kinds)
        return crews.processes(self.processes or len(os.sched_getaffinity(0)))

    def _data(self, job: Job, campaign: Campaign, told: Told, seconds: float) -> SimulatedJob:
        counts = campaign.counts
        return {
            "job": str(self.job), "id": job.header.id, "verdict": "fail" if told.failed else "pass",
            "lines": job.lines, "failed": told.failed,
            "failures": [
                {"line": row["line"], "motor": row["motor"], "reason": row["reason"]}
                for row in told.first_failed
            ],
            "steps": told.steps, "worst": told.worst,
            "blocks": counts.blocks, "different": counts.different, "simulated": counts.simulated,
            "known": counts.known, "repeated": counts.repeated, "hosts": dict(told.hosts),
            "seconds": round(seconds, 1), "sha256": told.sha256,
            "out": str(campaign.folder.path), "lines_file": str(campaign.folder.lines),
        }  # fmt: skip


@contextlib.contextmanager
def _swept(folder: SimFolder) -> Iterator[None]:
    """Leave no unfinished edges, once those who made them are gone."""
    try:
        yield
    finally:
        folder.sweep()


@contextlib.contextmanager
def _told_on_stop(campaign: Campaign) -> Iterator[None]:
    """Say what is finished when a signal, or a lost cluster, ends the simulation."""
    try:
        yield
    except KeyboardInterrupt as error:
        raise StoppedError(
            f"stopped by {signals.name(error)}: {_finished(campaign)}", signals.status(error)
        ) from None
    except PlainError as error:
        finished = _finished(campaign)
        error.args = (AskedText("{error} ({finished})", error=error.args[0], finished=finished),)
        raise


def _finished(campaign: Campaign) -> str:
    counts = campaign.counts
    return (
        f"{counts.known + counts.simulated} of {counts.different} blocks are finished, the same "
        f"command goes on with the others"
    )


def _write(data: SimulatedJob, page: Page) -> None:
    """Write the page."""
    for row in data["failures"]:
        page.tell(f"line {row['line']}, motor {row['motor']}: {row['reason']}")
    if data["failed"] > len({row["line"] for row in data["failures"]}):
        page.tell("and more lines")
    page.tell(
        f"{data['blocks']} blocks, {data['different']} different: {data['simulated']} simulated, "
        f"{data['known']} known from before; {data['steps']} steps in {data['seconds']:.1f} s"
    )
    worst = data["worst"]
    told = [text.format(worst[name]) for name, text in _TEXTS.items() if name in worst]
    if told:
        page.tell(f"at most {', '.join(told)}")
    page.tell(f"rows of all lines: {data['lines_file']}")
    good = data["lines"] - data["failed"]
    page.tell(page.styled(
        f"{data['out']}: {data['verdict']}: {good} of {data['lines']} lines are as they have to be",
        bold=True,
    ))  # fmt: skip


_TEXTS = {
    "edge_error_ticks": "steps {:.2f} ticks off their instants",
    "clock_error_ticks": "pixel edges {:.1f} ticks off the clock's",
    "apart_ticks": "motors {:g} ticks apart",
    "late_ticks": "seams {:g} ticks late",
    "load_error_steps": "loads {} steps off",
}
