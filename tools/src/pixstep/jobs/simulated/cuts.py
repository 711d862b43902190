# SPDX-License-Identifier: MIT
"""A job in blocks of chained lines, each named by its content.

The line before a block runs first, so that the seam to the block is a real one. Everything that
decides edges and verdict is in a block's key, and nothing else: not where it is in the job, nor
where the motors are. So equal blocks of a job have one key, and a line that was changed changes the
keys of its block and of the next one alone.

What a verdict depends on besides the job: this code, the simulator, the boards' images.

Each is named with its version or the first digits of its SHA-256. Processes that do not have the
same give other verdicts, so they are refused.

A block of a job on its way to whoever simulates it: a small job of its own, packed.

Positions count from where its first line begins. Expected positions are computed anew where it is
unpacked: so a line of three motors with 500 pixels each takes some hundred bytes.
"""

from __future__ import annotations

import hashlib
import json
import pickle
import socket
import tomllib
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, astuple, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from pixstep import natives
from pixstep.board import registers as regs
from pixstep.board import settings, values
from pixstep.board.boards import load as load_kind
from pixstep.errors import AskedText, UserError
from pixstep.jobs.header import JobHeader
from pixstep.jobs.job import MACHINE, Job
from pixstep.jobs.shapes import MotorRun, Shape
from pixstep.lazy import np
from pixstep.lines.units import hz_text
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.small_pickle import SmallPickle
from pixstep.version import __version__

Tools = Mapping[str, str]
Images = Mapping[str, Path]  # by kind of board, where it is not the built one
_DIGITS = 16
_SIMULATOR = "pixstep-sim"


class OtherToolsError(UserError):
    """A process has other tools than the one that asks it."""


def tools_here(kinds: tuple[str, ...], images: Images | None = None) -> dict[str, str]:
    """Return the tools of this process, by name, for boards of these kinds."""
    found = {"pixstep": f"{__version__} {_code()}", _SIMULATOR: _sum(natives.program(_SIMULATOR))}
    for kind in kinds:
        found[f"firmware of {kind}"] = _sum(image_of(kind, images or {}))
    return found


def image_of(kind: str, images: Images) -> Path:
    """Return the image of a kind of board."""
    return images.get(kind) or natives.image(kind)


def tool_differences(mine: Tools, others: Tools) -> str:
    """Return in words which tools somebody else has; nothing if they are the same."""
    found = (
        f"{name} {others.get(name, '(none)')} instead of {wanted}"
        for name, wanted in mine.items()
        if others.get(name) != wanted
    )
    return ", ".join(found)


def require_same_tools(mine: Tools, others: Tools, who: str) -> None:
    """Raise OtherToolsError if somebody else has other tools."""
    if told := tool_differences(mine, others):
        raise OtherToolsError(f"{who} has {told}")


def host() -> str:
    """Return the name of this computer."""
    return socket.gethostname()


@cache
def _code() -> str:
    """Return the sum of this package's sources and of the tables that the build makes."""
    folder, content = Path(__file__).parents[2], hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        content.update(f"{path.relative_to(folder)}\n".encode() + path.read_bytes())
    content.update(natives.made("tables.json").read_bytes())
    return content.hexdigest()[:_DIGITS]


@cache
def _sum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:_DIGITS]


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


LINES = 32  # of a block, besides the one before
MOST_STEPS = 2_000_000  # of a block, or one line: a list of edges is held in memory
VERSION = 1  # of what rows and edges mean
_SPEAKING = ("unit_address", "baud_100", "parity")  # to the simulated bus as it is


@dataclass(frozen=True)
class SimulatedWorld:
    """In which world blocks are simulated: the pixel clock, what is random, blocks' lines.

    Without `run_in` no line runs before a block.
    """

    ppm: float = 0.0
    flaws: ClockFlaws = field(default_factory=ClockFlaws)
    seed: int = 1
    lines: int = LINES
    run_in: bool = True
    images: Images = field(default_factory=dict)


@dataclass(frozen=True)
class Cut:
    """Lines `first` to `last` of a job, after line `begin`, if that is another one."""

    begin: int
    first: int
    last: int
    key: str = ""

    @property
    def lines(self) -> int:
        """How many lines are judged."""
        return self.last + 1 - self.first


@dataclass(frozen=True)
class Follows:
    """What lines are to the pixel clock, of which a pixel has `divider` edges."""

    sync: str
    divider: int
    gate_edges: int

    @classmethod
    def of(cls, job: Job) -> Follows:
        """Return what a job's machine file says, else what its boards are set to."""
        clock, (first, *_) = job.machine.tables.clock, MotorPlaces.of(job).boards
        held = settings.defaults() | settings_of(job).get(first, {})
        names = {number: name for name, number in regs.SYNCS.items()}
        gate = settings.gate_of(held) if clock.gate_edges is None else clock.gate_edges
        return cls(clock.sync or names[held["sync"]], clock.edges, gate)


@dataclass(frozen=True)
class MotorPlaces:
    """The simulated boards by name, with their kinds; each motor's board, from 0, and axis.

    A board with the most ticks a second is the first: its cycles are the time of all.
    """

    boards: Mapping[str, str]
    motors: Mapping[str, tuple[int, int]]

    @classmethod
    def of(cls, job: Job) -> MotorPlaces:
        """Return the boards and motors of a job."""
        machine = job.machine.tables
        names = {name: machine.board_name(machine[name]) for name in job.motors}
        kinds = {name: machine.boards[name].kind for name in names.values()}
        boards = sorted(kinds, key=lambda name: -load_kind(kinds[name]).tick_hz)
        kinds = {name: kinds[name] for name in boards}
        return cls(
            kinds,
            {name: (boards.index(of), machine[name].axis) for name, of in names.items()},
        )

    @property
    def kinds(self) -> tuple[str, ...]:
        """The different kinds of boards."""
        return tuple(dict.fromkeys(self.boards.values()))


def settings_of(job: Job) -> dict[str, dict[str, int]]:
    """Return the settings of boards that a job has, but for how they are spoken to."""
    known = {register.name for register in regs.settings()}
    return {
        board: {
            name: value
            for name, value in tomllib.loads(job.copies[member].decode())[values.TABLE].items()
            if name in known and name not in _SPEAKING
        }
        for board, member in job.header.settings.items()
    }


def refuse(job: Job, world: SimulatedWorld) -> None:
    """Raise UserError for a job that cannot be simulated in a world."""
    follows = Follows.of(job)
    if follows.gate_edges and not world.flaws.gate_edges:
        raise UserError(AskedText(
            "{path}: its pixel clock is gated, with {edges} edges before line zero: say by "
            "{pixel_gate} how the clock comes, at least {all} edges a burst",
            path=job.path, edges=follows.gate_edges,
            all=follows.gate_edges + job.pixels * follows.divider + 1,
        ))  # fmt: skip


class Cutter:
    """Cuts a job into blocks, in a world, for some tools."""

    def __init__(self, job: Job, world: SimulatedWorld, found: Tools) -> None:
        self._job, self._world = job, world
        self._steps: dict[tuple[bytes, str], int] = {}
        place = MotorPlaces.of(job)
        self._same = {
            "version": VERSION, "tools": dict(found), "boards": list(place.boards.values()),
            "settings": [settings_of(job).get(name, {}) for name in place.boards],
            "clock": [hz_text(job.machine.tables.clock_hz), astuple(Follows.of(job))],
            "world": [world.ppm, asdict(world.flaws), world.seed],
            "motors": [
                [name, *at, job.header.motors[name].backlash] for name, at in place.motors.items()
            ],
        }  # fmt: skip

    def cuts(self) -> Iterator[Cut]:
        """Yield the blocks one after the other."""
        first = 1
        while first <= self._job.lines:
            last, steps = first, self._steps_of(first)
            while last < min(self._job.lines, first + self._world.lines - 1):
                steps += self._steps_of(last + 1)
                if steps > MOST_STEPS:
                    break
                last += 1
            begin = first - 1 if self._world.run_in and first > 1 else first
            yield Cut(begin, first, last, self._key(begin, first, last))
            first = last + 1

    def _steps_of(self, line: int) -> int:
        """Return the steps of all motors in a line."""
        found = 0
        for run in self._job.runs_of(line).values():
            key = run.shape, run.motor
            if key not in self._steps:
                shape = self._job.shapes[run.shape]
                self._steps[key] = shape.backlash + sum(map(abs, shape.counts))
            found += self._steps[key]
        return found

    def _key(self, begin: int, first: int, last: int) -> str:
        zero = {name: run.start_steps for name, run in self._job.runs_of(begin).items()}
        lines: list[Any] = [
            [
                [*_plain(astuple(run)[2:4]), run.start_steps - zero[name], run.play_side]
                for name, run in self._job.runs_of(line).items()
            ]
            for line in range(begin, last + 1)
        ]
        facts = {**self._same, "first": first - begin, "lines": lines}
        text = json.dumps(facts, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


def _plain(values_of: tuple[Any, ...]) -> list[Any]:
    return [value.hex() if isinstance(value, bytes) else value for value in values_of]


def tools_of(job: Job, world: SimulatedWorld) -> Tools:
    """Return the tools of this process for a job."""
    return tools_here(MotorPlaces.of(job).kinds, world.images)
