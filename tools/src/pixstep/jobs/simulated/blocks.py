# SPDX-License-Identifier: MIT
"""A block of a job on its way to whoever simulates it: a small job of its own, packed.

Positions count from where its first line begins. Expected positions are computed anew where it is
unpacked: so a line of three motors with 500 pixels each takes some hundred bytes.
"""

from __future__ import annotations

import pickle
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.jobs.header import JobHeader
from pixstep.jobs.job import MACHINE, Job
from pixstep.jobs.shapes import MotorRun, Shape
from pixstep.jobs.simulated.cuts import Cut, Follows, MotorPlaces, SimulatedWorld, settings_of
from pixstep.jobs.simulated.tools import Tools
from pixstep.lazy import lazy
from pixstep.simulation.small_pickle import SmallPickle

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")


@dataclass(frozen=True)
class _Shapes(SmallPickle):
    """Shapes: decode, backlash and pixels of each, the counts of all one after the other."""

    heads: list[tuple[str, int, int]]
    counts: np.ndarray

    @classmethod
    def of(cls, shapes: list[Shape]) -> _Shapes:
        heads = [(one.decode, one.backlash, len(one.counts)) for one in shapes]
        counts = [count for one in shapes for count in one.counts]
        return cls(heads, np.array(counts, dtype=np.int64))

    def shapes(self) -> dict[bytes, Shape]:
        found, at = {}, 0
        for decode, backlash, pixels in self.heads:
            shape = Shape.of(self.counts[at : at + pixels].tolist(), decode, backlash)
            found[shape.key] = shape
            at += pixels
        return found


@dataclass(frozen=True)
class JobBlock:
    """What there is to simulate: lines of a job, from 1, of which the first `run_in` only run."""

    key: str
    run_in: int
    job: Job
    place: MotorPlaces
    follows: Follows
    settings: dict[str, dict[str, int]]
    world: SimulatedWorld
    tools: Tools


@dataclass(frozen=True)
class _PackedBlock:
    key: str
    run_in: int
    header: JobHeader
    machine: bytes
    runs: list[MotorRun]
    shapes: _Shapes
    place: MotorPlaces
    follows: Follows
    settings: dict[str, dict[str, int]]
    world: SimulatedWorld
    tools: Tools


def pack(job: Job, cut: Cut, world: SimulatedWorld, tools: Tools) -> bytes:
    """Return a block of a job."""
    zero = {name: run.start_steps for name, run in job.runs_of(cut.begin).items()}
    runs = [
        replace(run, line=line + 1 - cut.begin, start_steps=run.start_steps - zero[name])
        for line in range(cut.begin, cut.last + 1)
        for name, run in job.runs_of(line).items()
    ]
    lines = job.header.line.model_copy(update={"lines": cut.last + 1 - cut.begin})
    source = job.header.source.model_copy(update={"files": {}})
    header = job.header.model_copy(
        update={"line": lines, "source": source, "sha256": {}, "settings": {}}
    )
    shapes = [job.shapes[key] for key in dict.fromkeys(run.shape for run in runs)]
    packed = _PackedBlock(
        cut.key, cut.first - cut.begin, header, job.copies[MACHINE], runs, _Shapes.of(shapes),
        MotorPlaces.of(job), Follows.of(job), settings_of(job), world, tools,
    )  # fmt: skip
    return zlib.compress(pickle.dumps(packed, pickle.HIGHEST_PROTOCOL))


def unpack(data: bytes) -> JobBlock:
    """Return the block of its bytes."""
    found: _PackedBlock = pickle.loads(zlib.decompress(data))
    job = Job(
        found.header, {MACHINE: found.machine}, tuple(found.runs), found.shapes.shapes(),
        Path(f"block {found.key[:8]}"),
    )  # fmt: skip
    return JobBlock(
        found.key, found.run_in, job, found.place, found.follows, found.settings, found.world,
        found.tools,
    )  # fmt: skip
