# SPDX-License-Identifier: MIT
"""Run lines on one simulated board from upload to the last edge, and collect what happened.

Everything before the start of the motion is the same with and without serial load, so the two
runs can be compared edge by edge.
"""

import contextlib
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.client import Board, BoardError, LineRefusedByBoardError, Record, Upload
from pixstep.board.transport import SimClient
from pixstep.errors import UserError
from pixstep.lines.line import Line
from pixstep.lines.rational import period_ticks, refuse_period
from pixstep.lines.runs import queue_entries
from pixstep.simulation.edges import EdgeLog, read_clock, read_edges
from pixstep.simulation.plantlog import AxisPlant, read_plant
from pixstep.simulation.serialload import SerialLoad
from pixstep.simulation.simctl import SimOptions, Simulator

BOOT_S = 0.05
SETTLE_PIXELS = 2
_POLL_LIMIT_S = 0.1
_POLICIES = {"always": 0, "on_reversal": 1}

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Job:
    """Lines by axis for one board, and the world they run in."""

    board: str
    lines: dict[int, Line]
    pixel_hz: Fraction
    pixel_ppm: float = 0.0
    serial_load: bool = False
    seed: int = 1
    backlash_policy: str = "always"
    image: Path | None = None
    vcd: bool = False
    plants: Mapping[int, str] = field(default_factory=dict)  # the simulator's knobs, by axis
    ideals: Mapping[int, tuple[int, ...]] = field(default_factory=dict)  # the load's counts
    program: Sequence[str | Path] | None = None  # the runner, if not the built one

    @property
    def tick_hz(self) -> int:
        """Timer ticks a second of the board."""
        return boards.load(self.board).tick_hz

    @property
    def period(self) -> Fraction:
        """Nominal pixel period in ticks."""
        return period_ticks(self.pixel_hz, self.tick_hz)

    @property
    def pixels(self) -> int:
        """Pixels of the longest line."""
        return max(line.pixels for line in self.lines.values())


@dataclass
class RunResult:
    """What a run left behind, for the verdict."""

    job: Job
    edges: EdgeLog | None = None
    clock: list[int] = field(default_factory=list)
    plants: dict[tuple[int, int], AxisPlant] = field(default_factory=dict)
    records: dict[int, dict[int, Record]] = field(default_factory=dict)
    axis_states: dict[int, dict[str, int]] = field(default_factory=dict)
    refused: LineRefusedByBoardError | None = None
    trouble: list[str] = field(default_factory=list)
    stats_armed: dict = field(default_factory=dict)
    stats: dict = field(default_factory=dict)
    requests: dict[str, int] = field(default_factory=dict)


def run_job(job: Job, out: Path, progress: Progress = lambda _: None) -> RunResult:
    """Run a job; leave edges, clock, serial (.csv) and, if asked, run.vcd in `out`, each whole.

    With plants also plant.csv.

    `progress` is called with the share of pixels done. Raises UserError if the simulator cannot
    run; what the board does wrong is in the result.
    """
    refuse_period(job.pixel_hz, job.tick_hz)
    image = job.image or natives.image(job.board)
    out.mkdir(parents=True, exist_ok=True)
    result = RunResult(job)
    with scratch_folder(out) as scratch:
        options = SimOptions(
            boards=[(job.board, image)],
            pixel_hz=job.pixel_hz,
            pixel_ppm=job.pixel_ppm,
            seed=job.seed,
            edges=scratch / "edges.csv",
            clock_log=scratch / "clock.csv",
            serial_log=scratch / "serial.csv",
            vcd=scratch / "run.vcd" if job.vcd else None,
            plants={(0, axis): knobs for axis, knobs in job.plants.items()},
            plant_log=scratch / "plant.csv" if job.plants else None,
        )
        with Simulator(options, job.program) as simulator:
            _Run(job, simulator, result, progress).go()
            simulator.quit()
        for name in ("edges.csv", "clock.csv", "serial.csv", "plant.csv", "run.vcd"):
            if (scratch / name).is_file():
                (scratch / name).replace(out / name)
    result.edges = read_edges(out / "edges.csv")
    result.clock = read_clock(out / "clock.csv")
    if job.plants:
        result.plants = read_plant(out / "plant.csv")
    return result


class _Run:
    """The steps of one run; each method is one phase."""

    def __init__(
        self, job: Job, simulator: Simulator, result: RunResult, progress: Progress
    ) -> None:
        self.job, self.simulator, self.result, self.progress = job, simulator, result, progress
        self.modbus = SimClient(simulator)
        self.board = Board(self.modbus)
        self.uploads: dict[int, Upload] = {}
        self.axes = sorted(job.lines)
        self._polled_cycle = 0

    def go(self) -> None:
        """Go through all phases; trouble ends the run and is noted in the result."""
        try:
            self.set_up()
            self.upload()
            self.arm()
            self.follow()
        except LineRefusedByBoardError as refusal:
            self.result.refused = refusal
        except BoardError as error:
            self.result.trouble.append(str(error))
            with contextlib.suppress(BoardError):
                self._note_fault()
        self.settle()

    def set_up(self) -> None:
        """Wait for the board, check its map, set what the lines need, enable the axes."""
        self.simulator.wait_s(BOOT_S)
        count = self.board.input("axis_count")
        if self.axes[-1] >= count:
            raise UserError(f"axis {self.axes[-1]}: the {boards.axes_text(self.job.board)}")
        self.board.set_pixel_hz(self.job.pixel_hz)
        self.board.write_setting("backlash_policy", _POLICIES[self.job.backlash_policy])
        self.board.command("enable", self.axes)

    def upload(self) -> None:
        """Queue every line, or as much as the queue holds."""
        for axis in self.axes:
            upload = Upload(self.board, axis, queue_entries(self.job.lines[axis]))
            self.uploads[axis] = upload
            upload.push()
            state = regs.axis_state(self.board.axis(axis)["axis_state"])
            if state == "refused":
                raise self.board.refusal(axis)
            if state != "loaded":
                raise BoardError(f"axis {axis}: {state} after the upload, not loaded")

    def arm(self) -> None:
        """Arm all axes at once; the line starts one period after the next clock edge."""
        self.result.stats_armed = self.simulator.stats()
        self.board.command("arm", self.axes)

    def follow(self) -> None:
        """Poll until every axis is done, streaming, reading records, loading the line if asked."""
        load = SerialLoad(self.board, self.axes, self.uploads) if self.job.serial_load else None
        period, most = self.job.period, self.simulator.cycles(_POLL_LIMIT_S)
        deadline = self.simulator.cycle + int((self.job.pixels + 10) * period) + most
        while True:
            next_poll = self.simulator.cycle + min(int(4 * period), most)
            states = self._poll()
            if all(state in ("done", "fault", "refused") for state in states):
                break
            if self.simulator.cycle > deadline:
                self.result.trouble.append(f"not done in time: axes are {', '.join(states)}")
                break
            for upload in self.uploads.values():
                upload.push()
            if load:
                load.until(self.simulator, self._next_records_cycle())
            elif next_poll > self.simulator.cycle:
                self.simulator.run(next_poll - self.simulator.cycle)
        if load:
            self.result.requests["load"] = load.sent
            self.result.requests["load_exceptions"] = load.exceptions
        self._note_fault()

    def settle(self) -> None:
        """Let late edges show themselves, then collect the statistics."""
        self.simulator.run(int(SETTLE_PIXELS * self.job.period))
        self.result.stats = self.simulator.stats()
        self.result.requests["all"] = self.modbus.requests
        self.result.requests["without_reply"] = self.modbus.lost

    def _poll(self) -> list[str]:
        """Read the states and the new records of all axes."""
        names = []
        self._polled_cycle = self.simulator.cycle
        states = self.board.axes(self.axes[-1] + 1)
        for axis in self.axes:
            state = states[axis]
            self.result.axis_states[axis] = state
            names.append(regs.axis_state(state["axis_state"]))
            known = self.result.records.setdefault(axis, {})
            if names[-1] not in ("loaded", "armed"):
                known.update({record.pixel: record for record in self.board.records(axis)})
        done = min(len(known) for known in self.result.records.values())
        self.progress(min(1.0, done / self.job.pixels))
        return names

    def _next_records_cycle(self) -> int:
        """Return the cycle by which records must be read again, or the board overwrites some."""
        return self._polled_cycle + int(self.board.record_capacity() * self.job.period / 2)

    def _note_fault(self) -> None:
        text = self.board.fault_text()
        if text:
            self.result.trouble.append(text)


@contextlib.contextmanager
def scratch_folder(out: Path) -> Iterator[Path]:
    """Yield a folder beside the results, on the same file system, gone afterwards."""
    path = Path(tempfile.mkdtemp(prefix=".run-", dir=out))
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
