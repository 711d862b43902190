# SPDX-License-Identifier: MIT
"""Run lines on one simulated board from upload to the last edge, and collect what happened.

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

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.handle import BoardRun, Watch
from pixstep.board.port import BAUD
from pixstep.board.state import Record
from pixstep.board.upload import feed
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.line import Line
from pixstep.lines.units import period_ticks, refuse_period
from pixstep.progress import Progress, unseen
from pixstep.simulation.clockflaws import ClockFlaws
from pixstep.simulation.edges import ClockLog, EdgeLog, read_clock_log, read_edges
from pixstep.simulation.plantlog import AxisPlant, read_plant
from pixstep.simulation.serialload import SerialLoad
from pixstep.simulation.simboard import SimulatedBoard
from pixstep.simulation.summary import Stats

FREE, START, LOCK = regs.SYNCS  # what a line is to the pixel clock
_ALL_RECORDS_HZ = 100  # of pixels: up to here a host reads every record,
_ALL_LOADED_HZ = 60  # and up to here where other requests saturate the line
_LOOK_S = 0.5  # between two looks at records, at most,
_KEPT = 0.8  # and from one look to the next this share of the time for which the board keeps them
_KEPT_LOADED = 0.5  # where other requests saturate the line
_READING_S = 0.09  # takes reading the records of an axis, its line being streamed, at BAUD at most
_REST = 0.7  # of that is spent however fast the bytes are
_LOADED = 3  # times as long where other requests saturate the line
_STRAY_PX = 64  # a part of a pixel: a change of the edge error by more than that has a record
_POLICIES = {"always": 0, "on_reversal": 1}


@dataclass(frozen=True)
class Job:
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
    def tick_hz(self) -> int:
        """Timer ticks a second of the board."""
        return boards.load(self.board).tick_hz

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

    @property
    def pixels(self) -> int:
        """Pixels of the longest line."""
        return max(line.pixels for line in self.lines.values())


@dataclass
class RunResult:
    """What a run left behind, for the verdict."""

    job: Job
    edges: EdgeLog = field(default_factory=EdgeLog)
    clock: ClockLog = field(default_factory=ClockLog)
    clock_armed: Mapping[str, int] = field(default_factory=dict)  # registers before the motion
    clock_seen: Mapping[str, int] = field(default_factory=dict)  # and behind it
    plants: dict[tuple[int, int], AxisPlant] = field(default_factory=dict)
    records: dict[int, dict[int, Record]] = field(default_factory=dict)
    axis_states: dict[int, Mapping[str, int]] = field(default_factory=dict)
    record_every: int = 1  # pixels; those of deviations besides
    refused: LineRefusedByBoardError | None = None
    trouble: list[str] = field(default_factory=list)
    stats_armed: Stats | None = None  # of a run that got so far
    stats: Stats = field(init=False, repr=False)  # at the end
    requests: dict[str, int] = field(default_factory=dict)


def run_job(job: Job, out: Path, progress: Progress = unseen) -> RunResult:
    """Run a job; leave edges, clock, serial (.csv) and, if asked, run.vcd in `out`, each whole.

    With plants also plant.csv.

    `progress` is called with the share of pixels done. Raises UserError if the simulator cannot
    run; what the board does wrong is in the result.
    """
    refuse_period(job.line_hz, job.tick_hz, locked=job.locked)
    refuse_period(job.pixel_hz, job.tick_hz)
    boards.refuse_gate(job.gate_edges, job.pixel_hz, job.tick_hz, locked=job.locked)
    out.mkdir(parents=True, exist_ok=True)
    result = RunResult(job)
    with scratch_folder(out) as scratch:
        with SimulatedBoard(
            job.board,
            job.pixel_hz,
            image=job.image,
            program=job.program,
            pixel_ppm=job.pixel_ppm,
            flaws=job.flaws,
            seed=job.seed,
            edges=scratch / "edges.csv",
            clock_log=scratch / "clock.csv",
            serial_log=scratch / "serial.csv",
            vcd=scratch / "run.vcd" if job.vcd else None,
            plants={(0, axis): knobs for axis, knobs in job.plants.items()},
            plant_log=scratch / "plant.csv" if job.plants else None,
        ) as run:
            _go(run, result, progress)
            run.finish()
        for name in ("edges.csv", "clock.csv", "serial.csv", "plant.csv", "run.vcd"):
            if (scratch / name).is_file():
                (scratch / name).replace(out / name)
    result.edges = read_edges(out / "edges.csv")
    result.clock = read_clock_log(out / "clock.csv")
    if job.plants:
        result.plants = read_plant(out / "plant.csv")
    return result


def _record_every(job: Job, capacity: int) -> int:
    """Return every how many pixels a record can be read before the board overwrites it."""
    if job.line_hz <= (_ALL_LOADED_HZ if job.serial_load else _ALL_RECORDS_HZ):
        return 1
    looks_s = _READING_S * max(_REST, BAUD / job.baud) * (_LOADED if job.serial_load else 1)
    unread = job.line_hz * (_LOOK_S + len(job.lines) * looks_s)
    return max(1, math.ceil(unread / (capacity - 1)))


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
        result.record_every = _record_every(job, run.board.record_capacity())
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
        run.arm()
        run.deadline_s += 2 * job.burst_s
        _follow(run, result, progress)
    except LineRefusedByBoardError as refusal:
        result.refused = refusal
    except BoardError as error:
        result.trouble.append(str(error))
        with contextlib.suppress(BoardError):
            _note_fault(run.board, result)
    run.settle()
    result.stats = run.simulator.stats()
    result.requests["all"] = run.client.requests
    result.requests["without_reply"] = run.client.lost


def _follow(run: SimulatedBoard, result: RunResult, progress: Progress) -> None:
    """Follow the lines to their end, the serial line loaded if that was asked."""
    load = SerialLoad(run.board, run.axes, run.uploads) if result.job.serial_load else None
    try:
        if not run.follow(_Watch(run, result, load, progress)):
            last = [regs.axis_state(found["axis_state"]) for found in result.axis_states.values()]
            result.trouble.append(f"not done in time: axes are {', '.join(last)}")
    finally:
        if load:
            result.requests["load"] = load.sent
            result.requests["load_exceptions"] = load.exceptions
    result.clock_seen = run.board.inputs()
    _note_fault(run.board, result)


def _note_fault(board: Board, result: RunResult) -> None:
    text = board.fault_text()
    if text:
        result.trouble.append(text)


@dataclass
class _Watch(Watch):
    """Reads the records of every pixel, and loads the serial line while waiting."""

    board_run: SimulatedBoard
    result: RunResult
    load: SerialLoad | None
    progress: Progress
    waits: bool = False  # an axis has recorded nothing yet

    @property
    def look_s(self) -> float:
        """Seconds between two looks: no record may be overwritten unread."""
        if self.load is not None:
            return _KEPT_LOADED * self._kept_s()
        if self.waits:  # its first record comes at any time
            return 0.0
        return min(_LOOK_S, _KEPT * self._kept_s() - self.board_run.poll_s)

    def seen(self, registers: Mapping[int, Mapping[str, int]]) -> None:
        """Note the registers and read the new records of all axes."""
        self.waits = False
        for axis, found in registers.items():
            self.result.axis_states[axis] = found
            known = self.result.records.setdefault(axis, {})
            # Nothing has been recorded yet of a line that has not passed a pixel.
            state = regs.axis_state(found["axis_state"])
            if state not in ("loaded", "armed") and (found["pixel"] or state != "running"):
                records = self.board_run.board.records(axis)
                known.update({record.pixel: record for record in records})
                # Reading all of them takes as long as a full queue lasts at a kilohertz.
                feed(self.board_run.uploads.values())
            else:
                self.waits = True
        done = min(max(known, default=0) for known in self.result.records.values())
        self.progress(min(1.0, done / self.result.job.pixels))

    def rest(self, run: BoardRun, begun_s: float) -> None:
        """Wait, or load the line until it is time for a look."""
        if self.load is None:
            super().rest(run, begun_s)
            return
        simulator = self.board_run.simulator
        self.load.until(simulator, simulator.cycles(begun_s + self.look_s))

    def _kept_s(self) -> float:
        """Return for how many seconds the board keeps a record."""
        job = self.result.job
        made_hz = float(job.line_hz) * min(1.0, 1 / self.result.record_every + job.strays_px)
        return self.board_run.board.record_capacity() / made_hz


@contextlib.contextmanager
def scratch_folder(out: Path) -> Iterator[Path]:
    """Yield a folder beside the results, on the same file system, gone afterwards."""
    path = Path(tempfile.mkdtemp(prefix=".run-", dir=out))
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
