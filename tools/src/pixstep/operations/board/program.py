# SPDX-License-Identifier: MIT
"""A motion program on a board, planned while it runs."""

from __future__ import annotations

from typing import TypedDict

from pixstep.operations import bus
from pixstep.operations.board.records import ReadRecords, RecordFields, recorded
from pixstep.operations.bus import ToBoard
from pixstep.operations.desk import Desk
from pixstep.operations.program.fields import ProgramFields
from pixstep.operations.request import operation, unless
from pixstep.operations.result import Result


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
