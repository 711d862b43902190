# SPDX-License-Identifier: MIT
"""Moves and homing on a board, for commands and programs: checked, set up, made.

What can be refused is refused while nothing moves. `make` is called where a signal stops the axis.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import capability, run, settings, upload
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.lines.line import Line
from pixstep.lines.units import refuse_period
from pixstep.moves import homing, legs
from pixstep.moves.fast import FastMove
from pixstep.moves.homing import Homed, HomingLeg
from pixstep.moves.legs import HomingPlan, Inputs
from pixstep.progress import Progress, unseen


@dataclass(frozen=True)
class MotionClock:
    """What the board is told of its pixel clock; None leaves the board's.

    `clock_hz` is the frequency of its edges, of which `divider` are a pixel.
    """

    clock_hz: Fraction | None = None
    divider: int | None = None

    def pixel_hz(self, board: Device) -> Fraction:
        """Return the frequency of pixels. Raises UserError for one that the board cannot carry."""
        hz = settings.pixel_hz(board, self.clock_hz, self.divider)
        refuse_period(hz, board.tick_hz())
        return hz


@dataclass(frozen=True)
class Moved:
    """A move that was made: from one position to the other, in steps."""

    move: FastMove
    pixel_hz: Fraction
    from_steps: int
    to_steps: int

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self.move.seconds(self.pixel_hz)


@dataclass(frozen=True)
class MoveOnBoard:
    """A move that a board is set up for."""

    move: FastMove
    line: Line
    lines: run.LinesOfBoard
    pixel_hz: Fraction
    edges: int  # of the clock, a pixel
    before: int

    def make(
        self, world: World, progress: Progress = unseen, begun: Callable[[], None] = lambda: None
    ) -> Moved:
        """Move to the end. Raises BoardError for a fault, and if the steps are not those planned.

        `begun` is called when the axis is armed.
        """
        board, (axis,) = self.lines.board, self.lines.axes
        self.lines.uploads += upload.begin(board, {axis: self.line}, self.edges)
        run.arm_queued(self.lines)
        begun()
        run.follow([self.lines], world, self.move.pixels, progress)
        after = run.positions(board, [axis])[axis]
        if after - self.before != self.move.steps:
            raise BoardError(
                f"board {board.unit}: axis {axis} moved {after - self.before} steps, not "
                f"{self.move.steps}"
            )
        return Moved(self.move, self.pixel_hz, self.before, after)


def prepare_move(
    board: Device, axis: int, move: FastMove, clock: MotionClock, name: str
) -> MoveOnBoard:
    """Check a move by the board's limits and set its clock; `name` is that of the profile."""
    hz, line = clock.pixel_hz(board), move.line(name)
    capability.check_line(line, capability.connected_limits(board, hz))
    upload.require_idle(board, [axis])
    settings.set_clock(board, clock.clock_hz, divider=clock.divider)
    before = run.positions(board, [axis])[axis]
    edges = clock.divider or settings.divider(board)
    return MoveOnBoard(move, line, run.LinesOfBoard(board, [axis]), hz, edges, before)


@dataclass(frozen=True)
class HomingOnBoard:
    """A homing that a board is set up for, its axis enabled."""

    plan: HomingPlan
    lines: run.LinesOfBoard
    pixel_hz: Fraction

    def make(self, world: World, progress: Progress = unseen) -> Homed:
        """Home. Raises HomingError as `homing.home` does."""
        return homing.home(
            self.lines.board, self.plan, self.pixel_hz, world, progress, lines=self.lines
        )

    def seek(self, world: World, progress: Progress = unseen, *, opens: bool = False) -> HomingLeg:
        """Move until the home switch closes, or opens; no further than the plan's search."""
        return homing.seek(
            self.lines.board, self.plan, self.pixel_hz, world, progress,
            lines=self.lines, opens=opens,
        )  # fmt: skip


def prepare_homing(
    board: Device, plan: HomingPlan, clock: MotionClock, inputs: Inputs
) -> HomingOnBoard:
    """Check the legs by the board's limits, set clock and inputs, enable the axis."""
    board.require("homing")
    hz = clock.pixel_hz(board)
    legs.refuse(plan, capability.connected_limits(board, hz))
    upload.require_idle(board, [plan.axis])
    old = settings.read(board)  # all are written in one request
    wanted = settings.of_clock(None, clock.divider) | inputs.settings(old, plan.axis)
    if clock.clock_hz:
        wanted["pixel_hz_num"] = clock.clock_hz.numerator
        wanted["pixel_hz_den"] = clock.clock_hz.denominator
    if wanted.get("home_is_limit") and inputs.home_is_limit is not None:
        board.require("shared_switch")
    settings.write(board, old, settings.changes(old, wanted))
    run.command(board, "enable", [plan.axis])
    return HomingOnBoard(plan, run.LinesOfBoard(board, [plan.axis]), hz)
