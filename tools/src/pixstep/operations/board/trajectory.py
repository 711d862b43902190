# SPDX-License-Identifier: MIT
"""A table of two axes on a board, the original or compensated."""

from __future__ import annotations

from pathlib import Path

from pixstep.board import settings, upload
from pixstep.board.capability import connected_limits
from pixstep.board.run import Lines
from pixstep.lines.units import refuse_period
from pixstep.operations import bus, directions, reading_lines
from pixstep.operations.board.records import RecordFields, recorded
from pixstep.operations.board.upload import QueuedLines, check_lines, run_lines
from pixstep.operations.bus import ToBoard
from pixstep.operations.clocks import BoardLineClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Choice
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result
from pixstep.operations.trajectory import fields
from pixstep.operations.trajectory.fields import BoardPlayFields
from pixstep.trajectories import runs, transitions
from pixstep.trajectories.circle_test import RUNS
from pixstep.trajectories.runs import COMPENSATED
from pixstep.trajectories.table import AXES


class TableRun(QueuedLines):
    """A table that a board has run: what was taken up, and in how many points."""

    run: str
    play_steps: list[int]
    transition_points: list[int]


@operation("board trajectory")
class BoardTrajectory(BoardPlayFields, RecordFields, BoardLineClock, ToBoard):
    """Run a table of two axes, its play taken up or not.

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
        "First go back by the play and forth again, so that it is taken up in the direction in "
        "which each axis begins.",
        off="--no-take-up", default=True,
    )  # fmt: skip
    axis: tuple[int, ...] = reading_lines.axes()

    def run(self, desk: Desk) -> Result:
        """Make the lines of the table, check and run them."""
        self.refuse_file()
        original = fields.read_table(desk, self.table).without_holds()
        motor_ways = directions.ways(desk.facts, AXES)
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
            settings.set_clock(
                board, self.edges_hz(board), self.sync, self.divider, self.gate_edges
            )
            edges = self.divider or settings.divider(board)
            queues = Lines(board, axes)
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
