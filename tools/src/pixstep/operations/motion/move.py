# SPDX-License-Identifier: MIT
"""Fast moves of exactly N steps: written as a line, shown, made on a simulated board."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from pixstep import formats
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.moves import experiments
from pixstep.moves.move_judge import MoveJob
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared, simulated
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import OUTPUT
from pixstep.operations.motion.move_fields import MoveFields, headline
from pixstep.operations.request import operation, option
from pixstep.operations.result import Page, Result
from pixstep.simulation import report
from pixstep.simulation.summary import Move, Summary

_MOST_ROWS = 40


class WrittenMove(Move):
    """The plan of a move, and the file that has it."""

    file: str


@operation("move make")
class MoveMake(MoveFields):
    """Write a move as a plain line: one signed count per pixel, the fewest pixels there are."""

    result = WrittenMove

    pixel_hz: Fraction = shared.pixel_hz()
    output: Path = option(OUTPUT, "CSV file to write (plain).", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Plan the move and write it."""
        job = MoveJob(*self.plan(desk, self.pixel_hz, refuse=True), "", 0, self.pixel_hz)
        formats.write_csv(self.output, list(job.move.counts))
        data: WrittenMove = {"file": str(self.output), **job.plan_summary()}
        return Result(data, f"{self.output}: {headline(job.move, self.pixel_hz)}")


@operation("move show")
class MoveShow(MoveFields):
    """Show a move: how fast in which pixels, how long, where."""

    result = Move

    pixel_hz: Fraction = shared.pixel_hz()
    plot: Path | None = shared.picture(what="Draw speed and position over time")

    def run(self, desk: Desk) -> Result:
        """Plan the move and, if asked, draw it."""
        scale = desk.facts.scales().get(0) if self.plot else None
        job = MoveJob(*self.plan(desk, self.pixel_hz), "", 0, self.pixel_hz, scale)
        if self.plot:
            from pixstep.moves import plots  # matplotlib takes a second to load

            plots.draw_move(job, self.plot)

        def write(page: Page) -> None:
            page.tell(headline(job.move, job.pixel_hz))
            _print_runs(page, job)

        return Result(job.plan_summary(), write)


@operation("move sim")
class MoveSim(MoveFields):
    """Make a move on a simulated board and judge every STEP edge and where it ends.

    Exit status 0 only if the verdict is pass, 1 if it is not, 2 for misuse.
    """

    result = Summary

    pixel_hz: Fraction = shared.pixel_hz()
    board: str = shared.simulated_board()
    axis: int = option(shared.AXIS, "Axis of the board.", default=0, machine=machine.axis)
    out: Path = shared.out("move")
    plot: bool = shared.plots()
    details: bool = shared.details()

    def run(self, desk: Desk) -> Result:
        """Make the move in the simulator."""
        if self.axis >= boards.load(self.board).axes:
            raise UserError(f"axis {self.axis}: the {boards.axes_text(self.board)}")
        planned = self.plan(desk, self.pixel_hz)
        scale = desk.facts.scales().get(self.axis) if self.plot else None
        job = MoveJob(*planned, self.board, self.axis, self.pixel_hz, scale)
        with desk.progress("moving") as show:
            done = experiments.simulate_move(job, self.out, plot=self.plot, progress=show)

        def write(page: Page, summary: Summary) -> None:
            report.print_page(page, summary, details=self.details)
            page.tell(headline(job.move, job.pixel_hz))
            move = summary["move"]
            page.tell(
                f"ends at {_known(move['position_register_steps'])} by the board's position "
                f"register, {move['counted_steps']} by the simulator's count of STEP edges"
            )

        return simulated.result(done.judged.summary, self.out, write)


def _print_runs(page: Page, job: MoveJob) -> None:
    """Print one row for each stretch of equal pixels; of very many the first and last ones."""
    table = report.new_table("pixels", "steps/pixel", "steps/s", "position at its end")
    pixel = place = 0
    hidden = range(_MOST_ROWS // 2, len(job.move.runs) - _MOST_ROWS // 2)
    for index, (count, repeat) in enumerate(job.move.runs):
        span = f"{pixel + 1}" if repeat == 1 else f"{pixel + 1} to {pixel + repeat}"
        pixel, place = pixel + repeat, place + count * repeat
        if index not in hidden:
            table.add_row(span, str(count), f"{float(count * job.pixel_hz):g}", str(place))
        elif index == hidden.start:
            table.add_row("...", "", "", "")
    page.print(table)


def _known(value: int | None) -> str:
    return "no position" if value is None else str(value)
