# SPDX-License-Identifier: MIT
"""Lines on a simulated board: every edge against its exact instant, and a verdict."""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from pixstep import arguments, outfolder
from pixstep.api import given
from pixstep.api.clocks import ClockErrors, ClockFigures, PixelClock
from pixstep.api.given import Hz
from pixstep.api.motions import MotionLine
from pixstep.api.running import Clocking, Lines
from pixstep.api.running import by_axis as axes_of
from pixstep.api.shown import Facts, Shown, Ticks, count, frame
from pixstep.api.words import BoardKind, Sync
from pixstep.board import boards
from pixstep.errors import PlainError, UserError
from pixstep.lazy import lazy, np, npt
from pixstep.progress import Progress, unseen
from pixstep.simulation.small_pickle import SmallPickle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pixstep.board import guarantee, settings
    from pixstep.simulation import experiment
    from pixstep.simulation import job as sim_job
    from pixstep.simulation.clock_judge import ClockKeeping
    from pixstep.simulation.job import LineExperiment, RunResult
    from pixstep.simulation.judge import AxisLoad, Judgement
    from pixstep.simulation.plots import Trace
    from pixstep.simulation.report import PixelRow
    from pixstep.simulation.summary import Summary
    from pixstep.simulation.verdict import AxisVerdict
else:  # what only a run needs
    guarantee, settings = lazy("pixstep.board.guarantee"), lazy("pixstep.board.settings")
    experiment, sim_job = lazy("pixstep.simulation.experiment"), lazy("pixstep.simulation.job")

_Drawn = TypeVar("_Drawn")


class RunFailedError(PlainError):
    """A simulated run whose verdict is not pass."""


@dataclass(frozen=True, eq=False, repr=False)
class AxisRun(SmallPickle, Shown):
    """What one axis did in a run."""

    axis: int
    """Axis of the board, from 0."""
    line: MotionLine
    """The line that it was given."""
    verdict: str
    """`"pass"` or `"fail"`."""
    reasons: tuple[str, ...]
    """What is wrong; empty for a pass."""
    steps: int
    """STEP edges that the board made."""
    expected_steps: int
    """STEP edges of the line."""
    underruns: int
    """Intervals that came too late."""
    max_edge_error: Ticks
    """Largest distance of an edge from its exact instant; unknown (nan) without an edge."""
    rms_edge_error: Ticks
    """Root mean square of these distances."""
    max_interval_error: Ticks
    """Largest difference of an interval from the exact one."""
    rate_error_ppm: float
    """Error of the step rate over the whole line in ppm."""
    line_zero_cycle: int | None
    """Cycle of the simulation in which the line starts; None if that cannot be told."""
    edge_cycles: npt.NDArray[np.int64]
    """Cycle of every rising STEP edge."""
    edge_errors_ticks: npt.NDArray[np.float64]
    """Edge minus exact instant, in ticks, of every step."""
    pixels: tuple[PixelRow, ...]
    """Each pixel edge: its cycle, the steps that the board expected and those that it made. Where
    no step is due on the edge its cycle is reckoned from a step that is, at the clock's nominal
    period: on a clock that is off, edges of two axes differ by that."""
    clock: ClockErrors | None
    """How its pixels kept to the clock; None of a free line, and of one with too few edges."""

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas: a row an edge.

        Errors are those of steps, and missing (nan) of edges that are not the line's.
        """
        edges = len(self.edge_cycles)
        errors = np.full(edges, math.nan)
        known = self.edge_errors_ticks[:edges]
        errors[: len(known)] = known
        tick_hz = self.max_edge_error.tick_hz
        return frame({
            "cycle": self.edge_cycles, "time_s": self.edge_cycles / tick_hz, "error_ticks": errors,
        })  # fmt: skip

    def _headline(self) -> str:
        made = f"{self.steps:,} of {count(self.expected_steps, 'step')}"
        return f"axis {self.axis}: {self.verdict}, {made}, edges within {self.max_edge_error}"

    def _facts(self) -> Facts:
        yield "line", self.line.line.name
        yield "steps", f"{self.steps:,} of {self.expected_steps:,}"
        yield "largest edge error", self.max_edge_error
        yield "rms edge error", self.rms_edge_error
        yield "largest interval error", self.max_interval_error
        yield "error of the rate", f"{self.rate_error_ppm:.3g} ppm"
        for reason in self.reasons:
            yield "wrong", reason


@dataclass(frozen=True, eq=False, repr=False)
class Run(Shown):
    """A simulated run and its verdict.

    Figures come back as matplotlib Figures: `run.plot_motion().savefig("motion.png")`, or as the
    last line of a notebook's cell.
    """

    verdict: str
    """`"pass"`, `"fail"`, or `"refused"` if the board refused a line."""
    reasons: tuple[str, ...]
    """What is wrong; empty for a pass."""
    board: str
    """Kind of the board."""
    pixel_hz: Fraction
    """Frequency of pixels in Hz."""
    clock: ClockFigures
    """What the pixel clock did, and what the board measured of it."""
    tick_hz: int
    """Ticks of the board's timer a second; a cycle is a tick."""
    axes: tuple[AxisRun, ...]
    """The axes that had a line, by number."""
    summary: Summary
    """All figures, as in summary.json: a dictionary whose keys have types."""
    _traces: Mapping[int, Trace] = field(repr=False)
    _loads: Mapping[int, tuple[LineExperiment, AxisLoad]] = field(repr=False)
    _kept: Mapping[int, tuple[LineExperiment, ClockKeeping]] = field(repr=False)

    @property
    def passed(self) -> bool:
        """True if the verdict is pass."""
        return self.verdict == "pass"

    def raise_if_failed(self) -> Self:
        """Raise RunFailedError with the first reason unless the run has passed; return the run."""
        if not self.passed:
            raise RunFailedError(f"{self.board}: {self.verdict}: {'; '.join(self.reasons[:3])}")
        return self

    def plot_motion(self, axis: int | None = None) -> Figure:
        """Draw speed and position of an axis over the ideal.

        Of several axes, without `axis`, one figure has the speeds and edge errors of all.
        """
        from pixstep import plotting
        from pixstep.simulation import plots

        with plotting.styled():
            if axis is None and len(self._traces) > 1:
                return plots.together([*self._traces.values()])
            return plots.motion(self._trace(axis))

    def plot_edge_errors(self, axis: int | None = None) -> Figure:
        """Draw the error of every edge of an axis, and their distribution."""
        from pixstep import plotting
        from pixstep.simulation import plots

        with plotting.styled():
            return plots.edge_error(self._trace(axis))

    def plot_positions(self, axis: int | None = None) -> Figure:
        """Draw the positions at the pixel edges: expected, recorded by the board, counted."""
        from pixstep import plotting
        from pixstep.simulation import plots

        with plotting.styled():
            return plots.positions(self._trace(axis))

    def plot_load(self, axis: int | None = None) -> Figure:
        """Draw where the load of an axis with a plant was at the pixel edges, and how far off."""
        from pixstep import plotting

        with plotting.styled():
            return experiment.load_figure(*_chosen(self._loads, axis, "has a plant and moved"))

    def plot_clock(self, axis: int | None = None) -> Figure:
        """Draw how far the pixel edges of an axis were from the clock's true edges."""
        return experiment.clock_figure(*_chosen(self._kept, axis, "moved and was not free"))

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas: a row a pixel.

        What the run did not give is missing. `load_steps`, where the load was, is a column if an
        axis has a plant.
        """
        names = ["axis", "pixel", "edge_cycle", "expected_steps", "actual_steps"]
        rows = [row for axis in self.axes for row in axis.pixels]
        if any(row.load_steps is not None for row in rows):
            names.append("load_steps")
        return frame({name: [getattr(row, name) for row in rows] for name in names})

    def _headline(self) -> str:
        axes = count(len(self.axes), "axis")
        why = f": {self.reasons[0]}" if self.reasons else ""
        return f"{self.verdict}, {axes} of a {self.board} at {float(self.pixel_hz):g} Hz{why}"

    def _facts(self) -> Facts:
        for axis in self.axes:
            yield f"axis {axis.axis}", axis._headline().partition(": ")[2]
        for reason in self.reasons:
            yield "wrong", reason

    def _trace(self, axis: int | None) -> Trace:
        """Return what there is to draw of an axis; of the only one by default."""
        return _chosen(self._traces, axis, "moved")


def simulate(
    lines: Lines,
    board: BoardKind | None = None,
    *,
    pixel_hz: Hz | None = None,
    check: bool = True,
    beyond: bool = False,
    out: str | PathLike[str] | None = None,
    sync: Sync | None = None,
    divider: int | None = None,
    gate_edges: int | None = None,
    clock: PixelClock | None = None,
    serial_load: bool = False,
    seed: int = 1,
    plant: str | Mapping[int, str] | None = None,
    vcd: bool = False,
    progress: Progress = unseen,
) -> Run:
    """Run lines on a simulated board and judge every edge.

    `lines` is one line or several, which go to the axes of their motors (without motors to axes 0,
    1, 2 ...), or lines by axis: any set of axes. `board` is `"uno"`,
    `"mega"` or `"m1284"`, by default that of the motor; the pixel frequency is that of the lines.
    `sync` is what lines are to the pixel clock: `"free"` of it, `"start"` on an edge of it, or
    `"lock"`: each of their pixels ends on an edge as the board predicts it. `divider` is how many
    edges of the clock a pixel has, so that the clock has so many times the pixel frequency. Both
    are by default those of the motor's machine, else `"start"` and 1. `gate_edges` is how far
    behind the first edge of a gated clock's burst lines begin, by default the machine's, else 0:
    the clock is not gated. `clock` is how the clock strays, and its gate: by default it does not.
    With `serial_load` the serial line is saturated meanwhile. `plant` is the mechanics of an axis,
    as `"play=40"`, or of axes by number. The files of the run go to `out`, by
    `pixstep sim`'s rules, if it is given; with `vcd` run.vcd for a waveform viewer too.
    `progress` is called with the share done, 0 to 1. Needs the simulator, pixstep-sim. Raises
    RefusedError for a line that the check refuses, unless `check` is False, and for lines that the
    board may not have the time for, unless `beyond` is True; UserError for a divider by which the
    pixels of a line are not edges of its machine's clock.

    Example:
        >>> from pixstep import line
        >>> run = simulate(line([2, 6, 8, 6, 2], pixel_hz=100), board="uno")
        >>> run.verdict, run.axes[0].steps, run.axes[0].max_edge_error.ticks < 1
        ('pass', 24, True)
        >>> scan = line([20] * 60, decode="plain", pixel_hz=250)
        >>> clock = PixelClock(ppm=2000, jitter_us=1)  # of 1 kHz, four edges a pixel
        >>> run = simulate(scan, board="uno", sync="lock", divider=4, clock=clock)
        >>> run.verdict, round(run.clock.board_offset_ppm, -2), run.clock.board_glitches
        ('pass', 2000.0, 0)
        >>> kept = run.axes[0].clock
        >>> kept.rms_error.ns < 1000, kept.max_position_error_steps <= 1
        (True, True)
    """
    by_axis = axes_of(lines)
    kind = given.board(board) or _board_of(by_axis)
    first = next(iter(by_axis.values()))
    hz = given.exact_hz(pixel_hz) or first.hz
    clock = PixelClock() if clock is None else clock
    clock = arguments.instance("clock", clock, PixelClock, "a PixelClock")
    clocking = Clocking(sync, divider, gate_edges).of_lines(by_axis)
    arguments.function("progress", progress)
    check = arguments.flag("check", check)
    _refuse(by_axis, kind, hz, clocking, check=check)
    if check and not arguments.flag("beyond", beyond):
        known = settings.of_clock(given.sync(clocking.sync), given.divider(clocking.divider))
        world = guarantee.world(kind, hz, known, ppm=clock.ppm)
        guarantee.refuse([item.line for item in by_axis.values()], world, guarantee.ADVICE)
    if arguments.flag("vcd", vcd) and out is None:
        raise UserError("vcd: run.vcd needs a folder: give out")
    job = sim_job.LineExperiment(
        kind,
        {axis: item.line for axis, item in by_axis.items()},
        hz * (clocking.divider or 1),
        pixel_ppm=clock.ppm,
        flaws=clock.flaws,
        sync=clocking.sync or sim_job.START,
        divider=clocking.divider or 1,
        gate_edges=clocking.gate_edges or 0,
        serial_load=arguments.flag("serial_load", serial_load),
        seed=arguments.whole("seed", seed, high=given.MOST_SEED),
        plants=_plants(plant, by_axis),
        vcd=vcd,
    )
    with _folder(out) as folder:
        return _run(job, by_axis, *experiment.run_and_judge(job, folder, progress))


@contextlib.contextmanager
def _folder(out: str | PathLike[str] | None) -> Iterator[Path]:
    """Yield where the files of a run go: to its folder, all or none, or nowhere in the end."""
    if out is None:
        with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
            yield Path(folder)
    else:
        with outfolder.of_run(arguments.path("out", out), experiment.names()) as place:
            yield place


def _board_of(lines: Mapping[int, MotionLine]) -> BoardKind:
    kinds = sorted({item.motor.board for item in lines.values() if item.motor})
    if len(kinds) != 1:
        raise UserError(f"board: say which one: {', '.join(boards.BOARD_NAMES)}")
    return kinds[0]


def _refuse(
    lines: Mapping[int, MotionLine],
    kind: BoardKind,
    hz: Fraction,
    clocking: Clocking,
    *,
    check: bool,
) -> None:
    """Raise UserError for axes or frequencies that do not fit, RefusedError for a wrong line."""
    if max(lines) >= boards.load(kind).axes:
        raise UserError(f"axis {max(lines)}: the {boards.axes_text(kind)}")
    for item in lines.values():
        given.refuse_empty(item.line)
        if item.pixel_hz not in (None, hz):
            raise UserError(
                f"{item.line.name}: a line for {item.pixel_hz} Hz, the run has {hz} Hz: one pixel "
                f"clock drives all axes"
            )
        if check:
            item.check(
                kind,
                axes=len(lines),
                sync=clocking.sync,
                divider=clocking.divider,
                guaranteed=False,  # which all lines together are asked for
            ).raise_if_refused()


def _chosen(drawn: Mapping[int, _Drawn], axis: int | None, what: str) -> _Drawn:
    """Return what there is to draw of an axis; of the only one by default."""
    if axis is None and len(drawn) == 1:
        return next(iter(drawn.values()))
    if axis is None or given.axis(axis) not in drawn:
        which = ", ".join(map(str, drawn)) or "none"
        raise UserError(f"axis {axis}: choose one that {what}: {which}")
    return drawn[given.axis(axis)]


def _plants(
    plant: str | Mapping[int, str] | None, lines: Mapping[int, MotionLine]
) -> dict[int, str]:
    """Return the plants by axis; one text is that of the only axis."""
    if plant is None:
        return {}
    if isinstance(plant, str):
        if len(lines) > 1:
            raise UserError(f"plant {plant!r}: of which axis? give plants by axis")
        return dict.fromkeys(lines, plant)
    plants = given.by_axis("plant", plant)
    for axis, knobs in plants.items():
        if axis not in lines:
            raise UserError(f"plant of axis {axis}: it has no line")
        arguments.text(f"plant of axis {axis}:", knobs)
    return plants


def _run(
    job: LineExperiment,
    lines: Mapping[int, MotionLine],
    result: RunResult,
    judged: Judgement,
    loads: Sequence[AxisLoad],
) -> Run:
    axes = tuple(_axis(job, found, lines[found.axis], result, judged) for found in judged.axes)
    return Run(
        verdict=judged.summary["verdict"],
        reasons=tuple(judged.summary["reasons"]),
        board=job.board,
        pixel_hz=job.line_hz,
        clock=ClockFigures.of(job, judged.summary["clock"]),
        tick_hz=job.tick_hz,
        axes=axes,
        summary=judged.summary,
        _traces=experiment.traces(result, judged),
        _loads={load.axis: (job, load) for load in loads},
        _kept={axis: (job, kept) for axis, kept in judged.kept.items()},
    )


def _axis(
    job: LineExperiment, found: AxisVerdict, line: MotionLine, result: RunResult, judged: Judgement
) -> AxisRun:
    errors = found.errors_ticks
    known = errors is not None

    def ticks(value: float) -> Ticks:
        return Ticks(value if known else math.nan, job.tick_hz)

    return AxisRun(
        axis=found.axis,
        line=line,
        verdict="pass" if found.passed else "fail",
        reasons=tuple(found.reasons),
        steps=found.steps,
        expected_steps=found.expected_steps,
        underruns=found.underruns,
        max_edge_error=ticks(found.max_edge_error_ticks),
        rms_edge_error=ticks(found.rms_edge_error_us * job.tick_hz / 1e6),
        max_interval_error=ticks(found.max_interval_error_ticks),
        rate_error_ppm=found.rate_error_ppm,
        line_zero_cycle=found.line_zero_cycle,
        edge_cycles=result.edges.axis(0, found.axis).rising,
        edge_errors_ticks=np.zeros(0) if errors is None else errors,
        pixels=tuple(row for row in judged.pixels if row.axis == found.axis),
        clock=_kept_of(judged.kept.get(found.axis), job),
    )


def _kept_of(kept: ClockKeeping | None, job: LineExperiment) -> ClockErrors | None:
    return None if kept is None else ClockErrors.of(kept, job.tick_hz)
