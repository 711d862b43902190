# SPDX-License-Identifier: MIT
"""Emergency stops at random cycles: where the last STEP edge is, and what the board says of it.

Every axis runs a line of its own. The stop is pressed at a random cycle; then

    trip         trip + ESTOP_CYCLES
      |............|
      edges         at most one more edge of each axis: of the period that its timer held
      permit off

and the position that the board reports is the number of edges that the simulator counted.
"""

import random
import tempfile
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import queue_entries
from pixstep.lines.units import period_ticks
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_trials.promises import ESTOP_CYCLES

PIXEL_HZ = Fraction(100)
_LINE_PX = 30
_SETTLE_S = 0.01
_AT_ONCE = 100  # stops on one simulator: its list of edges stays short


@dataclass(frozen=True)
class EstopsPlan:
    """So many emergency stops of one board."""

    board: str
    stops: int
    seed: int = 1


@dataclass
class EstopsOutcome:
    """What happened. `complaints` is empty if every promise was kept."""

    plan: EstopsPlan
    stops: int = 0
    moving: int = 0  # stops that met at least one axis in motion
    latest_cycles: int = 0  # the last edge but one, behind the trip, at most
    permit_cycles: int = 0  # the permit's end, behind the trip, at most
    edges: int = 0
    complaints: list[str] = field(default_factory=list)


def line(rng: random.Random, board: str) -> Line:
    """Return a random line: even speed, or up and down, plain or smooth."""
    limits = boards.load(board)
    ticks = period_ticks(PIXEL_HZ, limits.tick_hz)
    if rng.random() < 0.6:
        most = int(ticks / limits.min_interval_ticks)
        count = max(1, int(most ** rng.random()))
        return Line((rng.choice((-1, 1)) * count,) * _LINE_PX, PLAIN)
    top = max(4, int(ticks / steady_smooth_ticks(limits) * rng.random()) // 4 * 4)
    rise = (top // 4, top * 3 // 4)
    counts = (*rise, *(top,) * (_LINE_PX - 4), *reversed(rise))
    return Line(counts, SMOOTH, negative=rng.random() < 0.5)


def steady_smooth_ticks(board: boards.BoardKind) -> int:
    """Return an interval of smooth lines that all axes of a board keep up with at once."""
    return 300 if board.axes == 1 else 400 * board.axes


def run(plan: EstopsPlan, progress: Progress = unseen) -> EstopsOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = EstopsOutcome(plan)
    rng = random.Random(f"{plan.seed} {plan.board}")
    while outcome.stops < plan.stops:
        with (
            tempfile.TemporaryDirectory(prefix="pixstep-") as folder,
            Stopper(plan.board, Path(folder) / "edges.csv") as stopper,
        ):
            for _ in range(min(_AT_ONCE, plan.stops - outcome.stops)):
                stopper.stop_once(rng, outcome)
                outcome.stops += 1
                progress(outcome.stops / plan.stops)
    return outcome


class Stopper:
    """A board with its stop's pin in hand."""

    def __init__(self, board: str, edges: Path) -> None:
        self._name, self._edges = board, edges
        self._table = boards.load(board)
        pin = next(pin for pin in self._table.pins if pin.signal == "ESTOP")
        self._pin = (pin.port, pin.bit)
        self.axes = list(range(self._table.axes))

    def __enter__(self) -> "Stopper":
        run = SimulatedBoard(self._name, PIXEL_HZ, edges=self._edges)
        self.sim, self.board = run.simulator, run.board
        try:
            self.board.set_pixel_hz(PIXEL_HZ)
            self.sim.command("flush")
            self.log = self._edges.open(encoding="utf-8")
            self.log.readline()
        except BaseException:
            self.sim.kill()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.log.close()
        self.sim.kill()

    def stop_once(self, rng: random.Random, outcome: EstopsOutcome) -> None:
        """Run lines, press the stop somewhere, judge, and make the board ready again."""
        self._start(rng)
        trip = self.sim.cycle + rng.randrange(_LINE_PX * int(self.sim.tick_hz / PIXEL_HZ))
        self.press(trip)
        where = f"stop {outcome.stops} at cycle {trip}"
        try:
            self.judge(trip, outcome, where)
            self.recover()
        except BoardError as error:
            outcome.complaints.append(f"{where}: {error}")

    def _start(self, rng: random.Random) -> None:
        board = self.board
        board.command("permit_on", [])
        for axis in self.axes:
            LineUpload(board, axis, queue_entries(line(rng, self._name))).push()
        board.command("arm", self.axes)

    def press(self, trip: int) -> None:
        """Press the stop at this cycle to come, and let the board come to rest."""
        self.sim.pin(0, *self._pin, 0, at=trip)
        self.sim.run(trip - self.sim.cycle + self.sim.cycles(_SETTLE_S))

    def judge(self, trip: int, outcome: EstopsOutcome, where: str) -> None:
        """Compare what the board says of a stop with what the simulator has seen."""
        complain = outcome.complaints.append
        permit = self.sim.permit(0)
        fault = regs.code_name(regs.faults(), self.board.input("fault_code"))
        if fault != "estop":
            complain(f"{where}: fault {fault}")
        if permit.level or not trip <= permit.cycle <= trip + ESTOP_CYCLES:
            complain(f"{where}: permit {permit.level} since cycle {permit.cycle}")
        outcome.permit_cycles = max(outcome.permit_cycles, permit.cycle - trip)
        late = self._late_edges(trip, outcome)
        outcome.moving += any(edges for edges in late.values())
        for axis, edges in late.items():
            outcome.latest_cycles = max([outcome.latest_cycles, *edges[:-1]])
            if sum(edge > ESTOP_CYCLES for edge in edges) > 1:
                complain(f"{where}: axis {axis}: edges {edges} cycles behind it")
            seen, made = self.board.axis(axis)["position_steps"], self.sim.steps(0, axis)
            if seen != made:
                complain(f"{where}: axis {axis}: position {seen}, {made} steps made")

    def _late_edges(self, trip: int, outcome: EstopsOutcome) -> dict[int, list[int]]:
        """Return the STEP edges of each axis from the trip on, in cycles behind it."""
        self.sim.command("flush")
        late: dict[int, list[int]] = {axis: [] for axis in self.axes}
        for row in self.log:
            cycle, _, axis, signal, level = row.split(",")
            if signal == "STEP" and level.strip() == "1":
                outcome.edges += 1
                if int(cycle) > trip:
                    late[int(axis)].append(int(cycle) - trip)
        return late

    def recover(self) -> None:
        """Release the stop, clear its fault and forget the lines."""
        self.sim.pin(0, *self._pin, 1)
        self.sim.wait_s(0.001)
        self.board.command("clear_fault", [])
        self.board.command("discard", self.axes)
