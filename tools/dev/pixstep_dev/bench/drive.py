# SPDX-License-Identifier: MIT
"""Run lines on one simulated board and look at chosen stretches of the run through windows.

Unlike `simrun` it needs no records and no positions, goes on to the end of the line when the board
no longer answers, and checks nothing beforehand: lines that the host would refuse reach the board.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.handle import BoardRun, Watch
from pixstep.lines.line import Line
from pixstep.lines.units import period_ticks
from pixstep.simulation.edges import EdgeLog, no_cycles, read_clock, read_edges
from pixstep.simulation.serialload import SerialLoad
from pixstep.simulation.simboard import SimulatedBoard
from pixstep.simulation.summary import Stats

if TYPE_CHECKING:
    import numpy as np

SLICE_S = 0.001  # how exactly a window opens and shuts


@dataclass(frozen=True)
class Window:
    """A stretch of a run to account for: from one step of the first axis to a later one."""

    first: int
    last: int


@dataclass(frozen=True)
class Run:
    """Lines by axis for one board, the world they run in, and what to look at."""

    board: str
    lines: dict[int, Line]
    hz: Fraction
    serial_load: bool = False
    records: bool = False  # read the per-pixel records, as a host does that wants them
    windows: tuple[Window, ...] = ()
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
class Outcome:
    """What a run left behind. Each view is the statistics of a window, `cycles` long."""

    run: Run
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


def drive(run: Run) -> Outcome:
    """Run it; what the board does wrong is in the outcome."""
    outcome = Outcome(run)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        edges, clock = Path(folder, "edges.csv"), Path(folder, "clock.csv")
        with SimulatedBoard(
            run.board, run.hz, image=run.image, program=run.program, edges=edges, clock_log=clock
        ) as board:
            _go(board, outcome)
            board.finish()
        outcome.edges, outcome.clock = read_edges(edges), read_clock(clock)
    return outcome


def _go(board: SimulatedBoard, outcome: Outcome) -> None:
    """Go through all phases."""
    run = outcome.run
    try:
        # A board that is too busy to answer goes on with its line all the same.
        board.set_up(run.hz, list(run.lines), bus_timeout_ms=0)
        board.load(run.lines)
        board.arm()
        if not board.follow(_Windows(board, outcome)):
            outcome.trouble = "not done in time"
    except LineRefusedByBoardError as refusal:
        outcome.refused = refusal.name
    except BoardError as error:
        outcome.trouble = str(error)
        board.link.world.wait(max(0.0, board.deadline_s - board.link.world.now_s()))
    board.settle()
    try:
        outcome.fault = board.board.fault_name()
    except BoardError as error:
        outcome.trouble = outcome.trouble or str(error)
    outcome.final = board.simulator.stats()


class _Windows(Watch):
    """Looks through the windows of a run, reading records and loading the line if asked."""

    def __init__(self, board: SimulatedBoard, outcome: Outcome) -> None:
        run = outcome.run
        self._board, self._simulator, self._outcome = board, board.simulator, outcome
        self._load = SerialLoad(board.board, board.axes, board.uploads) if run.serial_load else None
        self._windows = list(run.windows)
        self._opened: dict[str, Any] | None = None

    def seen(self, registers: Mapping[int, Mapping[str, int]]) -> None:
        """Read the records of running axes if they are wanted."""
        for axis, found in registers.items() if self._outcome.run.records else ():
            if regs.axis_state(found["axis_state"]) == "running":
                self._board.board.records(axis)

    def rest(self, run: BoardRun, begun_s: float) -> None:
        """Let a whole stretch pass, however long the poll took."""
        del begun_s
        look_cycles = self._simulator.cycles(SLICE_S)
        until = self._simulator.cycle + self._simulator.cycles(run.poll_s)
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
