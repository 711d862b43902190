# SPDX-License-Identifier: MIT
"""What a look at an axis says of the motion that its drive has begun."""

from __future__ import annotations

from enum import Enum, auto

from pixstep.motor_drive.feed import lines_since
from pixstep.motor_drive.motions import DrivenMotion, DrivenMove
from pixstep.motor_drive.watch import AxisLook, BoardSnapshot

_LIMITS = ("limit_minus", "limit_plus")
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
    return look.axes[axis].state != "fault" or look.fault == "estop"


def misplaced_text(motion: DrivenMotion, position_steps: int) -> str:
    """Return what is wrong with where a motion has ended; "" if nothing is."""
    if not isinstance(motion, DrivenMove) or position_steps == motion.target_steps:
        return ""
    return f"the move ended at {position_steps} instead of {motion.target_steps} steps"
