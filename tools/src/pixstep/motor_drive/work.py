# SPDX-License-Identifier: MIT
"""What the bus' thread does for one motor: its commands taken, its motions made, its looks told."""

from __future__ import annotations

import logging
import math
from collections import deque
from dataclasses import replace

from pixstep.board.errors import (
    BoardError,
    EmergencyStoppedError,
    LineLostError,
    NoReplyError,
    OvertakenError,
)
from pixstep.motor_drive.feed import Steps, require_idle, stop
from pixstep.motor_drive.homing import Home
from pixstep.motor_drive.launching import (
    ArmedVerdict,
    Launching,
    broken_text,
    judge,
    misplaced_text,
    stopped_elsewhere,
)
from pixstep.motor_drive.motions import DrivenMotion, DrivenMove, Jog, WantedSpeeds, same
from pixstep.motor_drive.starting import DrivenMotor, MotionStart, Starting
from pixstep.motor_drive.statuses import Batch, Inbox, KnownAxis, Statuses, TurnGiver
from pixstep.motor_drive.watch import BoardSnapshot, BoardWatch
from pixstep.motor_record.traffic import MotorCommand, Verb, whole

_SILENT_S = 2.0  # a board that does not answer for less has not had its last word
_GRACE_S = 1.0  # for the record to answer the end of a first leg
_TARGETS = (Verb.MOVE_ABS, Verb.MOVE_REL, Verb.HOME_FOR, Verb.HOME_REV)
_log = logging.getLogger(__name__)


class AxisWork:
    """The motions of one motor. Every method is called by the bus' thread."""

    def __init__(
        self, owner: TurnGiver, watch: BoardWatch, motor: DrivenMotor, inbox: Inbox
    ) -> None:
        self._owner, self._watch, self._motor, self._inbox = owner, watch, motor, inbox
        self.known = KnownAxis(motor.unit, motor.axis)
        self.statuses = Statuses(inbox, watch, motor.name, self.known)
        self._starting = Starting(watch, motor)
        self._launching = Launching(owner, watch, motor, self.known, self._starting)
        self._wanted = WantedSpeeds()
        self._prepared: MotorCommand | None = None
        self._todo: deque[MotionStart | float] = deque()  # a float: the position to be loaded
        self._motion: DrivenMotion | None = None
        self._work: Steps | None = None
        self._work_due_s = 0.0
        self._stop_wanted = False
        self._resets = 0

    # When it wants a turn.

    def add_offset(self, steps: int) -> None:
        """Count from elsewhere; from any thread, before the first command."""
        self.known.offset_steps += steps
        self.statuses.position_steps += steps

    @property
    def stop_due(self) -> bool:
        """True if a stop is to go out now, before all else."""
        return self._stop_wanted or self._inbox.has_stop

    @property
    def launches(self) -> bool:
        """True while a motion has not begun: its requests come before looks and streams."""
        motion = self._motion
        begins = self._work is not None and motion is not None and motion.armed_s is None
        return begins and self._work_due_s <= self._owner.now_s()

    @property
    def left_s(self) -> float:
        """How long its queue lasts that is empty soon and would break off its line; else inf."""
        motion, now_s = self._motion, self._owner.now_s()
        if motion is None or motion.armed_s is None or motion.feed is None or self._work is None:
            return math.inf
        return motion.feed.left_s(now_s - motion.armed_s) if self._work_due_s <= now_s else math.inf

    @property
    def due_s(self) -> float:
        """When a request of a stream is due."""
        motion = self._motion
        if motion is None or self._work is None:
            return math.inf
        return min(self._work_due_s, motion.due_s())

    @property
    def look_due_s(self) -> float:
        """When a motion is expected to end, or its first leg: the board is to be looked at then."""
        return math.inf if self._motion is None else self._motion.look_due_s()

    @property
    def gives_up_s(self) -> float:
        """When a motion must be over of a board that does not answer."""
        if self._motion is None or self.known.look is None or not self._watch.failures:
            return math.inf
        return max(self._motion.ends_s(), self.known.look.time_s + _SILENT_S)

    @property
    def busy(self) -> bool:
        """True while there is a motion."""
        return self._motion is not None

    # Its turns.

    def take(self) -> None:
        """Take what has come in; nothing is asked of the board."""
        batches = self._inbox.take()
        if self._inbox.closed:
            self._todo.clear()
            going = self._motion is not None and not self._motion.stopping
            self._stop_wanted = self._stop_wanted or going
            return
        for batch in batches:
            self.statuses.order = batch.order
            try:
                self._batch(batch)
            except (ValueError, OverflowError) as error:  # no number that a motor can go to
                said = " ".join(map(str, batch.commands))
                self.statuses.problem, self.statuses.at_once = f"{said}: {error}", True
        self._advance()

    def send_stop(self) -> None:
        """Send a stop: one request, and more only if it is not acknowledged."""
        self.take()
        if isinstance(self._motion, Home):
            self._motion.interrupt()
        with self._watch.guarded():
            stop(self._watch.board, self._motor.axis)
        self._stop_wanted, self._work = False, None
        if self._motion is not None:
            self._motion.stopping = True
        self.statuses.at_look = True
        self._watch.look_soon()

    def step(self) -> None:
        """Do one request of what this axis has to do."""
        motion, work = self._motion, self._work
        if motion is None or work is None:
            return
        now_s = self._owner.now_s()
        if motion.queue_more(now_s):
            self._work_due_s = 0.0
        try:
            with self._watch.guarded():
                pause_s = next(work)
            self._work_due_s = now_s + pause_s if pause_s else 0.0
        except StopIteration:
            self._work = None
        except (NoReplyError, LineLostError) as error:
            self._unanswered(str(error))
        except BoardError as error:
            elsewhere = isinstance(error, OvertakenError | EmergencyStoppedError)
            self.statuses.stopped_elsewhere = elsewhere
            self._refused(motion, str(error))

    def looked(self, look: BoardSnapshot) -> None:
        """Take what the board says now."""
        self.known.look = look
        self._launching.looked()
        if self._resets != self._watch.resets:
            self._resets = self._watch.resets
            self._was_reset()
        axis, motion = self.known.axis, self._motion
        if motion is None:
            self._show(moves=axis.moves)
            self._advance()
        elif isinstance(motion, Home) and motion.armed_s is not None:
            self._judge_home(motion)
        elif motion.stopping:
            self._show(moves=True) if axis.moves else self._end_stopped(motion, look)
        elif motion.armed_s is not None:
            self._judge(motion, look)
        elif self._work is None:  # it did not get as far as that, and the board is back
            self._resume(motion)

    def lost(self) -> None:
        """Take that the board does not answer."""
        if self._owner.now_s() >= self.gives_up_s:
            self._forget_motion()
            self.statuses.problem = "the board did not answer to the end of a motion"
        self.statuses.tell_news(moves=self._motion is not None)

    def failed(self, text: str) -> None:
        """Take that this drive has failed: its motor is stopped."""
        self._todo.clear()
        self.statuses.problem, self._work = text, None
        self._stop_wanted = True

    # Commands.

    def _batch(self, batch: Batch) -> None:
        motion = self._motion
        if (
            isinstance(motion, DrivenMove)
            and motion.holding
            and self._answered(motion, batch.commands)
        ):
            return
        for command in batch.commands:
            self._command(command, batch.second_leg)

    def _answered(self, motion: DrivenMove, commands: tuple[MotorCommand, ...]) -> bool:
        """Take the record's answer to the end of a first leg; True if it is what was announced."""
        if commands and all(one.verb is Verb.GET_INFO for one in commands):
            return True
        motion.holding = False
        if not same(commands, motion.announced):
            self._stop_wanted = True
            return False
        motion.confirmed = True
        motion.turn_to_second()
        for command in commands:
            self._wanted.take(command)
        self.statuses.plus = motion.direction > 0
        self.statuses.tell(moves=True)
        self._watch.look_soon()
        return True

    def _command(self, command: MotorCommand, second_leg: tuple[MotorCommand, ...]) -> None:
        verb = command.verb
        if self._wanted.take(command):
            return
        if verb in _TARGETS:
            self._prepared = command
        elif verb is Verb.GO:
            self._go(second_leg)
        elif verb is Verb.JOG:
            self._begin(MotionStart(command))
        elif verb is Verb.JOG_VELOCITY:
            self._change_jog(command)
        elif verb is Verb.STOP_AXIS:
            self._todo.clear()
            self._stop_wanted = True
        elif verb is Verb.LOAD_POS:
            self._todo.append(float(command.argument or 0.0))
        elif verb is Verb.GET_INFO:
            self.statuses.at_look = True
            self._watch.look_soon()

    def _go(self, second_leg: tuple[MotorCommand, ...]) -> None:
        """Begin what was prepared; a relative move goes from where the record has seen it."""
        prepared, self._prepared = self._prepared, None
        self.statuses.at_once = True
        if prepared is None:
            return
        if prepared.verb is Verb.MOVE_REL:
            target = self.statuses.position_steps + (prepared.argument or 0.0)
            prepared = MotorCommand(Verb.MOVE_ABS, target)
        self._begin(MotionStart(prepared, second_leg))

    def _begin(self, start: MotionStart) -> None:
        """Begin a motion; what moves already is stopped before, unless it is the same."""
        self.statuses.at_once = True
        motion, verb = self._motion, start.command.verb
        if self._watch.failures:  # not kept for later: nobody would expect it then
            return
        going = motion is not None and not (motion.stopping or self._stop_wanted)
        if isinstance(motion, Jog) and verb is Verb.JOG and going:
            self._change_jog(start.command)
            return
        if (
            motion is not None
            and going
            and verb is Verb.MOVE_ABS
            and motion.leads_to(whole(start.command.argument))
        ):
            return
        self._todo = deque(one for one in self._todo if not isinstance(one, MotionStart))
        self._todo.append(start)
        self._stop_wanted = self._stop_wanted or going

    def _change_jog(self, command: MotorCommand) -> None:
        motion, velocity = self._motion, command.argument or 0.0
        for at, one in enumerate(self._todo):
            if isinstance(one, MotionStart) and one.command.verb is Verb.JOG:
                self._todo[at] = MotionStart(MotorCommand(Verb.JOG, velocity))
        if isinstance(motion, Jog) and not motion.stopping:
            wanted = replace(self._wanted.kinematics, speed_steps_s=abs(velocity))
            motion.change(velocity, self._starting.limited(wanted))
            self.statuses.plus = motion.direction > 0

    def _advance(self) -> None:
        """Do what is next as soon as the motor rests."""
        while self._todo and self.known.look and not (self._motion or self._stop_wanted):
            item = self._todo.popleft()
            if isinstance(item, float):
                self._load(item)
            else:
                self._start(item)
        if self.statuses.at_once and not (self._stop_wanted or self._holding):
            self.statuses.tell(moves=self._moves)

    def _load(self, position: float) -> None:
        """Make a position that of the motor where it is."""
        self.known.load(whole(position))
        self._launching.position_is_set()
        self.statuses.problem = ""
        self.statuses.stopped_elsewhere = False
        self.statuses.position_steps = self.known.position_steps
        self.statuses.at_once = True

    def _start(self, start: MotionStart) -> None:
        """Begin a motion from rest."""
        self.statuses.problem, self.statuses.at_once = "", True
        self.statuses.stopped_elsewhere = False
        try:
            if not self._launching.left:
                require_idle(self.known.axis.state, self._motor.axis)
            if self.known.lost and start.command.verb is Verb.MOVE_ABS:
                raise BoardError(self.known.lost_text)
            wanted = self._wanted.kinematics
            motion = self._starting.motion(start, self.known.axis, self.known.offset_steps, wanted)
        except BoardError as error:
            self.statuses.problem = str(error)
            return
        if motion is None:
            return
        self._motion, self.statuses.plus = motion, motion.direction > 0
        self._work, self._work_due_s = self._launching.begin(motion, self._wanted), 0.0

    # Motions.

    def _judge(self, motion: DrivenMotion, look: BoardSnapshot) -> None:
        """Judge a motion under way by what the board says."""
        verdict = judge(motion, self.known.axis, self._owner.now_s())
        if verdict is ArmedVerdict.OVER:
            self._end(misplaced_text(motion, self.known.position_steps))
        elif verdict is ArmedVerdict.BROKEN:
            self.statuses.stopped_elsewhere = stopped_elsewhere(look, self._motor.axis)
            self._end(broken_text(look, self._watch.unit, self._motor.axis))
        elif verdict is ArmedVerdict.FIRST_OVER and isinstance(motion, DrivenMove):
            self._first_over(motion)
        else:
            if verdict is ArmedVerdict.AGAIN:
                self._again(motion)
            self._show(moves=True)

    def _end_stopped(self, motion: DrivenMotion, look: BoardSnapshot) -> None:
        """The motor rests after a stop: the record's, or because the board took no more of it."""
        if motion.refused:
            self.statuses.stopped_elsewhere = stopped_elsewhere(look, self._motor.axis)
        self._end("")

    def _judge_home(self, motion: Home) -> None:
        if not motion.over or self.known.axis.moves:
            self._show(moves=True)
            return
        motion.forget()
        if motion.homed:
            self.known.homed()
            self.statuses.homed = True
        self._end(motion.text)

    def _first_over(self, motion: DrivenMove) -> None:
        """Tell the end of the first leg, once; then wait for the record's answer."""
        now_s = self._owner.now_s()
        if not motion.holding:
            motion.holding, motion.hold_until_s = True, now_s + _GRACE_S
            self.statuses.position_steps = motion.first.target_steps
            self.statuses.tell(moves=False)
        elif now_s > motion.hold_until_s:
            motion.holding = False
            self._stop_wanted = True

    def _again(self, motion: DrivenMotion) -> None:
        """Begin lines that came when those before them were over."""
        feed, axis = motion.feed, self.known.axis
        if feed is None:
            return
        if isinstance(motion, Jog) and axis.state == "done":
            motion.ran_dry()
        motion.armed_s = None
        self._work, self._work_due_s = self._launching.again(motion, feed, axis.registers), 0.0

    def _resume(self, motion: DrivenMotion) -> None:
        """Go on with a motion whose launch was broken off, or end it."""
        if self.known.axis.state in ("armed", "running") and motion.feed is not None:
            motion.armed(self._owner.now_s())
            self._work = motion.feed.stream()
            self._show(moves=True)
            return
        self._launching.left = True
        self._end("the board did not answer when a motion was to begin")

    def _unanswered(self, text: str) -> None:
        """A request had no answer: what the board does is not known until it is looked at."""
        motion, self._work = self._motion, None
        if motion is not None and motion.armed_s is not None and motion.feed is not None:
            self._work = motion.feed.stream()
            self._work_due_s = self._owner.now_s() + self._watch.pause_s
        _log.info("%s: %s", self._motor.name, text)

    def _refused(self, motion: DrivenMotion, text: str) -> None:
        """The board refuses a motion; what it has queued of it is forgotten at the next start."""
        self._work = None
        if motion.armed_s is None:
            self._launching.left = True
            self._end(text)
        else:
            self.statuses.problem, self._stop_wanted, motion.refused = text, True, True

    def _end(self, text: str) -> None:
        """The motor rests."""
        self._forget_motion()
        self.statuses.problem = text or self.statuses.problem
        self.statuses.position_steps = self.known.position_steps
        if not any(isinstance(one, MotionStart) for one in self._todo):
            self.statuses.tell(moves=False)
        self._advance()

    def _forget_motion(self) -> None:
        if isinstance(self._motion, Home):
            self._motion.interrupt()
        self._launching.seeks_no_more()
        self._motion = self._work = None

    def _was_reset(self) -> None:
        """A board that was reset counts from 0: the last position is shown, and is not to trust."""
        self.known.lose(self.statuses.position_steps)
        self.statuses.homed = False
        self._forget_motion()
        self._todo.clear()
        self.statuses.problem, self.statuses.at_look = self.known.lost_text, True

    # What is known.

    @property
    def _holding(self) -> bool:
        """True from the end of a first leg until the record has answered it."""
        return isinstance(self._motion, DrivenMove) and self._motion.holding

    @property
    def _moves(self) -> bool:
        return self._motion is not None or self.known.moves

    def _show(self, *, moves: bool) -> None:
        """Tell a look at the axis: each one that moves, another one if it says something new."""
        if self._holding:
            return
        self.statuses.position_steps = self.known.position_steps
        if moves:
            self.statuses.tell(moves=True)
        else:
            self.statuses.tell_news(moves=False)
