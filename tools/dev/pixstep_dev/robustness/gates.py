# SPDX-License-Identifier: MIT
"""Lines on a gated pixel clock: bursts of edges with rests between them, one line a burst.

A trial queues lines one behind the other on the axes of a board, arms them while the clock rests,
and lets the bursts come. Every line must begin on its edge of its own burst, and each of its pixels
must end on the clock's edge. A trial may have a flaw: a burst that is too short, an edge that is
missing, a false edge in a rest. Then

    right       every pixel edge of every line was where it belongs
    named       the board latched a fault
    silent      a line was elsewhere, and the board said `done`: a complaint

The first edge of a burst is missing only where the burst ends with its line's last edge: else
nobody can tell. A trial without a flaw must be right. One whose rest and lead-in leave a board too
little time from one line to the next may end in `start_late`.
"""

import random
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import accumulate
from pathlib import Path
from typing import TextIO

from pixstep import natives
from pixstep.board import boards, run, snapshot
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import queue_entries
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

SYNCS = ("start", "lock")
FLAWS = ("none", "none", "none", "short", "missing", "first", "false")
LATE = "start_late"
DRY = "queue ran dry"  # the campaign was too slow: axes are no longer on one line
# From the last edge of a line to the edge that gives the next one its place: so much is enough.
ENOUGH_S = 0.04
_HZ = (100, 2000)
_REST_S = (0.001, 5.0)
_MOST_LEAD_S = 0.08
_STEPS_S = 8000  # of an axis: other campaigns look for the highest rates
_RAMP = (1, 3, 5)
_EDGE_TICKS = 2.5  # two of a lock, and half of one by the phase, which is new after a rest
_STARTED_TICKS = 4  # one each of the pin, the capture, the way to line zero, the grid
_PPM = 300
_PLACE_S = 0.0052  # a line gets its place so long before line zero, or an edge more
_JITTER_NS = 900
_NEAR = 0.3  # of a clock period: a pixel that ends so near an edge ends on it


@dataclass(frozen=True)
class GatesPlan:
    """So many trials of so many lines of so many pixels on a board."""

    board: str
    trials: int
    lines: int = 10
    pixels: int = 512
    seed: int = 1
    flaws: tuple[str, ...] = FLAWS
    rest_s: tuple[float, float] = _REST_S


@dataclass
class GatesOutcome:
    """What happened. `complaints` is empty if every promise was kept."""

    plan: GatesPlan
    trials: int = 0
    right: int = 0
    named: int = 0
    lines: int = 0  # that were right
    pixels: int = 0  # whose ends were compared
    off_ticks: float = 0.0  # the largest distance of a locked pixel's end from the clock's edge
    late_s: float = 0.0  # the longest time that was not enough for the next line
    faults: dict[str, int] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class GatesTrial:
    """Some lines on some bursts."""

    sync: str
    hz: int
    divider: int
    lines: tuple[Line, ...]  # of each axis, again and again
    count: int
    gate_edges: int
    spare_edges: int  # of a burst, behind the line's last one
    rest_s: float
    flaw: str
    burst: int  # that has the flaw
    at: float  # where in it, or how many edges it lacks

    @property
    def line_edges(self) -> int:
        """Clock edges from line zero to the last pixel's end."""
        return self.lines[0].pixels * self.divider

    @property
    def hold_over(self) -> int:
        """Missing edges that are bridged: a rest inside a line must be longer, to be no gap."""
        return 4 if self.rest_s * self.hz > 5 else 0

    @property
    def edges(self) -> int:
        """Edges of a burst."""
        return self.gate_edges + self.line_edges + 1 + self.spare_edges

    @property
    def text(self) -> str:
        """All of it in words."""
        flaw = (
            "" if self.flaw == "none" else f", {self.flaw} in burst {self.burst} at {self.at:.3f}"
        )
        return (
            f"sync {self.sync}, {self.hz} Hz, divider {self.divider}, {len(self.lines)} axes, "
            f"{self.count} lines of {self.lines[0].pixels} pixels, gate_edges {self.gate_edges}, "
            f"{self.spare_edges} edges to spare, rests of {1000 * self.rest_s:.2f} ms{flaw}"
        )


def make(rng: random.Random, plan: GatesPlan, axes: int, tick_hz: int) -> GatesTrial:
    """Return a random trial."""
    sync = rng.choice(SYNCS)
    hz = round(_HZ[0] * (_HZ[1] / _HZ[0]) ** rng.random())
    divider = rng.choice([1, 1, 1] + [edges for edges in (2, 5) if hz / edges >= _HZ[0]])
    flaw = rng.choice(plan.flaws)
    least = boards.least_gate_edges(Fraction(hz), tick_hz, locked=sync == "lock")
    low, high = plan.rest_s
    rest_s = low * (high / low) ** rng.random()
    # A rest is seen that is longer than a sixteenth of the period.
    rest_s = max(rest_s, 0.125 / hz)
    return GatesTrial(
        sync,
        hz,
        divider,
        tuple(_lines(rng, plan.pixels, hz / divider, rng.randint(1, axes))),
        plan.lines,
        least + int(rng.random() * _MOST_LEAD_S * hz),
        0 if flaw in ("short", "first") else rng.choice((0, 0, 3, 40)),
        rest_s,
        flaw,
        rng.randrange(plan.lines),
        rng.random(),
    )


def _lines(rng: random.Random, pixels: int, pixel_hz: float, axes: int) -> Iterator[Line]:
    """Yield a line for each axis; those of the others may be over before that of the first."""
    yield _line(rng, pixels, pixel_hz)
    for _ in range(axes - 1):
        yield _line(rng, rng.choice((pixels, max(8, pixels * 2 // 3))), pixel_hz)


def _line(rng: random.Random, pixels: int, pixel_hz: float) -> Line:
    """Return a line of one speed, or one with ramps."""
    most = max(1, int(_STEPS_S / pixel_hz))
    if most > 2 * len(_RAMP) and pixels > 2 * len(_RAMP) and rng.random() < 0.4:
        counts = (*_RAMP, *(6,) * (pixels - 2 * len(_RAMP)), *_RAMP[::-1])
        return Line(counts, SMOOTH)
    return Line((rng.randint(1, min(most, 80)),) * pixels, PLAIN)


def run_plan(plan: GatesPlan, progress: Progress = unseen) -> GatesOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = GatesOutcome(plan)
    rng = random.Random(f"gates {plan.seed}")
    while outcome.trials < plan.trials:
        with (
            tempfile.TemporaryDirectory(prefix="pixstep-") as folder,
            GatesBench(plan.board, Path(folder), rng) as bench,
        ):
            bench.once(make(rng, plan, bench.axes, bench.sim.tick_hz), outcome)
        outcome.trials += 1
        progress(outcome.trials / plan.trials)
    return outcome


class GatesBench:
    """A board on a clock that has run for some time."""

    def __init__(self, board: str, folder: Path, rng: random.Random) -> None:
        self._name, self._folder = board, folder
        self._jitter_ns = rng.choice((0, 0, _JITTER_NS))
        self._ppm = rng.uniform(-_PPM, _PPM)
        self._seed = rng.randrange(1, 1 << 30)

    def __enter__(self) -> "GatesBench":
        self.link = SimLink(
            SimOptions(
                [(self._name, natives.image(self._name))], Fraction(100), pixel_ppm=self._ppm,
                pixel_jitter_ns=self._jitter_ns, seed=self._seed, edges=self._folder / "edges.csv",
                clock_log=self._folder / "clock.csv",
            )
        )  # fmt: skip
        self.sim = self.link.simulator
        try:
            self.board: Device = self.link.board(1)
            self.axes = self.board.who().axis_count
            self.board.require(boards.GATE_FEATURE)
        except BaseException:
            self.sim.kill()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.sim.kill()

    def once(self, trial: GatesTrial, outcome: GatesOutcome) -> None:
        """Run the lines of a trial and judge them."""
        where = f"trial {outcome.trials}: {trial.text}"
        try:
            self._set_up(trial)
            begun = self._begin(trial)
            fault = self._follow(trial)
        except BoardError as error:
            outcome.complaints.append(f"{where}: {error}")
            return
        self.sim.flush()
        try:
            self._judge(trial, begun, outcome, whole=not fault)
        except AssertionError as wrong:
            if not fault:
                outcome.complaints.append(f"{where}: in silence: {wrong}")
                return
            if trial.flaw == "none":
                outcome.complaints.append(f"{where}: {wrong}, fault {fault}")
                return
        if not fault:
            outcome.right += 1
            return
        outcome.named += 1
        outcome.faults[fault] = outcome.faults.get(fault, 0) + 1
        self._excuse(trial, fault, outcome, where)

    def _excuse(self, trial: GatesTrial, fault: str, outcome: GatesOutcome, where: str) -> None:
        """Complain of a fault that nothing explains."""
        least = boards.least_gate_edges(Fraction(trial.hz), self.sim.tick_hz, locked=False)
        time_s = trial.rest_s + (1 + trial.spare_edges + trial.gate_edges - least) / trial.hz
        if fault == DRY:
            return
        if fault == LATE and time_s < ENOUGH_S:
            outcome.late_s = max(outcome.late_s, time_s)
        elif trial.flaw == "none":
            outcome.complaints.append(f"{where}: fault {fault} ({1000 * time_s:.1f} ms)")

    def _set_up(self, trial: GatesTrial) -> None:
        """Give the board its clock and the first lines."""
        self.sim.clock(f"hz {trial.hz}")
        board = self.board
        board.write_setting("bus_timeout_ms", 0)
        board.set_pixel_hz(Fraction(trial.hz))
        board.write_setting("divider", trial.divider)
        board.write_setting("sync", regs.SYNCS[trial.sync])
        board.write_setting("gate_edges", trial.gate_edges)
        board.write_setting("record_every", 10_000)
        board.write_setting("hold_over_edges", trial.hold_over)
        if trial.sync == "lock":
            snapshot.await_measured(board, self.link.world, 1 / trial.hz, 3000)
        self.sim.clock("off")
        self.link.world.wait(0.01 + 3 / trial.hz)
        self._queued = [0] * len(trial.lines)
        self._feed(trial)

    def _begin(self, trial: GatesTrial) -> int:
        """Arm the lines, and let the bursts begin; return the cycle."""
        run.arm(self.board, list(range(len(trial.lines))))
        self.link.world.wait(0.06)
        edges = trial.edges
        if trial.flaw == "short":
            edges -= 1 + int(trial.at**3 * trial.line_edges)
        self.sim.clock(f"gate {edges} {round(1e6 * trial.rest_s)}")
        place = trial.burst * edges
        if trial.flaw == "missing":
            self.sim.edge(
                0, f"miss {place + 2 + int(trial.at * (trial.edges - trial.spare_edges - 2))}"
            )
        if trial.flaw == "first":
            self.sim.edge(0, f"miss {place + 1}")
        begun = self.sim.cycle
        self.sim.clock("on")
        if trial.flaw == "false":
            self._false_edge(trial, begun)
        return begun

    def _false_edge(self, trial: GatesTrial, begun: int) -> None:
        """Put a false edge into the rest before a burst, where nobody can take it for a true one.

        One that comes a period before the burst, but for a sixteenth, is a first edge.
        """
        period_s = 1 / (trial.hz * (1 + self._ppm * 1e-6))
        gap_s = trial.rest_s + period_s
        before_s = trial.at * gap_s
        if 0.9 * period_s < before_s < 1.1 * period_s:
            before_s = 0.5 * period_s
        burst_s = (trial.edges - 1) * period_s + gap_s
        first = self._first_edge(begun)
        at = first + round((max(1, trial.burst) * burst_s - before_s) * self.sim.tick_hz)
        self.sim.edge(0, "pulse", at)

    def _first_edge(self, begun: int) -> int:
        """Return the cycle of the first burst's first edge, once it has come."""
        while True:
            self.link.world.wait(0.005)
            self.sim.flush()
            true = _true_edges(self._folder / "clock.csv", begun)
            if true:
                return round(true[0])

    def _feed(self, trial: GatesTrial) -> None:
        """Keep the queues full of lines."""
        for axis, line in enumerate(trial.lines):
            entries = queue_entries(line)
            while self._queued[axis] < trial.count:
                if self.board.axis(axis)["queue_free"] < len(entries):
                    break
                LineUpload(self.board, axis, entries).push()
                self._queued[axis] += 1

    def _follow(self, trial: GatesTrial) -> str:
        """Feed the queues until all is over; return the name of the fault, "" if there is none."""
        burst_s = trial.edges / trial.hz + trial.rest_s
        end_s = self.link.world.now_s() + trial.count * burst_s + 2 * burst_s + 1
        moving = True
        while moving and self.link.world.now_s() < end_s:
            self.link.world.wait(min(0.2, burst_s / 2))
            try:
                self._feed(trial)
            except BoardError:  # a fault takes no line any more
                break
            moving = self.board.moving()
        self.link.world.wait(0.05)
        code = self.board.input("fault_code")
        if code:
            return regs.code_name(regs.faults(), code)
        # The line came when the one before was over: it is there, and nobody has armed it.
        states = run.states(self.board, list(range(len(trial.lines))))
        return DRY if "loaded" in states.values() else ""

    def _judge(self, trial: GatesTrial, begun: int, outcome: GatesOutcome, *, whole: bool) -> None:
        """Compare the ends of all pixels with the clock's edges; of lines that are whole."""
        true = _true_edges(self._folder / "clock.csv", begun)
        steps = _steps(self._folder / "edges.csv", len(trial.lines))
        edges = trial.edges
        if trial.flaw == "short":
            edges -= 1 + int(trial.at**3 * trial.line_edges)
        for axis, line in enumerate(trial.lines):
            ends = list(accumulate(map(abs, line.counts)))
            made = len(steps[axis]) // ends[-1]
            assert not whole or made == trial.count, f"axis {axis}: {made} lines"
            for number in range(made):
                zero = number * edges + trial.gate_edges
                mine = steps[axis][number * ends[-1] : (number + 1) * ends[-1]]
                due = true[zero : zero + line.pixels * trial.divider + 1 : trial.divider]
                assert len(due) == line.pixels + 1, f"axis {axis}, line {number}: the clock is over"
                if trial.sync == "start":  # from line zero on it keeps to the board's own time
                    pixel = self.sim.tick_hz * trial.divider / trial.hz
                    due = [due[0] + pixel * place for place in range(len(due))]
                off = [mine[done - 1] - edge for done, edge in zip(ends, due[1:], strict=True)]
                self._compare(trial, off, outcome, f"axis {axis}, line {number}")
                outcome.lines += 1

    def _compare(
        self, trial: GatesTrial, off: list[float], outcome: GatesOutcome, what: str
    ) -> None:
        """Compare the pixels' distances from the clock's edges with what the clock allows."""
        worst = max(off, key=abs)
        periods = worst / self.sim.tick_hz * trial.hz
        assert abs(periods) < _NEAR, f"{what}: {periods:.2f} clock periods off"
        outcome.pixels += len(off)
        if trial.flaw != "none":
            return
        jitter = self._jitter_ns * 1e-9 * self.sim.tick_hz
        if not jitter and trial.sync == "lock":
            outcome.off_ticks = max(outcome.off_ticks, abs(worst))
        most = (_STARTED_TICKS if trial.sync == "start" else _EDGE_TICKS) + 2 * jitter
        if trial.sync == "start":  # from the edge that places line zero by nominal periods
            most += abs(self._ppm) * 1e-6 * (_PLACE_S + 1 / trial.hz) * self.sim.tick_hz
        assert abs(worst) <= most, f"{what}: {worst:.1f} ticks off"


def _rows(path: Path) -> Iterator[list[str]]:
    with path.open(encoding="utf-8") as file:
        yield from _cells(file)


def _cells(file: TextIO) -> Iterator[list[str]]:
    file.readline()
    for row in file:
        yield row.rstrip("\n").split(",")


def _true_edges(path: Path, begun: int) -> list[float]:
    """Return where the true edges behind a cycle belong, missing ones included."""
    true = (int(row[1]) / 1000 for row in _rows(path) if len(row) == 3 and row[2] != "false")
    return [cycle for cycle in true if cycle >= begun]


def _steps(path: Path, axes: int) -> list[list[int]]:
    """Return the cycles of the rising STEP edges by axis."""
    found: list[list[int]] = [[] for _ in range(axes)]
    for row in _rows(path):
        if len(row) == 5 and row[3] == "STEP" and row[4] == "1" and int(row[2]) < axes:
            found[int(row[2])].append(int(row[0]))
    return found
