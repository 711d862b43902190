# SPDX-License-Identifier: MIT
"""What is run on one simulated board, in which world, and what it leaves behind.

Everything before the start of the motion is the same with and without serial load, so the two
runs can be compared edge by edge.
"""

from __future__ import annotations

import contextlib
import math
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.link import World
from pixstep.board.port import BAUD
from pixstep.board.recording import RecordedPixel, Recorder
from pixstep.board.state import Record
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.line import Line
from pixstep.lines.units import period_ticks, refuse_periods
from pixstep.progress import Progress, unseen
from pixstep.simulation.logs import (
    AxisPlant,
    ClockLog,
    EdgeLog,
    read_clock_log,
    read_edges,
    read_plant,
)
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.simulated_board import SerialLoad, SimulatedBoard
from pixstep.simulation.summary import Stats

FREE, START, LOCK = regs.SYNCS  # what a line is to the pixel clock
_ALL_RECORDS_HZ = 100  # of pixels: up to here a host reads every record,
_ALL_LOADED_HZ = 60  # and up to here where other requests saturate the line
_LOOK_S = 0.5  # between two looks at records, at most,
_READING_S = 0.09  # takes reading the records of an axis, its line being streamed, at BAUD at most
_REST = 0.7  # of that is spent however fast the bytes are
_LOADED = 3  # times as long where other requests saturate the line
_STRAY_PX = 64  # a part of a pixel: a change of the edge error by more than that has a record
_POLICIES = {"always": 0, "on_reversal": 1}


class Experiment:
    """What is run on a simulated board: lines here, moves and homing in moves/experiments.py."""

    board: str
    pixel_hz: Fraction
    seed: int

    @property
    def tick_hz(self) -> int:
        """Timer ticks a second of the board."""
        return boards.load(self.board).tick_hz

    @property
    def period(self) -> Fraction:
        """Nominal pixel period in ticks."""
        return period_ticks(self.pixel_hz, self.tick_hz)

    @contextlib.contextmanager
    def simulated(
        self, out: Path, files: Mapping[str, str], **more: Any
    ) -> Iterator[SimulatedBoard]:
        """Yield the board, booted; its `files`, by the simulator's log, are then whole in `out`."""
        out.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".run-", dir=out))
        try:
            logs = {log: scratch / name for log, name in files.items()}
            more |= {"seed": self.seed, **logs}
            with SimulatedBoard(self.board, self.pixel_hz, **more) as run:
                yield run
                run.finish()
            for path in logs.values():
                if path.is_file():
                    path.replace(out / path.name)
        finally:
            shutil.rmtree(scratch, ignore_errors=True)


@dataclass(frozen=True)
class LineExperiment(Experiment):
    """Lines by axis for one board, and the world they run in.

    `pixel_hz` is the frequency of the clock's edges, of which `divider` are a pixel.
    """

    board: str
    lines: dict[int, Line]
    pixel_hz: Fraction
    pixel_ppm: float = 0.0
    flaws: ClockFlaws = field(default_factory=ClockFlaws)  # of the clock, besides
    sync: str = START
    divider: int = 1
    gate_edges: int = 0
    serial_load: bool = False
    baud: int = BAUD
    seed: int = 1
    backlash_policy: str = "always"
    image: Path | None = None
    vcd: bool = False
    plants: Mapping[int, str] = field(default_factory=dict)  # the simulator's knobs, by axis
    ideals: Mapping[int, tuple[int, ...]] = field(default_factory=dict)  # the load's counts
    scales: Mapping[int, units.Scale] = field(default_factory=dict)  # of the motors, by axis
    program: Sequence[str | Path] | None = None  # the runner, if not the built one

    @property
    def line_hz(self) -> Fraction:
        """Nominal frequency of pixels."""
        return self.pixel_hz / self.divider

    @property
    def period(self) -> Fraction:
        """Nominal pixel period in ticks."""
        return period_ticks(self.line_hz, self.tick_hz)

    @property
    def clock_period(self) -> Fraction:
        """Nominal period of the clock in ticks."""
        return period_ticks(self.pixel_hz, self.tick_hz)

    @property
    def locked(self) -> bool:
        """True if the lines follow the clock to their end."""
        return self.sync == LOCK

    @property
    def strays_px(self) -> float:
        """Records that a pixel adds where the clock runs away from lines that do not follow it."""
        if self.sync != START or not any(line.clocked for line in self.lines.values()):
            return 0.0
        return min(1.0, _STRAY_PX * abs(self.pixel_ppm) / 1e6)

    def settings(self) -> dict[str, int]:
        """Return the board's settings that are not its defaults."""
        found = {"backlash_policy": _POLICIES[self.backlash_policy]}
        if self.sync != START:
            found["sync"] = regs.SYNCS[self.sync]
        if self.divider != 1:
            found["divider"] = self.divider
        if self.gate_edges:
            found[boards.GATE_SETTING] = self.gate_edges
        return found

    @property
    def burst_s(self) -> float:
        """How long a burst of the clock and the rest after it last; 0 without a gate."""
        edges = self.flaws.gate_edges
        return edges / float(self.pixel_hz) + self.flaws.gate_rest_ms / 1000 if edges else 0.0

    def record_every(self, capacity: int) -> int:
        """Return every how many pixels a record can be read before the board overwrites it."""
        all_hz = _ALL_LOADED_HZ if self.serial_load else _ALL_RECORDS_HZ
        if self.line_hz <= all_hz * min(1.0, self.baud / BAUD):
            return 1
        looks_s = _READING_S * max(_REST, BAUD / self.baud) * (_LOADED if self.serial_load else 1)
        unread = self.line_hz * (_LOOK_S + len(self.lines) * looks_s)
        return max(1, math.ceil(unread / (capacity - 1)))


@dataclass
class RunResult:
    """What a run left behind, for the verdict."""

    job: LineExperiment
    edges: EdgeLog = field(default_factory=EdgeLog)
    clock: ClockLog = field(default_factory=ClockLog)
    clock_armed: Mapping[str, int] = field(default_factory=dict)  # registers before the motion
    clock_seen: Mapping[str, int] = field(default_factory=dict)  # and behind it
    plants: dict[tuple[int, int], AxisPlant] = field(default_factory=dict)
    records: dict[int, dict[int, Record]] = field(default_factory=dict)
    axis_states: Mapping[int, Mapping[str, int]] = field(default_factory=dict)
    record_every: int = 1  # pixels; those of deviations besides
    refused: LineRefusedByBoardError | None = None
    trouble: list[str] = field(default_factory=list)
    stats_armed: Stats | None = None  # of a run that got so far
    stats: Stats = field(init=False, repr=False)  # at the end
    requests: dict[str, int] = field(default_factory=dict)

    def note_fault(self, board: Device) -> None:
        """Note the board's fault, if it has one."""
        if text := board.fault_text():
            self.trouble.append(text)

    def take(self, row: RecordedPixel) -> None:
        """Take a record."""
        self.records.setdefault(row.axis, {})[row.record.pixel] = row.record


def run_job(job: LineExperiment, out: Path, progress: Progress = unseen) -> RunResult:
    """Run a job; leave edges, clock, serial (.csv) and, if asked, run.vcd in `out`, each whole.

    With plants also plant.csv.

    `progress` is called with the share of pixels done. Raises UserError if the simulator cannot
    run; what the board does wrong is in the result.
    """
    refuse_periods(job.line_hz, job.divider, job.tick_hz, locked=job.locked)
    boards.refuse_gate(job.gate_edges, job.pixel_hz, job.tick_hz, locked=job.locked)
    result = RunResult(job)
    files = {"edges": "edges.csv", "clock_log": "clock.csv", "serial_log": "serial.csv"}
    files |= {"vcd": "run.vcd"} if job.vcd else {}
    files |= {"plant_log": "plant.csv"} if job.plants else {}
    with job.simulated(
        out, files, image=job.image, program=job.program, pixel_ppm=job.pixel_ppm, flaws=job.flaws,
        plants={(0, axis): knobs for axis, knobs in job.plants.items()},
    ) as run:  # fmt: skip
        _go(run, result, progress)
    result.edges = read_edges(out / "edges.csv")
    result.clock = read_clock_log(out / "clock.csv")
    if job.plants:
        result.plants = read_plant(out / "plant.csv")
    return result


def _go(run: SimulatedBoard, result: RunResult, progress: Progress) -> None:
    """Go through all phases; trouble ends the run and is noted in the result."""
    job = result.job
    try:
        if max(job.lines) >= run.board.input("axis_count"):
            raise UserError(f"axis {max(job.lines)}: the {boards.axes_text(job.board)}")
        if job.gate_edges and not run.board.has(boards.GATE_FEATURE):
            raise UserError(
                f"gate_edges: {boards.missing_feature(run.board.unit, boards.GATE_FEATURE)}"
            )
        result.record_every = job.record_every(run.board.record_capacity())
        settings = job.settings()
        if result.record_every > 1:
            settings["record_every"] = result.record_every
        run.set_up(job.pixel_hz, list(job.lines), **settings)
        if job.baud != BAUD:
            run.talk_at(job.baud)
        run.load(job.lines)
        if job.locked:
            run.await_clock()
        result.clock_armed = run.board.inputs()
        result.stats_armed = run.simulator.stats()
        _make(run, result, progress)
    except LineRefusedByBoardError as refusal:
        result.refused = refusal
    except BoardError as error:
        result.trouble.append(str(error))
        with contextlib.suppress(BoardError):
            result.note_fault(run.board)
    run.settle()
    result.stats = run.simulator.stats()
    result.requests["all"] = run.client.requests
    result.requests["without_reply"] = run.client.lost


def _make(run: SimulatedBoard, result: RunResult, progress: Progress) -> None:
    """Make the lines as a board does, their records read, the serial line loaded if asked."""
    job, load = result.job, None

    def reader() -> Recorder:
        kept = min(1.0, 1 / result.record_every + job.strays_px) * result.record_every
        return Recorder(run.board, run.axes, result.take, 1 / (float(job.line_hz) * kept))

    def loaded(world: World) -> World:
        nonlocal load
        load = SerialLoad(run.board, run.axes, run.uploads)
        return _LoadedTime(run, world, load)

    run.lasts_s += 2 * job.burst_s
    try:
        in_time = run.make(reader, loaded if job.serial_load else None, progress)
    finally:
        result.axis_states = run.lines.seen
        if load:
            result.requests |= {"load": load.sent, "load_exceptions": load.exceptions}
    if not in_time:
        last = [regs.axis_state(found["axis_state"]) for found in result.axis_states.values()]
        result.trouble.append(f"not done in time: axes are {', '.join(last)}")
    result.clock_seen = run.board.inputs()
    result.note_fault(run.board)


@dataclass(frozen=True)
class _LoadedTime:
    """Time in which the bus is kept busy: whoever waits sends requests until it has passed."""

    run: SimulatedBoard
    world: World
    load: SerialLoad

    def now_s(self) -> float:
        """Return simulated seconds since the start."""
        return self.world.now_s()

    def wait(self, seconds: float) -> None:
        """Send requests for so long."""
        simulator = self.run.simulator
        end = simulator.cycle + simulator.cycles(seconds)
        while simulator.cycle < end:
            self.load.until(simulator, end)
