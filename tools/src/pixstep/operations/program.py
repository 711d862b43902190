# SPDX-License-Identifier: MIT
"""Motion programs: planned to a line for each motor, or run on a board while they are planned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, TypedDict

from pixstep.errors import FINE, NEGATIVE, AskedText, UserError
from pixstep.formats.findings import counted
from pixstep.lines.units import Quantity
from pixstep.operations import bus, shared
from pixstep.operations.asked import AskedError
from pixstep.operations.board.records import ReadRecords, RecordFields, recorded
from pixstep.operations.bus import ToBoard
from pixstep.operations.desk import Desk
from pixstep.operations.facts import NO_MACHINE
from pixstep.operations.kinds import FILE, FOLDER, Choice, Length, Number, Time, Whole
from pixstep.operations.request import Request, argument, operation, option, shared_fields, unless
from pixstep.operations.result import Page, Result
from pixstep.programs.plan_data import (
    LOOKAHEAD,
    MODE1,
    MODES,
    MOST_WINDOW,
    SEGMENT_MS,
    WINDOW,
    PlannedProgram,
    PlanOptions,
    limit_text,
)
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    from rich.table import Table

    from pixstep.machine.files import MachineFile
    from pixstep.programs.motors import Setup
    from pixstep.programs.plan_lines import PlannedFiles as Planned
    from pixstep.programs.report import MotorReport, Report


@shared_fields
class ProgramFields(Request):
    """A motion program and how it is planned."""

    program: Path = argument(FILE)
    mode: str = option(
        Choice(MODES), "lookahead never exceeds a limit; mode1 sees no more than two moves.",
        default=LOOKAHEAD,
    )  # fmt: skip
    window: int = option(Whole(1, MOST_WINDOW), "Moves that lookahead sees ahead.", default=WINDOW)
    assume_last: bool = unless(
        "mode1: do not time each move as if it were the last one; limits may be exceeded.",
        "--no-assume-last",
    )
    segment: float | None = option(
        Time("ms", *SEGMENT_MS), "Length of a circle's segments: 5ms.",
        default_text="program.segment_time of the machine file",
    )  # fmt: skip
    path_tolerance: float = option(
        Number(0.01, 1000),
        "Steps by which a smooth motor may be off in a corner (1 at least), and segments on a "
        "circle (half a step at most).",
        default=1.0,
    )  # fmt: skip
    arc_tolerance: Quantity | None = option(
        Length(),
        "How far an arc may leave a circle where its numbers are rounded: 2um, 0.5 steps.",
        default_text="a step of the finer motor",
    )  # fmt: skip

    def planned_for(self, desk: Desk) -> tuple[MachineFile, Setup, PlanOptions]:
        """Return the machine file, its motors, and how the program is to be planned.

        Raises UserError without a machine file, and for what the mode does not have.
        """
        machine = desk.facts.found
        if machine is None:
            raise AskedError(NO_MACHINE)
        setup = self._setup(machine)
        if not self.assume_last and self.mode != MODE1:
            raise AskedError(f"{{assume_last}}: only with {{mode}} {MODE1}")
        return machine, setup, PlanOptions(self.mode, self.window, self.assume_last)

    def _setup(self, machine: MachineFile) -> Setup:
        from pixstep.programs.motors import of_machine  # numpy takes a while to load
        from pixstep.programs.plan import with_segments

        setup = replace(of_machine(machine), path_tolerance=self.path_tolerance)
        if self.arc_tolerance is not None:
            steps = _finer_steps(machine, setup, self.arc_tolerance)
            setup = replace(setup, arc_tolerance=steps)
        return with_segments(setup, self.mode, self.segment)


def _finer_steps(machine: MachineFile, setup: Setup, length: Quantity) -> float:
    """Return a length in steps of the finer motor of a circle.

    Raises UserError for a length in mm or deg where no such motor has a scale for it.
    """
    chosen = [motor for motor in setup.motors if motor.word in ("X", "Y")]
    finer = max(chosen, key=lambda motor: motor.counts_per_unit, default=None)
    scale = machine[finer.name].steps_per_unit if finer else None
    try:
        return float(length.in_steps(scale).value)
    except UserError as error:
        raise AskedError("{arc_tolerance}: {error}", error=error) from None


_WORTH_SAYING = 0.01  # steps
_SHOWN = 8  # slowed moves and violations that are printed
_SAME = 1e-6  # part of a time that rounding explains


@operation("plan")
class PlanProgram(ProgramFields):
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
        page.tell(AskedText(
            "arcs leave their circles by up to {off:.2g} steps, as the program's numbers are "
            "rounded: {arc_tolerance} allows {allowed:g}",
            off=report.arc_off_steps, allowed=report.setup.arc_tolerance,
        ))  # fmt: skip
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


class ProgramAxis(TypedDict):
    """What a motor has done; `records` is None if none were read."""

    axis: int
    motor: str
    state: str
    made_steps: int
    from_steps: int
    moved_steps: int
    position_steps: int
    records: ReadRecords | None


class ProgramRun(TypedDict):
    """A program that a board has run."""

    program: str
    unit: int
    axes: list[ProgramAxis]


@operation("board run")
class RunProgram(ProgramFields, RecordFields, ToBoard):
    """Run a motion program while it is planned.

    A machine file says which motors it moves; positions count from where they are. First the
    program is planned once without moving: a mistake in it, or a line that the board would refuse,
    is found at rest. Then the motors start together on one pixel clock edge. Planning goes on in a
    process of its own and memory does not grow with the program. Ctrl-C stops the motors. The
    per-pixel records are read meanwhile; --records writes them.
    """

    result = ProgramRun

    check: bool = unless(
        "Begin at once: a mistake further down stops the motors when the plan comes to it.",
        "--no-check",
    )

    def run(self, desk: Desk) -> Result:
        """Rehearse the program, then run it."""
        from pixstep.programs import streaming  # numpy takes a while to load
        from pixstep.programs.plan import PlanRequest

        self.refuse_file()
        machine, setup, options = self.planned_for(desk)
        request = PlanRequest(str(self.program), setup, options)
        with bus.one_board(desk, self) as (found, known):
            board = known.board
            known.axes(tuple(motor.axis for motor in setup.motors))
            streaming.require_fitting(machine, setup, known.who.board)
            rehearsed = None
            if self.check:
                with desk.progress("planning") as show:
                    rehearsed = streaming.rehearse(board, request, show)
            with streaming.prepared(board, request, rehearsed) as run:
                with (
                    recorded(desk, [run.lines], self.record_file, wanted=self.record) as records,
                    desk.progress("running") as show,
                    bus.stopping([run.lines]),
                ):
                    run.run(found.world, show)
                rows = [
                    {**row, "records": records.of(self.unit, motor.axis)}
                    for row, motor in zip(run.rows(), setup.motors, strict=True)
                ]
        texts = [
            f"board {self.unit} axis {row['axis']}: motor {row['motor']} {row['state']}, made "
            f"{row['made_steps']} steps, from position {row['from_steps']} to "
            f"{row['position_steps']}"
            for row in rows
        ]
        data = {"program": str(self.program), "unit": self.unit, "axes": rows}
        return records.result(data, texts)
