# SPDX-License-Identifier: MIT
"""Run lines on one simulated board and look at chosen stretches of the run through windows.

Unlike `simrun` it needs no records and no positions, goes on to the end of the line when the board
no longer answers, and checks nothing beforehand: lines that the host would refuse reach the board.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.client import Board, BoardError, LineRefusedByBoardError, Upload
from pixstep.board.transport import SimClient
from pixstep.lines.line import Line
from pixstep.lines.rational import period_ticks
from pixstep.lines.runs import queue_entries
from pixstep.simulation.edges import EdgeLog, read_clock, read_edges
from pixstep.simulation.serialload import SerialLoad
from pixstep.simulation.simctl import SimOptions, Simulator
from pixstep.simulation.simrun import BOOT_S, SETTLE_PIXELS

SLICE_S = 0.001  # how exactly a window opens and shuts
_POLL_S = 0.1
_POLL_PIXELS = 4
_START_PIXELS = 10  # from arming to the last pixel there is this much to spare


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
    edges: EdgeLog | None = None
    clock: list[int] = field(default_factory=list)
    refused: str = ""  # the line error's name
    fault: str = ""  # the fault's name
    trouble: str = ""  # any other reason for which the run ended early
    views: list[dict] = field(default_factory=list)
    stats: dict = field(default_factory=dict)

    @property
    def steps(self) -> int:
        """STEP edges made by all axes together."""
        return sum(len(edges.rising) for edges in self.edges.axes.values())


def drive(run: Run) -> Outcome:
    """Run it; what the board does wrong is in the outcome."""
    outcome = Outcome(run)
    image = run.image or natives.image(run.board)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        edges, clock = Path(folder, "edges.csv"), Path(folder, "clock.csv")
        options = SimOptions([(run.board, image)], run.hz, edges=edges, clock_log=clock)
        with Simulator(options, run.program) as simulator:
            _Drive(run, simulator, outcome).go()
            simulator.quit()
        outcome.edges, outcome.clock = read_edges(edges), read_clock(clock)
    return outcome


class _Drive:
    """The steps of one run; each method is one phase."""

    def __init__(self, run: Run, simulator: Simulator, outcome: Outcome) -> None:
        self.run, self.simulator, self.outcome = run, simulator, outcome
        self.board = Board(SimClient(simulator))
        self.axes = sorted(run.lines)
        self.uploads: dict[int, Upload] = {}
        self.windows = list(run.windows)
        self.opened: dict | None = None
        self.deadline = 0

    def go(self) -> None:
        """Go through all phases."""
        try:
            self.set_up()
            self.follow()
        except LineRefusedByBoardError as refusal:
            self.outcome.refused = refusal.name
        except BoardError as error:
            self.outcome.trouble = str(error)
            self.simulator.run(max(0, self.deadline - self.simulator.cycle))
        self.settle()

    def set_up(self) -> None:
        """Boot, set, enable, upload, arm."""
        self.simulator.wait_s(BOOT_S)
        self.board.set_pixel_hz(self.run.hz)
        # A board that is too busy to answer goes on with its line all the same.
        self.board.write_setting("bus_timeout_ms", 0)
        self.board.command("enable", self.axes)
        for axis in self.axes:
            self.uploads[axis] = Upload(self.board, axis, queue_entries(self.run.lines[axis]))
            self.uploads[axis].push()
            if self.state(self.board.axis(axis)) == "refused":
                raise self.board.refusal(axis)
        pixels = max(line.pixels for line in self.run.lines.values()) + _START_PIXELS
        self.board.command("arm", self.axes)
        lasts = int(pixels * self.run.period) + self.simulator.cycles(_POLL_S)
        self.deadline = self.simulator.cycle + lasts

    def follow(self) -> None:
        """Poll, stream and look through the windows until every axis is at its end."""
        load = SerialLoad(self.board, self.axes, self.uploads) if self.run.serial_load else None
        stretch = min(int(_POLL_PIXELS * self.run.period), self.simulator.cycles(_POLL_S))
        look_cycles = self.simulator.cycles(SLICE_S)
        while not self.ended():
            if self.simulator.cycle > self.deadline:
                self.outcome.trouble = "not done in time"
                return
            for upload in self.uploads.values():
                upload.push()
            until = self.simulator.cycle + stretch
            while self.simulator.cycle < until:
                self.look()
                if load:
                    load.until(self.simulator, until)
                else:
                    left = until - self.simulator.cycle
                    self.simulator.run(min(left, look_cycles) if self.windows else left)

    def ended(self) -> bool:
        """Ask for the states, and for the records if they are wanted."""
        states = [self.state(found) for found in self.board.axes(self.axes[-1] + 1)]
        running = [axis for axis in self.axes if states[axis] == "running"]
        for axis in running if self.run.records else ():
            self.board.records(axis)
        return all(states[axis] in ("done", "fault", "refused") for axis in self.axes)

    def look(self) -> None:
        """Open or shut the next window if its step has been made."""
        if not self.windows:
            return
        made = self.simulator.count(0, self.axes[0])
        if self.opened is None and made >= self.windows[0].first:
            self.opened = self.simulator.stats() | {"made": made}
            self.simulator.mark()
        elif self.opened is not None and made >= self.windows[0].last:
            self.outcome.views.append(view(self.opened, self.simulator.stats() | {"made": made}))
            self.opened = None
            del self.windows[0]

    def settle(self) -> None:
        """Let late edges show themselves; collect the fault and the statistics."""
        self.simulator.run(int(SETTLE_PIXELS * self.run.period))
        try:
            self.outcome.fault = self.board.fault_name()
        except BoardError as error:
            self.outcome.trouble = self.outcome.trouble or str(error)
        self.outcome.stats = self.simulator.stats()

    @staticmethod
    def state(registers: dict[str, int]) -> str:
        """Return the name of an axis' state."""
        return regs.AXIS_STATES[registers["axis_state"]]


def view(before: dict, after: dict) -> dict:
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
