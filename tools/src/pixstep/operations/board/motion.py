# SPDX-License-Identifier: MIT
"""Moves and homing on a board's axis, and its play measured by the home switch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NotRequired, TypedDict

from pixstep.board.errors import BoardError
from pixstep.lines.line import SMOOTH
from pixstep.lines.units import SPEED, parse
from pixstep.moves import homing, on_board, play_measurement
from pixstep.moves.homing import Homed, HomingError, LegData
from pixstep.moves.legs import Inputs
from pixstep.moves.on_board import HomingOnBoard, MotionClock
from pixstep.moves.play_measurement import MeasuredPlay
from pixstep.operations import bus, shared
from pixstep.operations import machine_defaults as machine
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import Known, ToBoard
from pixstep.operations.clocks import BoardClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import TEXT, Steps, Whole
from pixstep.operations.motion import HomeFields, MoveFields, headline
from pixstep.operations.request import flag, operation, option, shared_fields
from pixstep.operations.result import Result


class MadeMove(TypedDict):
    """A move that was made: from one position to the other."""

    unit: int
    axis: int
    steps: int
    pixels: int
    seconds: float
    top_steps_px: int
    from_steps: int
    to_steps: int


class HomeEdge(TypedDict):
    """The edge of the home switch, in steps before the zero and in timer ticks."""

    code: int
    axis: int
    position_steps: int
    ticks: int


class HomedAxis(TypedDict):
    """A homing; if it found no switch, its fault and the legs so far."""

    found: bool
    legs: list[LegData]
    unit: NotRequired[int]
    axis: NotRequired[int]
    direction: NotRequired[str]
    edge: NotRequired[HomeEdge]
    beyond_edge_steps: NotRequired[int]
    position_steps: NotRequired[int]
    fault: NotRequired[str]
    text: NotRequired[str]


class PlayApproach(TypedDict):
    """Where the motor was when the switch closed and when it opened."""

    closed_steps: int
    opened_steps: int


class AxisPlay(TypedDict):
    """The play of an axis; `saved` is the machine file that has it now."""

    unit: int
    saved: str | None
    axis: int
    play_steps: int
    spread_steps: float
    hysteresis_steps: float | None
    by_encoder: bool
    approaches: list[PlayApproach]


@operation("board move")
class BoardMove(MoveFields, BoardClock, ToBoard):
    """Move an axis by exactly N steps.

    By a CSV acceleration profile; it needs no pixel clock. Planned as by `pixstep move show`,
    checked with the board's own limits, followed to its end. Ctrl-C stops the axis.
    """

    result = MadeMove

    axis: int = option(shared.AXIS, "Axis of the board.", default=0, machine=machine.axis)

    def run(self, desk: Desk) -> Result:
        """Plan the move, check it, make it."""
        with bus.one_board(desk, self) as (found, known):
            known.axes((self.axis,))
            clock = MotionClock(self.edges_hz(known.board), self.divider)
            hz = clock.pixel_hz(known.board)
            _profile, move = self.plan(desk, hz, refuse=True)
            ready = on_board.prepare_move(known.board, self.axis, move, clock, str(self.profile))
            with desk.progress("moving") as show, bus.stopping([ready.lines]):
                made = ready.make(found.world, show)
        data: MadeMove = {
            "unit": self.unit, "axis": self.axis, "steps": move.steps, "pixels": move.pixels,
            "seconds": round(move.seconds(hz), 6), "top_steps_px": move.top,
            "from_steps": made.from_steps, "to_steps": made.to_steps,
        }  # fmt: skip
        where = f"from position {made.from_steps} to {made.to_steps}"
        return Result(data, f"{headline(move, hz)}\nboard {self.unit} axis {self.axis}: {where}")


@shared_fields
class _Homing(HomeFields, BoardClock, ToBoard):
    """Homing on a board."""

    def prepare_axis(self, desk: Desk, known: Known) -> HomingOnBoard:
        """Check all that can be checked, then set and enable."""
        known.axes((self.axis,))
        known.board.require("homing")
        clock = MotionClock(self.edges_hz(known.board), self.divider)
        plan = self.plan(desk, clock.pixel_hz(known.board), refuse=True)
        inputs = Inputs(self.inverted, self.filter_us, self.home_is_limit)
        return on_board.prepare_homing(known.board, plan, clock, inputs)


@operation("board home")
class BoardHome(_Homing):
    """Home an axis: its switch's edge becomes position 0.

    By a CSV or CSB profile. Off the switch, towards it, back, slowly towards it again; then the
    axis stands on 0. A fault ends it, named, and stays latched. The same options as `pixstep home
    sim`, which tries it first.
    """

    result = HomedAxis

    def run(self, desk: Desk) -> Result:
        """Home the axis."""
        with bus.one_board(desk, self) as (found, known):
            ready = self.prepare_axis(desk, known)
            try:
                with desk.progress("homing") as show, bus.stopping([ready.lines]):
                    homed = ready.make(found.world, show)
            except HomingError as error:
                made = homing.legs_as_json(error.legs)
                desk.so_far = Result(
                    {"found": False, "fault": error.name, "text": str(error), "legs": made}
                )
                raise BoardError(f"board {self.unit}: {error}") from None
        return Result({"found": True, "unit": self.unit} | homed.as_json(), self._text(homed))

    def _text(self, homed: Homed) -> str:
        """Return what was found, in a sentence."""
        seconds = homed.legs[-1].ended_s - homed.legs[0].began_s
        return (
            f"board {self.unit} axis {homed.plan.axis}: home found at {homed.edge.position_steps} "
            f"steps, now position 0; stands on {homed.position_steps}, {len(homed.legs)} legs in "
            f"{seconds:.1f} s"
        )


@operation("board measure-play")
class MeasurePlay(_Homing):
    """Measure the play of an axis by its home switch.

    By a CSV or CSB profile, with the options of `pixstep board home`; nothing is zeroed. The slow
    approaches are at 1 step/px unless --slow says more: a step must take longer than the switch's
    contact needs to follow.
    """

    result = AxisPlay

    repeat: int = option(Whole(1, 100), "Slow approaches from either side.", default=5)
    hysteresis: int | None = option(
        Steps(0),
        "Hysteresis of the switch: how far below its closing point it opens, by its data sheet. "
        "Without it the play found includes the hysteresis.",
    )  # fmt: skip
    encoder: str | None = option(
        TEXT,
        "Command that prints the load's position in steps, run while the axis rests: it tells "
        "play and hysteresis apart.",
        shown="COMMAND",
    )  # fmt: skip
    save: bool = flag("Write the play into the machine file.")

    def run(self, desk: Desk) -> Result:
        """Measure the play, and save it if asked."""
        motor = self.motor_to_save(desk) if self.save else None
        if self.encoder is not None and self.hysteresis is not None:
            raise AskedError("{encoder} finds the hysteresis itself: leave {hysteresis} out")
        read = play_measurement.of_command(self.encoder) if self.encoder is not None else None
        slow = self.slow or parse("2" if self.decode == SMOOTH else "1", SPEED)
        with bus.one_board(desk, self) as (found, known):
            ready = replace(self, slow=slow).prepare_axis(desk, known)
            try:
                with desk.progress("measuring") as show, bus.stopping([ready.lines]):
                    measured = play_measurement.measure(
                        known.board, ready.plan, ready.pixel_hz, found.world, repeat=self.repeat,
                        hysteresis=self.hysteresis, encoder=read, progress=show,
                    )  # fmt: skip
            except HomingError as error:
                raise BoardError(f"board {self.unit}: {error}") from None
        texts = [self._text(measured)]
        if motor:
            from pixstep.machine import files  # pydantic takes a while to load

            files.set_backlash(*motor, measured.play)
            texts.append(f"{motor[0]}: motors.{motor[1]}.backlash = {measured.play} steps")
        saved = str(motor[0]) if motor else None
        data = {"unit": self.unit, "saved": saved} | measured.as_json()
        return Result(data, "\n".join(texts))

    def motor_to_save(self, desk: Desk) -> tuple[Path, str]:
        """Return the machine file and its motor. Raises UserError if nothing says which motor."""
        found = desk.facts.found
        if found is None:
            raise AskedError(
                "{save}: no machine file: {machine} FILE and {motor} NAME say which motor"
            )
        return found.path, desk.facts.motor.name

    def _text(self, found: MeasuredPlay) -> str:
        """Return what was found, in a sentence."""
        if found.by_encoder:
            known = f"by the encoder, the switch's hysteresis {found.hysteresis:g} steps"
        elif found.hysteresis is None:
            known = "the switch's hysteresis within (--hysteresis takes it off)"
        else:
            known = f"hysteresis of {found.hysteresis:g} steps taken off"
        return (
            f"board {self.unit} axis {found.axis}: play {found.play} steps, {known}; "
            f"{len(found.approaches)} approaches from either side, {found.spread:g} steps apart"
        )
