# SPDX-License-Identifier: MIT
"""A program on a board: rehearsed at rest, then planned by a process of its own while it runs."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from pixstep.board import clockstate, limits, settings
from pixstep.board import run as running
from pixstep.board.device import Board
from pixstep.board.link import World
from pixstep.errors import RefusedError, UserError
from pixstep.lines.units import refuse_period
from pixstep.machine.model import Tables
from pixstep.programs import rehearsal, streaming
from pixstep.programs.motors import Setup
from pixstep.programs.plan import Plan
from pixstep.programs.rehearsal import Rehearsal
from pixstep.programs.sources import PlanProcess, Request
from pixstep.progress import Progress, unseen


@dataclass(frozen=True)
class OnBoard:
    """A program that a board is set up for; `pixels` is its length, 0 if it is not known."""

    board: Board
    setup: Setup
    lines: running.Lines
    entries: streaming.Entries
    before: dict[int, int]
    pixels: int

    def run(
        self,
        world: World,
        progress: Progress = unseen,
        begun: Callable[[], None] = lambda: None,
    ) -> None:
        """Queue its beginning, arm the motors, which start on one edge, and follow them to the end.

        `begun` is called when they are armed. Call it where a signal stops the axes: a part of a
        line in a queue keeps the next one out. Raises BoardError as a board does, UserError for a
        mistake in the program that shows only now: the motors are stopped then.
        """
        streaming.load(self.lines)
        clockstate.await_lock(self.board, world)
        running.arm_queued(self.lines)
        begun()
        streaming.follow(self.lines, world, self.pixels, progress)

    def rows(self) -> list[dict[str, object]]:
        """Return what each motor has done as plain data, once all of them are done."""
        axes = self.lines.axes
        states, places = running.states(self.board, axes), running.positions(self.board, axes)
        return [
            {
                "axis": motor.axis,
                "motor": motor.name,
                "state": states[motor.axis],
                "made_steps": self.entries.steps(index),
                "from_steps": self.before[motor.axis],
                "moved_steps": places[motor.axis] - self.before[motor.axis],
                "position_steps": places[motor.axis],
            }
            for index, motor in enumerate(self.setup.motors)
        ]


def require_fitting(machine: Tables, setup: Setup, kind: str) -> None:
    """Raise UserError for motors on several boards, RefusedError for a board of another kind."""
    names = {motor.name: machine.board_name(machine.motors[motor.name]) for motor in setup.motors}
    boards = sorted(set(names.values()))
    if len(boards) > 1:
        raise UserError(
            f"{machine.path}: motors on boards {' and '.join(boards)}: a program streams to one "
            f"board"
        )
    wanted = machine.boards[boards[0]].kind
    if wanted != kind:
        raise RefusedError(f"{machine.path} has boards.{boards[0]} as a {wanted}, it is a {kind}")


def rehearse(board: Board, request: Request, progress: Progress = unseen) -> Rehearsal:
    """Plan a program to its end with the board's own limits; nothing is sent.

    Raises UserError for a mistake in the program, RefusedError for what the board would refuse.
    """
    setup = request.setup
    bounds = limits.connected(board, setup.pixel_hz, len(setup.motors), setup.clock)
    with request.text() as text:
        plan = Plan(request.path, text, setup, request.options)
        return rehearsal.rehearse(plan, bounds, progress)


@contextmanager
def prepared(board: Board, request: Request, known: Rehearsal | None = None) -> Iterator[OnBoard]:
    """Set a board up for a program, its rehearsal being `known`; end the planner at the end.

    Sets the board's clock, and how many of its edges are a pixel, to those of the plan. Raises as
    `streaming.prepare` does.
    """
    setup = request.setup
    refuse_period(setup.pixel_hz, board.tick_hz())
    settings.set_clock(
        board, setup.pixel_hz * setup.divider, setup.sync, setup.divider, setup.gate_edges
    )
    axes = [motor.axis for motor in setup.motors]
    before = dict(running.positions(board, axes))
    with PlanProcess(request) as source:
        entries = streaming.Entries(source, setup.motors, known.ways if known else ())
        lines = streaming.prepare(board, entries, setup.motors, setup.divider)
        yield OnBoard(board, setup, lines, entries, before, known.pixels if known else 0)
