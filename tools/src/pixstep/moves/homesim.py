# SPDX-License-Identifier: MIT
"""Homing on a simulated board with a load and its switches: run it, keep what it left behind."""

from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards
from pixstep.board.errors import BoardError
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import period_ticks
from pixstep.moves.homing import Homed, HomingError, Leg, home
from pixstep.moves.inputs import INVERTED, shared_limits
from pixstep.moves.legs import HomingPlan
from pixstep.progress import Progress, unseen
from pixstep.simulation.edges import AxisEdges, read_edges
from pixstep.simulation.simboard import SimulatedBoard
from pixstep.simulation.simrun import scratch_folder

SETTLE_S = 0.05
OUTPUTS = ("edges.csv", "switches.csv")
HYSTERESIS = 8  # steps, of a simulated home switch unless its knobs say otherwise


@dataclass(frozen=True)
class HomeJob:
    """A homing and the world it happens in; `plant` are the simulator's knobs, "home=2000,..."."""

    plan: HomingPlan
    board: str
    pixel_hz: Fraction
    plant: str
    inverted: str = "none"
    filter_us: int | None = None
    home_is_limit: str = "none"
    seed: int = 1
    scale: units.Scale | None = None  # of the motor, if a machine file gives it

    @property
    def tick_hz(self) -> int:
        """Timer ticks a second of the board."""
        return boards.load(self.board).tick_hz

    @property
    def period(self) -> Fraction:
        """Pixel period, ticks."""
        return period_ticks(self.pixel_hz, self.tick_hz)

    @property
    def knobs(self) -> dict[str, str]:
        """The plant's knobs by name."""
        return dict(word.partition("=")[::2] for word in self.plant.split(","))

    def knob(self, name: str, default: int = 0) -> int:
        """Return a knob that is a whole number; raises UserError if it is none."""
        text = self.knobs.get(name, str(default))
        try:
            return int(text)
        except ValueError:
            raise UserError(f"--plant: {name}={text!r} is not a whole number") from None

    @property
    def home_tripped_level(self) -> int:
        """The pin's level that the board takes for a closed home switch."""
        return INVERTED[self.inverted] & 1

    @property
    def closes_above(self) -> bool:
        """True if the board sees the home switch closed above its place, not below."""
        closed_level = int(self.knobs.get("active") == "high")
        return closed_level == self.home_tripped_level

    @property
    def closes_at(self) -> int | None:
        """The load's position at which the board sees the home switch close, if there is one."""
        if "home" not in self.knobs:
            return None
        return self.knob("home") - (0 if self.closes_above else self.knob("hyst", HYSTERESIS))

    @property
    def travel(self) -> tuple[int, ...]:
        """Where the limit switches trip, minus and plus; empty if there are none."""
        low, _, high = self.knobs.get("travel", "").partition("..")
        try:
            return (int(low), int(high)) if low and high else ()
        except ValueError:
            raise UserError(f"--plant: travel={low}..{high}: two whole numbers") from None


@dataclass
class HomeRun:
    """What a simulated homing left behind; cycles are the simulator's."""

    job: HomeJob
    homed: Homed | None = None
    error: BoardError | None = None
    edges: AxisEdges = field(default_factory=AxisEdges)
    switch_edges: list[tuple[int, int]] = field(default_factory=list)  # (cycle, 1 closed)
    counted_steps: int = 0
    load_steps: int = 0

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The legs made, of a homing that failed too."""
        if self.homed:
            return self.homed.legs
        return self.error.legs if isinstance(self.error, HomingError) else ()


def run(job: HomeJob, out: Path, progress: Progress = unseen) -> HomeRun:
    """Run a homing; leave OUTPUTS in `out`.

    Raises UserError if the simulator cannot run; what the board does wrong is in the result.
    """
    if job.plan.axis >= boards.load(job.board).axes:
        raise UserError(f"axis {job.plan.axis}: the {boards.axes_text(job.board)}")
    out.mkdir(parents=True, exist_ok=True)
    done = HomeRun(job)
    with scratch_folder(out) as folder:
        with SimulatedBoard(
            job.board,
            job.pixel_hz,
            seed=job.seed,
            edges=folder / "edges.csv",
            plants={(0, job.plan.axis): job.plant},
            switch_log=folder / "switches.csv",
        ) as simulated:
            _home(done, simulated, progress)
            simulated.finish()
        for name in OUTPUTS:
            (folder / name).replace(out / name)
    done.edges = read_edges(out / "edges.csv").axis(0, job.plan.axis)
    done.switch_edges = home_edges(out / "switches.csv", job)
    return done


def home_edges(path: Path, job: HomeJob) -> list[tuple[int, int]]:
    """Return (cycle, 1 tripped or 0) of every edge of the home switch, as the board takes it."""
    tripped_level = str(job.home_tripped_level)
    rows = (row.split(",") for row in path.read_text(encoding="ascii").split()[1:])
    wanted = ["0", str(job.plan.axis), "home"]
    return [
        (int(cycle), int(level == tripped_level))
        for cycle, *where, level in rows
        if where == wanted
    ]


def _home(done: HomeRun, simulated: SimulatedBoard, progress: Progress) -> None:
    """Set the board up, home, and ask the simulator where everything is."""
    job, axis, simulator = done.job, done.job.plan.axis, simulated.simulator
    settings = {
        "inputs_inverted": INVERTED[job.inverted],
        "home_is_limit": shared_limits(0, axis, job.home_is_limit),
    }
    if job.filter_us is not None:
        settings["input_filter_us"] = job.filter_us
    try:
        if settings["home_is_limit"]:
            simulated.board.require("shared_switch")
        simulated.set_up(job.pixel_hz, [axis], **settings)
        simulator.wait_s(SETTLE_S)  # the filters see the switches
        world = simulated.link.world
        done.homed = home(simulated.board, job.plan, job.pixel_hz, world, progress)
    except BoardError as error:
        done.error = error
    simulator.wait_s(SETTLE_S)
    done.counted_steps = simulator.steps(0, axis)
    _, done.load_steps = simulator.plant(0, axis)
