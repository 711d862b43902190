# SPDX-License-Identifier: MIT
"""Motion programs: planned to lines, or run on a board while they are planned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike, fspath
from typing import TYPE_CHECKING

from pixstep import arguments
from pixstep.api.machines import Machine
from pixstep.api.motions import MotionLine, line
from pixstep.lazy import lazy
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.programs.options import (
    LOOKAHEAD,
    MODES,
    MOST_WINDOW,
    SEGMENT_MS,
    WINDOW,
    Options,
)

if TYPE_CHECKING:
    import numpy as np

    from pixstep.machine import reading
    from pixstep.programs import entries, length, motors, plan, sources
    from pixstep.programs.report import PlanFigures
    from pixstep.programs.sources import Request
else:  # numpy and pydantic take a while to load
    np, reading = lazy("numpy"), lazy("pixstep.machine.reading")
    entries, length = lazy("pixstep.programs.entries"), lazy("pixstep.programs.length")
    motors, plan = lazy("pixstep.programs.motors"), lazy("pixstep.programs.plan")
    sources = lazy("pixstep.programs.sources")


@dataclass(frozen=True)
class ProgramPlan:
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


@dataclass(frozen=True)
class MotionProgram:
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
    request: Request
    """How it is planned."""

    def plan(self) -> ProgramPlan:
        """Plan it as a whole: this holds all of its lines in memory.

        Raises UserError naming file, line and column of a mistake in it, and for a plan that is
        longer than a line file; `Board.run_program` takes any length.
        """
        request = self.request
        with request.text() as text:
            length.require(self.path, text, request.setup, request.options)
        with request.text() as text:
            planned = plan.Plan(self.path, text, request.setup, request.options)
            counts = np.vstack(list(length.bounded(planned)))
        lines = {
            motor.axis: line(
                entries.of_line(counts[:, index], motor), pixel_hz=request.setup.pixel_hz,
                decode=SMOOTH if motor.smooth else PLAIN, name=f"{self.path}, motor {motor.name}",
                negative=motor.smooth and (counts[:, index].sum() < 0) != motor.negative,
            )
            for index, motor in enumerate(request.setup.motors)
        }  # fmt: skip
        report = planned.report
        exceeded = tuple(
            f"{self.path}:{one.line}: {one.motor} {one.ratio:.4g} x" for one in report.violations
        )
        return ProgramPlan(report.total_ms, report.pixels, lines, exceeded, report.as_json())


def read_program(
    path: str | PathLike[str],
    machine: Machine,
    *,
    mode: str = LOOKAHEAD,
    window: int = WINDOW,
    segment_ms: float | None = None,
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
    options = Options(
        arguments.one_of("mode", mode, MODES), arguments.whole("window", window, 1, MOST_WINDOW)
    )
    if segment_ms is not None:
        segment_ms = arguments.finite("segment_ms", segment_ms, *SEGMENT_MS)
    found = replace(
        motors.of_machine(reading.Machine.load(machine.path)),
        arc_tolerance=arguments.finite("arc_tolerance_steps", arc_tolerance_steps, 0),
    )
    setup = plan.with_segments(found, options.mode, segment_ms)
    return MotionProgram(name, machine, sources.Request(name, setup, options))
