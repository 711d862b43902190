# SPDX-License-Identifier: MIT
"""Run lines on one simulated board and look at chosen stretches of the run through windows.

Unlike a job of pixstep.simulation it needs no records and no positions, goes on to the end of the
line when the board no longer answers, and checks nothing beforehand: lines that the host would
refuse reach the board.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.link import World
from pixstep.board.upload import LineUpload, pause_s
from pixstep.lines.line import Line
from pixstep.lines.units import period_ticks
from pixstep.simulation.logs import EdgeLog, no_cycles, read_clock, read_edges
from pixstep.simulation.simulated_board import SerialLoad, SimulatedBoard
from pixstep.simulation.summary import Stats

if TYPE_CHECKING:
    import numpy as np

SLICE_S = 0.001  # how exactly a window opens and shuts
RECORDS_S = 0.25  # between two looks at records
_STRETCH_PX, _STRETCH_S = 4, (0.05, 0.1)  # between two polls of a board


@dataclass(frozen=True)
class RunWindow:
    """A stretch of a run to account for: from one step of the first axis to a later one."""

    first: int
    last: int


@dataclass(frozen=True)
class BenchRun:
    """Lines by axis for one board, the world they run in, and what to look at."""

    board: str
    lines: dict[int, Line]
    hz: Fraction
    serial_load: bool = False
    records: bool = False  # read the per-pixel records, as a host does that wants them
    windows: tuple[RunWindow, ...] = ()
    program: Sequence[str | Path] | None = None  # the simulator, if not the built one
    image: Path | None = None

    @property
    def tick_hz(self) -> int:
        """Timer ticks a second of the board."""
        return boards.load(self.board).tick_hz

    @property
    def period(self) -> Fraction:
        """Nominal pixel period in ticks."""
        return period_ticks(self.hz, self.tick_hz)


@dataclass
class BenchDriveOutcome:
    """What a run left behind. Each view is the statistics of a window, `cycles` long."""

    run: BenchRun
    edges: EdgeLog = field(default_factory=EdgeLog)
    clock: np.ndarray = field(default_factory=no_cycles)
    refused: str = ""  # the line error's name
    fault: str = ""  # the fault's name
    trouble: str = ""  # any other reason for which the run ended early
    views: list[dict[str, Any]] = field(default_factory=list)
    final: Stats | None = None

    @property
    def stats(self) -> Stats:
        """The statistics of the whole run, which there are behind its end."""
        assert self.final
        return self.final

    @property
    def steps(self) -> int:
        """STEP edges made by all axes together."""
        return sum(len(edges.rising) for edges in self.edges.axes.values())


def drive(run: BenchRun) -> BenchDriveOutcome:
    """Run it; what the board does wrong is in the outcome."""
    outcome = BenchDriveOutcome(run)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        edges, clock = Path(folder, "edges.csv"), Path(folder, "clock.csv")
        with SimulatedBoard(
            run.board, run.hz, image=run.image, program=run.program, edges=edges, clock_log=clock
        ) as board:
            _go(board, outcome)
            board.finish()
        outcome.edges, outcome.clock = read_edges(edges), read_clock(clock)
    return outcome


def _go(board: SimulatedBoard, outcome: BenchDriveOutcome) -> None:
    """Go through all phases."""
    run, world = outcome.run, board.link.world
    ends_s = 0.0
    try:
        # A board that is too busy to answer goes on with its line all the same.
        board.set_up(run.hz, list(run.lines), bus_timeout_ms=0)
        board.load(run.lines)
        board.arm()
        ends_s = world.now_s() + board.lasts_s
        records = (lambda: _Records(board)) if run.records else None
        windows = partial(_Windows, board, outcome)
        if not board.make(records, windows, armed=True):
            outcome.trouble = "not done in time"
    except LineRefusedByBoardError as refusal:
        outcome.refused = refusal.name
    except BoardError as error:
        outcome.trouble = str(error)
        world.wait(max(0.0, ends_s - world.now_s()))
    board.settle()
    try:
        outcome.fault = board.board.fault_name()
    except BoardError as error:
        outcome.trouble = outcome.trouble or str(error)
    outcome.final = board.simulator.stats()


class _Records:
    """Reads the records of running axes now and then."""

    def __init__(self, board: SimulatedBoard) -> None:
        self._board, self._due_s = board, 0.0

    def look_if_due(self, world: World, uploads: list[LineUpload]) -> None:
        """Read them if it is time for that."""
        if world.now_s() >= self._due_s:
            self._due_s = world.now_s() + RECORDS_S
            self.look(uploads)

    def look(self, uploads: list[LineUpload], *, ended: bool = False) -> None:
        """Read them, unless no line runs any more."""
        del uploads
        for axis, found in {} if ended else self._board.lines.seen.items():
            if regs.axis_state(found["axis_state"]) == "running":
                self._board.board.records(axis)


class _Windows:
    """Time in which the windows of a run are looked through, the line loaded if asked."""

    def __init__(self, board: SimulatedBoard, outcome: BenchDriveOutcome, world: World) -> None:
        run = outcome.run
        self._world, self._period_s = world, float(1 / run.hz)
        self._board, self._simulator, self._outcome = board, board.simulator, outcome
        self._load = SerialLoad(board.board, board.axes, board.uploads) if run.serial_load else None
        self._windows = list(run.windows)
        self._opened: dict[str, Any] | None = None

    def now_s(self) -> float:
        """Return simulated seconds since the start."""
        return self._world.now_s()

    def wait(self, seconds: float) -> None:
        """Let a whole stretch pass, however long the poll took."""
        del seconds
        stretch_s = min(max(_STRETCH_S[0], _STRETCH_PX * self._period_s), _STRETCH_S[1])
        stretch_s = pause_s(self._board.uploads.values(), self._period_s, stretch_s)
        until = self._simulator.cycle + self._simulator.cycles(stretch_s)
        look_cycles = self._simulator.cycles(SLICE_S)
        while self._simulator.cycle < until:
            self._look()
            if self._load:
                self._load.until(self._simulator, until)
            else:
                left = until - self._simulator.cycle
                self._simulator.run(min(left, look_cycles) if self._windows else left)

    def _look(self) -> None:
        """Open or shut the next window if its step has been made."""
        if not self._windows:
            return
        made = self._simulator.count(0, self._board.axes[0])
        if self._opened is None and made >= self._windows[0].first:
            self._opened = self._simulator.stats() | {"made": made}
            self._simulator.mark()
        elif self._opened is not None and made >= self._windows[0].last:
            now = self._simulator.stats() | {"made": made}
            self._outcome.views.append(view(self._opened, now))
            self._opened = None
            del self._windows[0]


def view(before: dict[str, Any], after: dict[str, Any]) -> dict[str, Any]:
    """Return the statistics between two moments; at the first one the handlers' began anew."""
    old, new = before["boards"][0], after["boards"][0]
    return {
        "steps": after["made"] - before["made"],
        "cycles": after["cycle"] - before["cycle"],
        "interrupt_cycles": new["interrupt_cycles"] - old["interrupt_cycles"],
        "sections": _less(new["sections"], old["sections"]),
        "section_entries": _less(new["section_entries"], old["section_entries"]),
        "handlers": {row["name"]: row for row in new["handlers"]},
        "interrupts_off_cycles": new["interrupts_off_max_cycles"],
        "interrupts_off_main_cycles": new["interrupts_off_main_max_cycles"],
    }


def _less(new: list[int], old: list[int]) -> list[int]:
    return [b - a for a, b in zip(old, new, strict=True)]
