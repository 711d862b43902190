# SPDX-License-Identifier: MIT
"""A motion program to a line for each motor, within the limits of all."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from pixstep.errors import FINE, NEGATIVE
from pixstep.formats.findings import counted
from pixstep.operations import shared
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FOLDER
from pixstep.operations.program.fields import ProgramFields
from pixstep.operations.request import operation, option
from pixstep.operations.result import Page, Result
from pixstep.programs.plan_data import PlannedProgram, limit_text
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    from rich.table import Table

    from pixstep.programs.plan_lines import PlannedFiles as Planned
    from pixstep.programs.report import MotorReport, Report

_WORTH_SAYING = 0.01  # steps
_SHOWN = 8  # slowed moves and violations that are printed
_SAME = 1e-6  # part of a time that rounding explains


@operation("plan")
class ProgramPlan(ProgramFields):
    """Plan a motion program of blended moves: a line for each motor, all of equal length.

    A plan keeps max_speed and max_acceleration of the machine file, with lookahead max_jerk too. It
    does not use start_stop, and says where a motor has it: TA and TS form the acceleration.

    A plan is as long as a line file may be, 2,097,152 pixels; `board run` takes any length.

    The folder gets NAME.csv for each motor, report.json and with --plot drawings. Exit status 1 if
    a limit is exceeded or a board would refuse a line. The language: docs/PROGRAMS.md.
    """

    result = PlannedProgram
    needs_machine: ClassVar[bool] = True

    out: Path = option(
        FOLDER, "Folder for the results; replaces only what an earlier run has left there.",
        default=Path("plan"),
    )  # fmt: skip
    plot: bool = shared.plots()

    def run(self, desk: Desk) -> Result:
        """Plan the program and write its lines."""
        from pixstep.board import capability  # these take a while to load
        from pixstep.programs import plan, plan_lines
        from pixstep.programs.plan import Plan

        machine, setup, chosen = self.planned_for(desk)
        bounds = [
            capability.named_limits(
                machine.board_of(machine[motor.name]).kind,
                machine.pixel_hz,
                axes=motor.together,
                clock=setup.clock,
            )
            for motor in setup.motors
        ]
        name, path = str(self.program), self.program
        if path.is_file():  # a pipe is read once
            with path.open(encoding="utf-8", errors="replace") as text:
                plan.require_length(name, text, setup, chosen)
        with (
            path.open(encoding="utf-8", errors="replace") as text,
            desk.progress("planning") as show,
        ):
            planned = Plan(name, text, setup, chosen)
            done = plan_lines.write(planned, self.out, bounds, plot=self.plot, progress=show)
        status = FINE if done.fine else NEGATIVE
        return Result(done.facts, lambda page: _write(page, done, self.out), status)


def _write(page: Page, done: Planned, out: Path) -> None:
    """Write the report: a row for each motor, what was slowed, what is exceeded."""
    report: Report = done.plan.report
    moves = counted(report.moves, "move")
    page.draw(_table(report.motors))
    page.tell(
        f"{out}: {moves}, {report.total_ms:.6g} ms, {counted(report.pixels, 'pixel')} at "
        f"{float(report.setup.pixel_hz):g} Hz{_edges_text(report.setup.divider)}"
    )
    page.tell(_times_text(report))
    page.tell(f"at most {report.off_path:.1f} steps off the path")
    for why, count in report.reasons.most_common():
        page.tell(f"{count} of {moves} slowed: {why}")
    if report.clipped:
        page.tell(
            f"{report.clipped} of {moves}: the blend at the beginning is shorter than TA, as the "
            f"move before is too short for it"
        )
    if report.arc_off_steps >= _WORTH_SAYING:
        page.tell(
            f"arcs leave their circles by up to {report.arc_off_steps:.2g} steps, as the program's "
            f"numbers are rounded: --arc-tolerance allows {report.setup.arc_tolerance:g}"
        )
    for row in report.motors:
        _write_limits(page, row)
    name = done.plan.name
    for item in report.slowed[:_SHOWN]:
        page.tell(
            f"{name}:{item['line']}: {item['asked_ms']:.6g} -> {item['ms']:.6g} ms: {item['why']}"
        )
    if report.slowed_moves > _SHOWN:
        page.tell(f"... {report.slowed_moves - _SHOWN} more in report.json")
    for bad in report.violations[:_SHOWN]:
        page.tell(f"{name}:{limit_text(bad)}")
    for path, findings in zip(done.files, done.findings, strict=True):
        for found in findings[:_SHOWN]:
            page.tell(
                f"{path}: pixel {found.pixel}: the board refuses: {found.name}: {found.message}"
            )


def _times_text(report: Report) -> str:
    """Return what the time of a plan is made of."""
    parts = [(report.moves_ms, "of moves as programmed"), (report.stops_ms, "of starts and stops")]
    if report.dwells_ms:
        parts.append((report.dwells_ms, "of dwells"))
    more = report.total_ms - report.programmed_ms
    if more > _SAME * report.total_ms:
        parts.append((more, "more than programmed"))
    told = " + ".join(f"{ms:.6g} ms {what}" for ms, what in parts)
    return f"{report.total_ms:.6g} ms = {told}"


def _write_limits(page: Page, row: MotorReport) -> None:
    """Write how a motor keeps its limit of the jerk, and which limits a plan does not use."""
    if row.jerk_limit is not None:
        page.tell(
            f"{row.motor.name}: jerk {row.planned_jerk:.5g} of {row.jerk_limit:.6g} steps/px3 "
            f"planned, {row.counted_jerk} of {row.allowed_jerk:.6g} counted"
        )
    for limit in row.unused_limits:
        page.tell(
            f"{row.motor.name}: a plan does not use {limit} of the machine file"
            f"{_jerk(row) if limit == 'max_jerk' else ''}"
        )


def _jerk(item: MotorReport) -> str:
    """Return what the counts of a motor have instead of its max_jerk."""
    return (
        f": its acceleration changes by {item.counted_jerk} steps/px3 at most, "
        f"{item.motor.max_jerk:.6g} is said there"
    )


def _table(motors: list[MotorReport]) -> Table:
    table = new_table("motor", "kind", "steps", "speed", "of limit", "accel", "of limit", "counted")
    for column in table.columns[:2]:
        column.justify = "left"
    for item in motors:
        table.add_row(
            item.motor.name,
            "smooth" if item.motor.smooth else "plain",
            str(item.steps),
            f"{item.planned_speed:.5g}",
            f"{item.speed_ratio:.4f}",
            f"{item.planned_acceleration:.5g}",
            f"{item.planned_ratio:.4f}",
            f"{item.counted_acceleration} of {item.allowed:.6g}",
        )
    table.caption = (
        "speed: counts/ms, accel: counts/ms2, as planned; counted: the largest\n"
        "acceleration of the whole steps, and what they may have, steps/px2"
    )
    table.caption_justify = "left"
    return table


def _edges_text(divider: int) -> str:
    return f", {divider} clock edges each" if divider > 1 else ""
