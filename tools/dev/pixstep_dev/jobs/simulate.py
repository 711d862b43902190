# SPDX-License-Identifier: MIT
"""The simulation of a whole job: the same rows, whoever simulates, whatever dies in between.

Lines differ, so that every block is simulated. On one core, on two, by workers of a cluster in
processes of their own; with a worker killed, with a process killed, interrupted and continued. The
client's memory is measured with jobs of equal lines, whose blocks are simulated once: so what grows
with the lines would show.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pyarrow
from pyarrow import parquet

from pixstep import ops
from pixstep.jobs import job as jobs
from pixstep.jobs.job import Job
from pixstep.jobs.shapes import MotorRun, Shape
from pixstep.progress import Progress, unseen
from pixstep_dev.jobs.cluster import Cluster
from pixstep_dev.jobs.press import Press

MOST_BYTES_A_LINE = 2000
MOST_GROWTH = 1.1  # of the client's memory from the smallest job to the largest
_POLL_S = 0.05
_PLACES = ["host", "edges"]  # columns that say who has simulated
_TURNING = "M40"
_CLIENT = """\
import resource, sys
from pixstep import ops
done = ops.job_simulate(sys.argv[1], out=sys.argv[2], processes=1)
usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(usage, done["different"], done["verdict"])
"""


@dataclass(frozen=True)
class JobSimulatePlan:
    """A job of so many lines in blocks, and the lengths of jobs for the client's memory."""

    lines: int = 64
    block: int = 8
    memory_lines: tuple[int, ...] = (100, 1000)
    cluster: bool = True
    seed: int = 1


@dataclass
class Pass:
    """One way to simulate the job: how long, what was simulated, the sum of the rows."""

    name: str
    seconds: float
    simulated: int
    known: int
    repeated: int
    sha256: str


@dataclass
class JobSimulateOutcome:
    """All ways; what the client's line to the scheduler has carried; memory by lines, in MB."""

    lines: int
    passes: list[Pass] = field(default_factory=list)
    bytes_a_line: float = 0.0
    memory_mb: dict[int, float] = field(default_factory=dict)
    different: dict[int, int] = field(default_factory=dict)  # blocks of those jobs
    complaints: list[str] = field(default_factory=list)


def run(plan: JobSimulatePlan, show: Progress = unseen) -> JobSimulateOutcome:
    """Simulate a job in every way."""
    with tempfile.TemporaryDirectory() as name:
        campaign = _Campaign(plan, Path(name), JobSimulateOutcome(plan.lines))
        ways = [*campaign.ways()]
        for number, way in enumerate(ways, 1):
            way()
            show(number / len(ways))
        return campaign.outcome


class _Campaign:
    """The ways to simulate a job in a folder."""

    def __init__(self, plan: JobSimulatePlan, folder: Path, outcome: JobSimulateOutcome) -> None:
        self._plan, self._folder, self.outcome = plan, folder, outcome
        self._job = varied(Press.make(folder, plan.lines, pixels=8), folder, plan.seed)
        self._rows: pyarrow.Table | None = None

    def ways(self) -> Iterator[Callable[[], None]]:
        """Yield what there is to do."""
        yield lambda: self._simulate("one core", processes=1)
        yield lambda: self._simulate("two cores", processes=2)
        yield self._interrupted
        if self._plan.cluster:
            yield self._by_cluster
            yield self._worker_killed
        yield self._process_killed
        for lines in self._plan.memory_lines:
            yield lambda lines=lines: self._memory(lines)  # type: ignore[misc]
        yield self._compare_memory

    def _simulate(self, name: str, **more: Any) -> None:
        out = self._folder / name.replace(" ", "-")
        done = ops.job_simulate(
            self._job.path, **{"out": out, "block": self._plan.block, "edges": out / "own", **more}
        )
        self._take(name, done.to_dict())

    def _take(self, name: str, done: dict[str, Any]) -> None:
        """Compare the rows of a way with those of the first one."""
        self.outcome.passes.append(Pass(
            name, done["seconds"], done["simulated"], done["known"], done["repeated"],
            done["sha256"],
        ))  # fmt: skip
        if done["verdict"] != "pass":
            self._complain(f"{name}: {done['failures'][:1]}")
        found = parquet.read_table(done["lines_file"]).drop_columns(_PLACES)
        self._rows = self._rows or found
        if not found.equals(self._rows) or done["sha256"] != self.outcome.passes[0].sha256:
            self._complain(f"{name}: other rows than {self.outcome.passes[0].name}")

    def _complain(self, text: str) -> None:
        self.outcome.complaints.append(text)

    def _by_cluster(self) -> None:
        with self._cluster("cluster").up() as relay:
            self._simulate("a cluster of 2 workers", scheduler=relay.address)
            self.outcome.bytes_a_line = relay.bytes / self._plan.lines
        if self.outcome.bytes_a_line >= MOST_BYTES_A_LINE:
            self._complain(f"{self.outcome.bytes_a_line:.0f} bytes a line went to and fro")

    def _worker_killed(self) -> None:
        """Kill a worker once a block is finished."""
        cluster, name = self._cluster("killed"), "a worker killed"
        with cluster.up() as relay:
            killed = _once_finished(self._folder / name.replace(" ", "-"), 1, cluster.kill, 0)
            self._simulate(name, scheduler=relay.address)
            killed.join()

    def _process_killed(self) -> None:
        """Kill a process of this computer that simulates."""
        name = "a process killed"
        killed = _once_finished(
            self._folder / name.replace(" ", "-"), 1, _kill_child_of, os.getpid()
        )
        self._simulate(name, processes=2)
        killed.join()
        if not self.outcome.passes[-1].repeated:
            self._complain(f"{name}: no block was simulated again")

    def _cluster(self, name: str) -> Cluster:
        folder = self._folder / f"dask-{name}"
        folder.mkdir()
        return Cluster(folder, 2)

    def _interrupted(self) -> None:
        """End it by a signal once two blocks are finished; go on with the same command."""
        name, out = "interrupted and continued", self._folder / "interrupted"
        command = [
            sys.executable, "-m", "pixstep", "job", "simulate", str(self._job.path), "--out",
            str(out), "--block", str(self._plan.block), "--processes", "2", "--edges",
            str(out / "own"), "--json",
        ]  # fmt: skip
        first = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        _once_finished(out, 2, first.send_signal, signal.SIGTERM).join()
        _, told = first.communicate()
        if first.returncode != 128 + signal.SIGTERM or b"the same command goes on" not in told:
            self._complain(f"interrupted: {first.returncode}: {told.decode()}")
        again = subprocess.run(command, capture_output=True, check=False)
        done = json.loads(again.stdout)
        self._take(name, done)
        if done["known"] < 2 or not done["simulated"]:
            self._complain(f"{name}: {done['known']} blocks were known")

    def _memory(self, lines: int) -> None:
        """Measure what the client takes at most for a job of so many equal lines."""
        folder = self._folder / f"memory-{lines}"
        folder.mkdir()
        job = Press.make(folder, lines, pixels=8).job
        done = subprocess.run(
            [sys.executable, "-c", _CLIENT, str(job.path), str(folder / "out")],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode:
            self._complain(f"{lines} lines: {done.stderr.strip()}")
            return
        kilobytes, different, verdict = done.stdout.split()
        self.outcome.memory_mb[lines] = round(int(kilobytes) / 1024, 1)
        self.outcome.different[lines] = int(different)
        if verdict != "pass":
            self._complain(f"{lines} lines: {verdict}")

    def _compare_memory(self) -> None:
        found = [*self.outcome.memory_mb.values()]
        if found and found[-1] > MOST_GROWTH * found[0]:
            self._complain(f"the client's memory grows with the lines: {found} MB")


def varied(press: Press, folder: Path, seed: int) -> Job:
    """Return a job of which no two lines are equal: a motor swings differently in each."""
    chance, shapes, runs = random.Random(seed), {}, []
    for run in press.job.runs:
        shape = press.job.shapes[run.shape]
        if run.motor == _TURNING:
            shape = Shape.of(_swing(chance, run.pixels), shape.decode)
        shapes[shape.key] = shape
        runs.append(replace(run, shape=shape.key))
    runs = [*_sides(runs, shapes)]
    header = press.job.header.model_copy(update={"id": jobs.id_of(runs)})
    path = folder / "varied.pxjob"
    Job(header, press.job.copies, tuple(runs), shapes).write(path)
    return Job.read(path)


def _sides(runs: list[MotorRun], shapes: dict[bytes, Shape]) -> Iterator[MotorRun]:
    """Yield the lines with the sides from which the swinging motor comes."""
    side = ""
    for run in runs:
        if run.motor != _TURNING:
            yield run
            continue
        steps = [count for count in shapes[run.shape].counts if count]
        first = "+" if steps and steps[0] > 0 else "-"
        yield replace(run, play_side=side or first)
        side = ("+" if steps[-1] > 0 else "-") if steps else side


def _swing(chance: random.Random, pixels: int) -> tuple[int, ...]:
    """Return the counts of a motor that goes out and comes back, so far and so early."""
    far, early = 30 + 90 * chance.random(), 0.7 + 0.6 * chance.random()
    places = [
        round(far * math.sin(math.pi * (pixel / pixels) ** early) ** 2)
        for pixel in range(pixels + 1)
    ]
    return tuple(after - before for before, after in pairwise(places))


def _once_finished(
    out: Path, blocks: int, act: Callable[[Any], object], what: object
) -> threading.Thread:
    """Do something once so many blocks of a simulation are finished."""

    def wait() -> None:
        while len([*(out / "blocks").glob("[!.]*.parquet")]) < blocks:  # not those being written
            time.sleep(_POLL_S)
        act(what)

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


def _kill_child_of(parent: int) -> None:
    """Kill the first process of a pool."""
    for path in sorted(Path("/proc").glob("[0-9]*/stat")):
        with contextlib.suppress(OSError):
            words = path.read_text().rpartition(")")[2].split()
            command = path.with_name("cmdline").read_bytes()
            if int(words[1]) == parent and b"spawn_main" in command:
                os.kill(int(path.parent.name), signal.SIGKILL)
                return
