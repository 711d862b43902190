# SPDX-License-Identifier: MIT
"""The requests with which a motion begins, one at a time, as generators: see `feed.py`.

What others have left on the axis is cleared first; then lines are queued and armed, or a homing is
begun in its own thread.

What a look at an axis says of the motion that its drive has begun.
"""

from __future__ import annotations

from enum import Enum, auto

from pixstep.board.errors import BoardError, EmergencyStoppedError, LineLostError, NoReplyError
from pixstep.motor_drive.feed import Feed, Steps, clear_fault, discard, lines_since
from pixstep.motor_drive.homing import Home, plan_of
from pixstep.motor_drive.motions import DrivenMotion, DrivenMove, WantedSpeeds
from pixstep.motor_drive.starting import DrivenMotor, Starting
from pixstep.motor_drive.statuses import KnownAxis, TurnGiver
from pixstep.motor_drive.watch import AxisLook, BoardSnapshot, BoardWatch

_LIMITS, _ESTOP = ("limit_minus", "limit_plus"), "estop"
_OVER = ("done", "loaded")  # the lines that were there have ended; loaded is one that came late


class ArmedVerdict(Enum):
    """What is to be done about a motion that was armed."""

    MOVES = auto()
    FIRST_OVER = auto()
    """The first of two legs has ended; the board goes on, or waits with the second one."""
    AGAIN = auto()
    """Lines came too late to follow: they are to be armed."""
    OVER = auto()
    """It has ended at its target."""
    BROKEN = auto()
    """It has ended elsewhere."""


def judge(motion: DrivenMotion, axis: AxisLook, now_s: float) -> ArmedVerdict:
    """Return the verdict on a move or a jog that is not being stopped."""
    if axis.state in ("fault", "empty", "refused"):
        return ArmedVerdict.MOVES if axis.stopping else ArmedVerdict.BROKEN
    over = axis.state in _OVER
    if isinstance(motion, DrivenMove):
        return _judge_move(motion, over, lines_since(axis.lines_done, motion.lines_before), now_s)
    return ArmedVerdict.AGAIN if over else ArmedVerdict.MOVES


def _judge_move(motion: DrivenMove, over: bool, made: int, now_s: float) -> ArmedVerdict:
    """Return the verdict on a move of which so many lines were made.

    A line that another one follows counts as made when its end was decoded, before its last steps.
    The time of the first leg must be over as well.
    """
    if motion.queued_second and not motion.confirmed:
        past = made >= motion.first_lines and now_s >= (motion.armed_s or 0.0) + motion.first_s
        if past or (over and made >= motion.first_lines):
            return ArmedVerdict.FIRST_OVER
    elif over and made >= motion.lines:
        return ArmedVerdict.OVER
    if not over:
        return ArmedVerdict.MOVES
    late = made >= motion.first_lines and motion.confirmed
    return ArmedVerdict.AGAIN if late else ArmedVerdict.BROKEN


def broken_text(look: BoardSnapshot, unit: int, axis: int) -> str:
    """Return why a motion has ended elsewhere; "" for its own limit switch, which has a bit."""
    if look.axes[axis].state != "fault":
        return "another program has ended the motion"
    if look.fault in _LIMITS and look.fault_axis == axis:
        return ""
    return f"axis {look.fault_axis} of board {unit}: fault {look.fault}"


def stopped_elsewhere(look: BoardSnapshot, axis: int) -> bool:
    """Whether somebody has stopped a motion that has ended before its time."""
    return look.axes[axis].state != "fault" or look.fault == _ESTOP


def misplaced_text(motion: DrivenMotion, position_steps: int) -> str:
    """Return what is wrong with where a motion has ended; "" if nothing is."""
    if not isinstance(motion, DrivenMove) or position_steps == motion.target_steps:
        return ""
    return f"the move ended at {position_steps} instead of {motion.target_steps} steps"


_SEEKS_S = 0.05  # between two looks whether another axis of the board seeks its switch


class Launching:
    """Begins the motions of one motor. Every method is called by the bus' thread."""

    def __init__(
        self,
        owner: TurnGiver,
        watch: BoardWatch,
        motor: DrivenMotor,
        known: KnownAxis,
        starting: Starting,
    ) -> None:
        self._owner, self._watch, self._motor = owner, watch, motor
        self._known, self._starting = known, starting
        self.left = False
        """Whether a part of a line that this drive has queued is there and will not run."""
        self._estop_seen = False  # whether a person has spoken since the stop was released

    def begin(self, motion: DrivenMotion, wanted: WantedSpeeds) -> Steps:
        """Begin a motion; `wanted` are the speeds of a homing."""
        return self._homing(motion, wanted) if isinstance(motion, Home) else self._lines(motion)

    def _lines(self, motion: DrivenMotion) -> Steps:
        """Queue and arm; what the board was left with by others is cleared away before.

        The emergency stop is not, but by a person: nothing may move because it was released.
        """
        if self._estop_latched and not self._estop_seen:
            raise EmergencyStoppedError(
                f"board {self._motor.unit}: the emergency stop is latched: release it, then home "
                f"the axis or set its position"
            )
        yield from self._clear()
        for last in (False, True):
            axis = self._known.axis
            motion.lines_before = axis.lines_done
            feed = motion.feed = Feed(
                self._watch.board, self._motor.axis, motion.entries(), axis.registers,
                1 / self._watch.pixel_hz,
            )  # fmt: skip
            if isinstance(motion, DrivenMove):
                motion.begin_second_at_once()
            try:
                yield from feed.begin(self._owner.motions - 1)
                break
            except (NoReplyError, LineLostError):
                raise
            except BoardError:
                if last:
                    raise
            yield from discard(self._watch.board, self._motor.axis)
            yield from self._look()  # another program was here since the last look
        yield from self._stream(motion, feed)

    def again(self, motion: DrivenMotion, feed: Feed, registers: dict[str, int]) -> Steps:
        """Arm lines that came when those before them were over; `registers` are the axis'."""
        yield from feed.begin_again(registers)
        yield from self._stream(motion, feed)

    def seeks_no_more(self) -> None:
        """Let other axes of the board seek their switches."""
        if self._watch.seeks is self:
            self._watch.seeks = None

    def _homing(self, motion: Home, wanted: WantedSpeeds) -> Steps:
        """Begin a homing, when no other axis of the board seeks a switch."""
        while self._watch.seeks not in (None, self):
            yield _SEEKS_S
        self._watch.seeks = self
        yield from self._clear()
        plan = plan_of(
            self._watch, self._motor.axis, motion.direction,
            self._starting.limited(wanted.kinematics), self._motor.search_steps,
            self._known.axis.registers["queue_free"],
        )  # fmt: skip
        yield 0.0
        motion.start(self._watch, plan, self._home_over)
        self._armed(motion)

    def _armed(self, motion: DrivenMotion) -> None:
        motion.armed(self._owner.now_s())
        self._watch.look_soon()

    def _stream(self, motion: DrivenMotion, feed: Feed) -> Steps:
        """Go on with a motion that was armed just now."""
        self._armed(motion)
        yield from feed.stream()

    def _home_over(self) -> None:
        """The thread of a homing has ended; it calls this."""
        self._watch.look_soon()
        self._owner.wake()

    @property
    def _estop_latched(self) -> bool:
        return bool(self._known.look and self._known.look.fault == _ESTOP)

    @property
    def _estop_released(self) -> bool:
        look = self._known.look
        return self._estop_latched and not (look and look.estop)

    def position_is_set(self) -> None:
        """Take that a person has said where the motor is, perhaps after an emergency stop."""
        self._estop_seen = self._estop_released

    def looked(self) -> None:
        """Take a look of the board: what was said before the stop is pressed counts no more."""
        self._estop_seen = self._estop_seen and self._estop_released

    def _clear(self) -> Steps:
        """Clear a fault, or discard a part of a line that will not run."""
        look = self._known.look
        if look and look.fault:
            clear_fault(self._watch.board, len(look.axes))
            yield 0.0
        elif self.left or self._known.axis.state in ("refused", "loading"):
            yield from discard(self._watch.board, self._motor.axis)
        else:
            return
        self.left = False
        yield from self._look()

    def _look(self) -> Steps:
        self._known.look = self._watch.look()
        yield 0.0
