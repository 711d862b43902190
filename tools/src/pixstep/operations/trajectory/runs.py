# SPDX-License-Identifier: MIT
"""Tables run: by a modelled machine, on two axes of a simulated board, on a board."""

from __future__ import annotations

from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any, NotRequired, TypedDict

from pixstep.board import boards, capability, settings, upload
from pixstep.board.capability import connected_limits
from pixstep.board.run import LinesOfBoard
from pixstep.lines.units import refuse_period, ticks_text
from pixstep.operations import bus, reading_lines, shared
from pixstep.operations.asked import AskedError
from pixstep.operations.board.lines import QueuedLines, check_lines, run_lines
from pixstep.operations.board.records import RecordFields, recorded
from pixstep.operations.bus import ToBoard
from pixstep.operations.clocks import BoardLineClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Choice, Steps
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.operations.run import simulated_result
from pixstep.operations.trajectory import fields
from pixstep.operations.trajectory.fields import BoardPlayFields, GivenScale, PlayFields
from pixstep.simulation.report import new_table, print_verdict
from pixstep.trajectories import circle_test, runs, transitions
from pixstep.trajectories.circle import Circle, RoundnessData, TableTrace, Unit, roundness_of
from pixstep.trajectories.circle_test import RUNS, CircleSummary, CircleTest, RunSummary
from pixstep.trajectories.runs import COMPENSATED, BoardJob
from pixstep.trajectories.table import AXES, TwoAxisTable

_BOTH = "both"


def _which() -> Any:
    return option(
        Choice([*RUNS, _BOTH]), "The table as it is, compensated, or both, one after the other.",
        "--run", default=_BOTH,
    )  # fmt: skip


def _chosen(which: str) -> tuple[str, ...]:
    return RUNS if which == _BOTH else (which,)


class ModelledRun(TypedDict):
    """What the load of a modelled machine did."""

    max_load_error_counts: list[float]
    max_following_error_counts: list[float]
    roundness: NotRequired[RoundnessData]


class ShownTable(TypedDict):
    """What is in a table; its top speeds are in counts a point."""

    file: str
    records: int
    holds: int
    circle: dict[str, int] | None
    top_speed: list[int]
    runs: dict[str, ModelledRun]


@operation("trajectory show")
class TrajectoryShow(PlayFields):
    """Show what is in a table and, with --play, what the load of a modelled machine does.

    The model has the play, and a servo of --bandwidth; radius errors are those at the points.
    """

    result = ShownTable

    table: Path = fields.table_argument()
    which: str = _which()
    pixel_hz: Fraction | None = shared.pixel_hz("Points a second, for --bandwidth.", required=False)
    scale: GivenScale | None = fields.scale()
    plot: Path | None = shared.picture()

    def run(self, desk: Desk) -> Result:
        """Read the table and run the model."""
        original = fields.read_table(desk, self.table)
        found = fields.find_circle(original)
        traces = self._modelled(original) if self.play or self.plot else []
        unit = fields.unit_of(self.scale)
        data: ShownTable = {
            "file": str(self.table), "records": original.records, "holds": original.holds,
            "circle": asdict(found) if found else None,
            "top_speed": [int(abs(original.counts(axis)).max()) for axis in range(AXES)],
            "runs": {run.name: _model_summary(run, found, unit) for run in traces},
        }  # fmt: skip
        if self.plot:
            along = "seconds" if self.pixel_hz else "points"
            below = f"{original.name} on a modelled machine"
            _draw_model(traces, found, unit, below, along, self.plot)
        return Result(data, lambda page: _write_facts(page, data, unit))

    def _modelled(self, original: TwoAxisTable) -> list[TableTrace]:
        """Return what the load of a modelled machine does."""
        hz = self.pixel_hz
        plays = self.axis_plays(original, hz)
        if self.servo and hz is None:
            raise AskedError(
                "a servo has a bandwidth in time: give {pixel_hz}, or {bandwidth} none"
            )
        point_s = float(1 / hz) if hz else 1.0
        machine = runs.ModelledMachine(tuple(item.play for item in plays), point_s, self.servo)
        return [runs.run_modelled(original, plays, name, machine) for name in _chosen(self.which)]


def _model_summary(run: TableTrace, found: Circle | None, unit: Unit) -> ModelledRun:
    errors = abs(run.load_errors).max(axis=0).tolist()
    lags = abs(run.following_errors).max(axis=0).tolist()
    facts: ModelledRun = {
        "max_load_error_counts": [round(value, 3) for value in errors],
        "max_following_error_counts": [round(value, 3) for value in lags],
    }
    if found:
        facts["roundness"] = roundness_of(run, found).summary(unit)
    return facts


def _draw_model(
    traces: list[TableTrace], found: Circle | None, unit: Unit, below: str, along: str, path: Path
) -> None:
    from pixstep.trajectories import picture  # matplotlib takes a second to load

    if found:
        picture.draw([roundness_of(run, found) for run in traces], unit, below, path)
    else:
        picture.draw_errors(traces, unit, below, path, along)


def _write_facts(page: Page, facts: ShownTable, unit: Unit) -> None:
    """Write what is in a table, and the model's runs."""
    top = " and ".join(map(str, facts["top_speed"]))
    page.tell(
        f"{facts['file']}: {facts['records']} records, {facts['holds']} of them holds, at most "
        f"{top} counts a point"
    )
    found = facts["circle"]
    if found:
        page.tell(
            f"circle: radius {found['radius']} counts, {found['points']} points a revolution, "
            f"{found['revolutions']} revolutions from record {found['start'] + 1} on"
        )
    for name, run in facts["runs"].items():
        if "roundness" in run:
            page.tell(f"{name}: {_roundness_text(run['roundness'], unit)}")
        else:
            loads = " and ".join(f"{value:g}" for value in run["max_load_error_counts"])
            page.tell(f"{name}: load at most {loads} counts off")


def _roundness_text(found: RoundnessData, unit: Unit) -> str:
    return (
        f"radius error at most {unit.text(found['max_radius_error_counts'])} at "
        f"{found['at_degrees']:.1f} degrees, passes {found['passes_apart_counts']:g} counts apart"
    )


@operation("trajectory sim")
class TrajectorySim(BoardPlayFields):
    """Run a table on two axes of a simulated board, and measure the circle that its loads make.

    The one table runs as it is and compensated; hold records are left out. Every edge is judged,
    and the load is looked at at every step of either motor. Exit status 0 only if the verdict is
    pass.
    """

    result = CircleSummary

    table: Path = fields.table_argument()
    which: str = _which()
    board: str = shared.simulated_board()
    axis: tuple[int, ...] = reading_lines.axes()
    pixel_hz: Fraction = shared.pixel_hz()
    plant_play: tuple[int, ...] = option(
        Steps(0), "Play of the simulated axes; once, or per axis.", many=True,
        default_text="--play",
    )  # fmt: skip
    scale: GivenScale | None = fields.scale()
    image: Path | None = shared.image()
    seed: int = shared.seed()
    parquet: bool = flag("Write the measurement records as Parquet.")
    out: Path = shared.out("circle")
    plot: bool = shared.plots()

    def run(self, desk: Desk) -> Result:
        """Run the table in the simulator."""
        original = fields.read_table(desk, self.table).without_holds()
        together = min(AXES, boards.load(self.board).axes)
        able = capability.of(self.board, self.pixel_hz, axes=together)
        most = able.top_speed(capability.PLAIN) - int(abs(original.velocities).max()) - 1
        plays = self.axis_plays(original, self.pixel_hz, most)
        test = CircleTest(
            original,
            plays,
            self._job(desk),
            fields.find_circle(original),
            fields.unit_of(self.scale),
            _chosen(self.which),
            ".parquet" if self.parquet else ".csv",
        )
        with desk.progress("simulating") as show:
            summary = circle_test.simulate(test, self.out, plot=self.plot, progress=show)
        return simulated_result(summary, self.out, _write_summary)

    def _job(self, desk: Desk) -> BoardJob:
        plants = fields.per_axis(self.plant_play or self.play, 0, "plant_play")
        axes = reading_lines.line_axes(self.axis, AXES)
        return BoardJob(
            self.board, self.pixel_hz, tuple(plants), tuple(axes), self.image, self.seed,
            reading_lines.ways(desk.facts, AXES),
        )  # fmt: skip


def _write_summary(page: Page, summary: CircleSummary) -> None:
    """Write the verdict and a row for each run."""
    plays = " and ".join(map(str, summary["play_steps"]))
    points = " and ".join(map(str, summary["transition_points"]))
    about = f"{summary['board']}, {summary['pixel_hz']} Hz, play {plays} steps, taken up in"
    print_verdict(page, summary, f"{about} {points} points")
    table = new_table("run", "ticks", "load off", "radius error", "at", "apart")
    for name, run in summary["runs"].items():
        table.add_row(name, *_cells(run))
    table.caption = (
        "ticks: edge minus exact instant; load off: counts from the\n"
        "table at a pixel edge; radius error: at any step; apart:\n"
        "passes at the same point, counts"
    )
    table.caption_justify = "left"
    page.print(table)


def _cells(run: RunSummary) -> list[str]:
    """Return what is told of a run in a row."""
    ticks = ticks_text(max(axis["max_edge_error_ticks"] for axis in run["edges"]))
    loads = " ".join(map(str, run.get("max_load_error_counts", []))) or "-"
    found = run.get("roundness")
    if not found:
        return [ticks, loads, "-", "-", "-"]
    error = f"{found['max_radius_error']:.6f} {found['unit']}"
    if found["unit"] == "counts":
        error = f"{found['max_radius_error']:.1f} counts"
    apart = f"{found['passes_apart_counts']:g}"
    return [ticks, loads, error, f"{found['at_degrees']:.1f}°", apart]


class TableRun(QueuedLines):
    """A table that a board has run: what was taken up, and in how many points."""

    run: str
    play_steps: list[int]
    transition_points: list[int]


@operation("board trajectory")
class BoardTrajectory(BoardPlayFields, RecordFields, BoardLineClock, ToBoard):
    """Run a table of two axes, with or without its play taken up.

    Hold records are left out. The lines are checked with the board's own limits before anything
    moves, streamed, and followed to their end.
    """

    result = TableRun

    table: Path = fields.table_argument()
    which: str = option(
        Choice(RUNS), "The table as it is, or with its play taken up.", "--run",
        default=COMPENSATED,
    )  # fmt: skip
    take_up: bool = flag(
        "First move back by the play and forward again, so that the play is taken up in the "
        "direction in which each axis begins.",
        off="--no-take-up", default=True,
    )  # fmt: skip
    axis: tuple[int, ...] = reading_lines.axes()

    def run(self, desk: Desk) -> Result:
        """Make the lines of the table, check and run them."""
        self.refuse_file()
        original = fields.read_table(desk, self.table).without_holds()
        motor_ways = reading_lines.ways(desk.facts, AXES)
        ways = tuple(transitions.initial_direction(original, index) for index in range(AXES))
        with bus.one_board(desk, self) as (found, known):
            board = known.board
            axes = reading_lines.line_axes(self.axis, AXES)
            known.axes(tuple(axes))
            hz = settings.pixel_hz(board, self.edges_hz(board), self.divider)
            refuse_period(hz, board.tick_hz())
            clock = settings.of_clock(self.sync, self.divider)
            limits = connected_limits(board, hz, AXES, clock)
            top = int(limits.shortest_ticks) // limits.min_interval_ticks
            most = top - int(abs(original.velocities).max()) - 1
            plays = self.axis_plays(original, hz, most)
            made = runs.command(original, plays, self.which)
            taking_up = self.take_up
            chosen = runs.taking_up(made, plays, ways) if taking_up else runs.lines(made)
            lines = dict(zip(axes, runs.turned(chosen, motor_ways), strict=True))
            check_lines(desk, known, lines, hz, clock)
            upload.require_idle(board, axes)
            self.set_clock(board)
            edges = self.divider or settings.divider(board)
            queues = LinesOfBoard(board, axes)
            with recorded(desk, [queues], self.record_file, wanted=self.record) as records:
                done = run_lines(
                    desk, queues, found.world, lines, edges, records, arm=True, wait=True
                )
        data: TableRun = {
            **done, "run": self.which, "play_steps": [item.play for item in plays],
            "transition_points": [item.steps for item in plays],
        }  # fmt: skip
        texts = [
            f"board {self.unit} axis {row['axis']}: {row['file']}, {row['steps']} steps in "
            f"{row['seconds']:g} s: {row['state']}, position {row['position_steps']}"
            for row in done["axes"]
        ]
        return records.result(data, texts)
