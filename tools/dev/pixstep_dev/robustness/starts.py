# SPDX-License-Identifier: MIT
"""Starts of several boards on one pixel clock, with everything that may keep them apart.

A trial loads a line on each of two or three boards, starts them as `pixstep board start` does and
follows them to their end. The clock may rest before `go` and come back at any instant; one board's
pin may miss an edge, or get a false or a doubled one, at any instant. Then

    together    all boards began on one edge of the clock, by their STEP edges
    named       the host or a board said why not, and everything was stopped
    silent      boards began on different edges, and nobody said so: a complaint
"""

import contextlib
import random
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep import natives
from pixstep.board import registers as regs
from pixstep.board import run, snapshot, together
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.run import LinesOfBoard
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import queue_entries
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions, Simulator

SYNCS = ("start", "lock")
FLAWS = ("none", "none", "none", "miss", "false", "double")
_AT_ONCE = 12  # trials on one simulator: boards come from reset in every phase
_PIXEL_S = 0.4  # the longest pixel of a trial
_LINE_PX = 4
_SAME = 0.3  # of a clock period: lines that begin so near each other begin on one edge
_REST_S = (0.001, 10.0)
_FLAW_S = 1.5  # a flaw comes within so long after the boards are loaded
_LOWEST_HZ, _HIGHEST_HZ = 2.0, 5000.0
_PPM = 300


@dataclass(frozen=True)
class StartsPlan:
    """So many starts; `boards` are the kinds to choose from."""

    boards: tuple[str, ...]
    starts: int
    seed: int = 1


@dataclass
class StartsOutcome:
    """What happened. `complaints` is empty if every promise was kept."""

    plan: StartsPlan
    starts: int = 0
    together: int = 0
    named: int = 0  # refused or stopped, and nothing had moved
    named_moved: int = 0  # stopped, or told at the end, when something had moved
    reasons: dict[str, int] = field(default_factory=dict)
    apart_edges: float = 0.0  # the largest distance of lines that began together, in clock periods
    complaints: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class StartsTrial:
    """One start."""

    sync: str
    hz: int
    dividers: tuple[int, ...]
    rest_s: float | None  # the clock rests for so long before it comes back; None: it runs on
    back_s: float  # the clock comes back so long after the start has begun
    flaw: str
    flawed: int  # board
    flaw_s: float  # after the boards are loaded
    phase: float  # of a false edge in its period
    heavy: bool  # ramps on the other axes

    @property
    def text(self) -> str:
        """All of it in words."""
        rest = "runs on" if self.rest_s is None else f"rests {self.rest_s:.3f}+{self.back_s:.3f} s"
        flaw = f", {self.flaw} at board {self.flawed} after {self.flaw_s:.3f} s"
        return (
            f"sync {self.sync}, {self.hz} Hz, dividers {self.dividers}, clock {rest}"
            f"{'' if self.flaw == 'none' else flaw}{', ramps' if self.heavy else ''}"
        )


def make(rng: random.Random, count: int) -> StartsTrial:
    """Return a random trial for so many boards."""
    hz = round(_LOWEST_HZ * (_HIGHEST_HZ / _LOWEST_HZ) ** rng.random())
    most = max(1, min(100, int(hz * _PIXEL_S)))
    least = min(most, -(-hz // 2000))  # pixels of 2 kHz at most: more is not the boards' promise
    one = max(least, int(most ** rng.random()))
    mixed = tuple(max(least, int(most ** rng.random())) for _ in range(count))
    low, high = _REST_S
    return StartsTrial(
        rng.choice(SYNCS),
        hz,
        mixed if rng.random() < 0.4 else (one,) * count,
        low * (high / low) ** rng.random() if rng.random() < 0.5 else None,
        rng.random() * 0.8,
        rng.choice(FLAWS),
        rng.randrange(count),
        rng.random() * _FLAW_S,
        0.02 + 0.96 * rng.random(),
        rng.random() < 0.4,
    )


class StartsWorld:
    """The simulator's time, in which things happen at instants to come."""

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._then: list[tuple[float, Callable[[], None]]] = []

    def now_s(self) -> float:
        """Return simulated seconds since the start."""
        return self._simulator.cycle / self._simulator.tick_hz

    def later(self, seconds: float, action: Callable[[], None]) -> None:
        """Do something in so many seconds, or when time passes next after that."""
        self._then.append((self.now_s() + seconds, action))
        self._then.sort(key=lambda item: item[0])

    def forget(self) -> None:
        """Nothing more is to come."""
        self._then.clear()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        end_s = self.now_s() + seconds
        while self._then and self._then[0][0] <= end_s:
            at_s, action = self._then.pop(0)
            if at_s > self.now_s():
                self._simulator.wait_s(at_s - self.now_s())
            action()
        if end_s > self.now_s():
            self._simulator.wait_s(end_s - self.now_s())


def run_plan(plan: StartsPlan, progress: Progress = unseen) -> StartsOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = StartsOutcome(plan)
    rng = random.Random(f"starts {plan.seed}")
    while outcome.starts < plan.starts:
        names = [rng.choice(plan.boards) for _ in range(rng.choice((2, 2, 3)))]
        with (
            tempfile.TemporaryDirectory(prefix="pixstep-") as folder,
            StartsBench(names, Path(folder) / "edges.csv", rng) as bench,
        ):
            for _ in range(min(_AT_ONCE, plan.starts - outcome.starts)):
                bench.start_once(make(rng, len(names)), outcome)
                outcome.starts += 1
                progress(outcome.starts / plan.starts)
    return outcome


class StartsBench:
    """Some boards on one clock and one bus."""

    def __init__(self, names: list[str], edges: Path, rng: random.Random) -> None:
        images = [(name, natives.image(name)) for name in names]
        self._options = SimOptions(
            images, Fraction(100), pixel_ppm=rng.uniform(-_PPM, _PPM),
            pixel_jitter_ns=rng.choice((0, 0, 900)), seed=rng.randrange(1, 1 << 30), edges=edges,
        )  # fmt: skip
        self._names, self._edges, self._rng = names, edges, rng

    def __enter__(self) -> "StartsBench":
        self.link = SimLink(self._options)
        self.sim = self.link.simulator
        try:
            self.world = StartsWorld(self.sim)
            self._give_addresses()
            self.sim.flush()
            self.log = self._edges.open(encoding="utf-8")
            self.log.readline()
        except BaseException:
            self.sim.kill()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.log.close()
        self.sim.kill()

    def _give_addresses(self) -> None:
        """Find the boards at the addresses that the simulator has given them."""
        self.boards = [self.link.board(unit) for unit in range(1, len(self._names) + 1)]
        for board in self.boards:
            board.who()
            board.write_setting("bus_timeout_ms", 60_000)

    def start_once(self, trial: StartsTrial, outcome: StartsOutcome) -> None:
        """Load, start, follow, judge, and make the boards ready again."""
        where = f"start {outcome.starts} ({'+'.join(self._names)}): {trial.text}"
        why = ""
        try:
            group = self._load(trial)
        except BoardError as error:
            outcome.complaints.append(f"{where}: cannot be loaded: {error}")
            self._recover()
            return
        self._new_edges()
        self._disturb(trial)
        try:
            started = together.start(group, self.world)
            run.follow(group, self.world)
            started.compare(self.world)
        except BoardError as error:
            why = str(error)
        self.sim.clock("on")
        self.world.forget()
        self.world.wait(2 * _PIXEL_S if not why else 0.02)
        self._judge(trial, outcome, where, why)
        self._recover()

    def _load(self, trial: StartsTrial) -> list[LinesOfBoard]:
        """Give the boards clock and lines; a lock has measured its clock then."""
        self.sim.clock(f"hz {trial.hz}")
        for board, divider in zip(self.boards, trial.dividers, strict=True):
            board.write_setting("divider", 1)  # any frequency will do then
            board.set_pixel_hz(Fraction(trial.hz))
            board.write_setting("divider", divider)
            board.write_setting("sync", regs.SYNCS[trial.sync])
        group = []
        for board, divider in zip(self.boards, trial.dividers, strict=True):
            axes = list(range(board.who().axis_count)) if trial.heavy else [0]
            for axis in axes:
                self._upload(board, axis, trial.hz / divider)
            group.append(LinesOfBoard(board, axes))
        for board in self.boards:
            if trial.sync == "lock":
                snapshot.await_measured(board, self.world, 1 / trial.hz)
        return group

    def _upload(self, board: Device, axis: int, pixel_hz: float) -> None:
        """Load a line whose first step tells when it began: of the first axis a plain one."""
        most = max(1, int(min(40, 4000 / pixel_hz)))
        line = Line((self._steps(axis, most),) * _LINE_PX, PLAIN)
        if axis and most >= 8:
            line = Line((1, 3, 5, 5, 3, 1), SMOOTH)
        LineUpload(board, axis, queue_entries(line)).push()

    @staticmethod
    def _steps(axis: int, most: int) -> int:
        return max(1, most - axis)

    def _disturb(self, trial: StartsTrial) -> None:
        """Let the clock rest and come back, and flaw one board's pin."""
        if trial.rest_s is not None:
            self.sim.clock("off")
            self.world.wait(trial.rest_s)
            self.world.later(trial.back_s, lambda: self.sim.clock("on"))
        flaws = {
            "miss": lambda: self.sim.edge(trial.flawed, "miss 1"),
            "false": lambda: self.sim.edge(trial.flawed, "pulse"),
            "double": lambda: self.sim.edge(trial.flawed, f"add 1 {round(1000 * trial.phase)}"),
        }
        if trial.flaw in flaws:
            self.world.later(trial.flaw_s, flaws[trial.flaw])

    def _judge(self, trial: StartsTrial, outcome: StartsOutcome, where: str, why: str) -> None:
        """Compare where lines began, by their first STEP edges."""
        firsts = self._new_edges()
        if why:
            reason = "".join("#" if letter.isdigit() else letter for letter in why)
            outcome.reasons[reason] = outcome.reasons.get(reason, 0) + 1
            if firsts:
                outcome.named_moved += 1
            else:
                outcome.named += 1
            return
        if len(firsts) != len(self.boards):
            outcome.complaints.append(
                f"{where}: only boards {sorted(firsts)} moved, nobody says so"
            )
            return
        period = self.sim.tick_hz / trial.hz
        zeros = []
        for index, divider in enumerate(trial.dividers):
            most = max(1, int(min(40, 4000 * divider / trial.hz)))
            zeros.append((firsts[index] - period * divider / self._steps(0, most)) / period)
        apart = max(zeros) - min(zeros)
        if apart > _SAME:
            outcome.complaints.append(f"{where}: began {apart:.2f} clock periods apart in silence")
            return
        outcome.together += 1
        outcome.apart_edges = max(outcome.apart_edges, apart)

    def _new_edges(self) -> dict[int, int]:
        """Return the cycle of the first STEP edge of each board's axis 0 since the last call."""
        self.sim.flush()
        firsts: dict[int, int] = {}
        for row in self.log:
            cycle, board, axis, signal, level = row.split(",")
            if signal == "STEP" and level.strip() == "1" and axis == "0":
                firsts.setdefault(int(board), int(cycle))
        return firsts

    def _recover(self) -> None:
        """Stop everything and forget lines and faults."""
        for board in self.boards:
            axes = list(range(board.who().axis_count))
            for name in ("stop", "clear_fault", "discard"):
                with contextlib.suppress(BoardError):
                    board.command(name, axes)
                self.world.wait(0.01)
