# SPDX-License-Identifier: MIT
"""Motion programs: planned to lines, or run on a board while they are planned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from pixstep import arguments
from pixstep.api.machines import Machine
from pixstep.api.motions import MotionLine, line
from pixstep.api.shown import Facts, Shown, count, frame
from pixstep.api.words import Mode
from pixstep.lazy import lazy, np
from pixstep.lines import units
from pixstep.programs.plan_data import MODES, MOST_WINDOW, SEGMENT_MS, WINDOW, PlanOptions

if TYPE_CHECKING:
    from pixstep.machine import files
    from pixstep.programs import motors, plan, plan_lines
    from pixstep.programs.plan import PlanRequest
    from pixstep.programs.plan_data import PlanFigures
else:  # numpy and pydantic take a while to load
    files = lazy("pixstep.machine.files")
    motors, plan = lazy("pixstep.programs.motors"), lazy("pixstep.programs.plan")
    plan_lines = lazy("pixstep.programs.plan_lines")


@dataclass(frozen=True, repr=False)
class ProgramPlan(Shown):
    """A program that is planned: a line for each motor, all of equal length."""

    total_ms: float
    """How long it takes, in milliseconds."""
    pixels: int
    """Length of the lines."""
    lines: Mapping[int, MotionLine]
    """A line for each motor, by its axis. Whole steps may lie 2 steps/px2 above a plain motor's
    limit, so the lines do not name their motors."""
    exceeded: tuple[str, ...]
    """What exceeds a limit, in words; only `mode="mode1"` has any."""
    report: PlanFigures
    """Everything that is known, as `report.json` of `pixstep plan` has it."""

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas: a row a pixel.

        Each axis has a column of its steps, `"axis0"`.
        """
        pixels = {"pixel": range(1, self.pixels + 1)}
        return frame(pixels | {f"axis{axis}": made.counts for axis, made in self.lines.items()})

    def _headline(self) -> str:
        axes = count(len(self.lines), "axis")
        return f"{axes}, {count(self.pixels, 'pixel')}, {self.total_ms / 1000:.4g} s"

    def _facts(self) -> Facts:
        for axis, made in self.lines.items():
            yield f"axis {axis}", made._headline()
        for text in self.exceeded:
            yield "exceeded", text


@dataclass(frozen=True, repr=False)
class MotionProgram(Shown):
    """A motion program (docs/PROGRAMS.md) for the motors of a machine: `read_program`.

    Example:
        >>> program = read_program("square.pmc", Machine.load("machine.toml"))
        >>> program.plan().total_ms < 2000
        True
    """

    path: str
    """The file."""
    machine: Machine
    """The machine whose motors it moves."""
    request: PlanRequest
    """How it is planned."""

    def _headline(self) -> str:
        return f"{self.path} for {self.machine.path}"

    def plan(self) -> ProgramPlan:
        """Plan it as a whole: this holds all of its lines in memory.

        Raises UserError naming file, line and column of a mistake in it, and for a plan that is
        longer than a line file; `Board.run_program` takes any length.
        """
        request = self.request
        with request.text() as text:
            plan.require_length(self.path, text, request.setup, request.options)
        with request.text() as text:
            planned = plan.Plan(self.path, text, request.setup, request.options)
            counts = np.vstack(list(plan.bounded(planned)))
        lines = {
            motor.axis: line(
                plan_lines.of_line(counts[:, index], motor), pixel_hz=request.setup.pixel_hz,
                decode="smooth" if motor.smooth else "plain",
                name=f"{self.path}, motor {motor.name}",
                negative=motor.smooth and (counts[:, index].sum() < 0) != motor.negative,
            )
            for index, motor in enumerate(request.setup.motors)
        }  # fmt: skip
        report = planned.report
        exceeded = tuple(
            f"{self.path}:{one['line']}: {one['motor']} {one['ratio']:.4g} x"
            for one in report.violations
        )
        return ProgramPlan(report.total_ms, report.pixels, lines, exceeded, report.as_json())


def read_program(
    path: str | PathLike[str],
    machine: Machine,
    *,
    mode: Mode = "lookahead",
    window: int = WINDOW,
    segment_ms: float | str | None = None,
    arc_tolerance_steps: float = 1.0,
) -> MotionProgram:
    """Return a motion program for a machine; the file is read when it is planned or run.

    `mode` is `"lookahead"` or `"mode1"`, `window` the moves that lookahead sees ahead, `segment_ms`
    the length of a circle's segments, by default that of the machine file; `"mode1"` has none.
    `arc_tolerance_steps` is how far an arc may leave a circle where its numbers are rounded, in
    steps of the finer motor.
    Raises UserError for motors without limits.
    """
    name = fspath(arguments.path("path", path))
    machine = arguments.instance("machine", machine, Machine, "a Machine, as Machine.load reads it")
    options = PlanOptions(
        arguments.one_of("mode", mode, MODES), arguments.whole("window", window, 1, MOST_WINDOW)
    )
    if segment_ms is not None:
        if isinstance(segment_ms, str):
            segment_ms = float(1000 * units.parse_seconds(segment_ms, "ms"))
        segment_ms = arguments.finite("segment_ms", segment_ms, *SEGMENT_MS)
    found = replace(
        motors.of_machine(files.MachineFile.load(machine.path)),
        arc_tolerance=arguments.finite("arc_tolerance_steps", arc_tolerance_steps, 0),
    )
    setup = plan.with_segments(found, options.mode, segment_ms)
    return MotionProgram(name, machine, plan.PlanRequest(name, setup, options))
