# SPDX-License-Identifier: MIT
"""The drive of one motor: a record's commands become motions of a board's axis, statuses go back.

Two sides share it. Any thread may call what `traffic.Drive` promises: `connect`, `obey`, `close`.
The bus' own thread does the rest, one request at a time, when `bus.BusDrives` gives it its turn.

    obey --> inbox --> take(): actions --> a motion --> step(): blocks, arm, stream
                                              ^                     |
                        statuses <-- looked(): what the board says of it

A motion has ended when the board says that its axis rests and is not stopping: no STEP edge can
come then. If the board does not answer, the motion has ended when the last line that was queued
must be over.

*Second legs.* `obey` may announce what the record will ask for next, the final approach against
backlash. Its line is queued some 1.2 s before the first leg ends, and the board goes from leg to
leg by itself. The record sees the first leg end: one DONE status at the first leg's target. Until
it answers nothing is reported. If it gives the commands that it has announced, they are already
being carried out and move nothing twice. If it gives others, or none within a second, the board is
stopped, and they begin where the motor is then. The lines of a drive never take up backlash by
themselves: the record's two legs do it.

*Positions* are the board's register and an offset that the drive keeps: see `seam.py`. After a
reset of the board the position is unknown: the last one is shown with PROBLEM, and no move begins
until a homing or LOAD_POS has given the position a meaning; a jog may.
"""

from __future__ import annotations

import logging
import math
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from pixstep.board.errors import BoardError, LineLostError, NoReplyError
from pixstep.motor_drive import seam
from pixstep.motor_drive.feed import Feed, Steps, lines_since, require_idle
from pixstep.motor_drive.motions import (
    Jog,
    Leg,
    Motion,
    Move,
    Pixels,
    Wanted,
    same,
    second_of,
    whole,
)
from pixstep.motor_drive.watch import AxisLook, BoardWatch, Look
from pixstep.motor_record.traffic import Command, Msta, Status, Verb
from pixstep.moves.trapezoid import Kinematics

OnStatus = Callable[[Status], None]
_GRACE_S = 1.0  # for the record to answer the end of a first leg
_TARGETS = (Verb.MOVE_ABS, Verb.MOVE_REL, Verb.HOME_FOR, Verb.HOME_REV)
_LIMITS = {"limit_minus": -1, "limit_plus": 1}
_log = logging.getLogger(__name__)


class Owner(Protocol):
    """The bus that gives a drive its turns."""

    def wake(self) -> None:
        """There is something to do; from any thread."""

    def now_s(self) -> float:
        """Return the boards' time."""


@dataclass(frozen=True)
class DrivenMotor:
    """A motor: its name, its place, and the limits that its machine has for it, if any."""

    name: str
    unit: int
    axis: int
    max_speed_steps_s: float | None = None
    max_acceleration_steps_s2: float | None = None
    search_steps: int = 1_000_000
    """After how many steps a leg of a homing gives up."""


@dataclass(frozen=True)
class _Start:
    """A motion that is to begin: its prepared command, and what was announced behind it."""

    command: Command
    announced: tuple[Command, ...] = ()


class AxisDrive:
    """A `traffic.Drive` of one motor; `bus.BusDrives` makes them."""

    def __init__(self, owner: Owner, watch: BoardWatch, motor: DrivenMotor) -> None:
        self.motor = motor
        self._owner, self._watch = owner, watch
        self._lock = threading.Lock()
        self._inbox: deque[tuple[tuple[Command, ...], tuple[Command, ...], int]] = deque()
        self._orders = self._taken = 0
        self._on_status: OnStatus | None = None
        self._stop_asked = self.closed = False
        # From here on the bus' thread alone.
        self._wanted = Wanted()
        self._prepared: Command | None = None
        self._todo: deque[_Start | float] = deque()  # a float: the position to be loaded
        self._motion: Motion | None = None
        self._work: Steps | None = None
        self._work_due_s = 0.0
        self._stop_wanted = False
        self._report = False  # a status at once
        self._asked = False  # a status by the next look
        self._offset_steps = 0
        self._unknown = False
        self._resets = 0
        self._problem = ""
        self._plus = True
        self._homed = False
        self._last: Status | None = None
        self._last_order = 0
        self._shown_steps = 0
        self._look: Look | None = None
        self._before: tuple[float, int] | None = None

    # What any thread may call.

    def connect(self, on_status: OnStatus) -> None:
        """Begin to report; the first status follows the next look at the board."""
        with self._lock:
            self._on_status = on_status
            self._inbox.append(((Command(Verb.GET_INFO),), (), self._orders))
        self._owner.wake()

    def obey(self, commands: Sequence[Command], second_leg: Sequence[Command] = ()) -> None:
        """Take the commands of one Outcome, in order.

        No commands at all, while the end of a first leg was reported last, say that the second leg
        is not wanted.
        """
        with self._lock:
            self._orders += 1
            self._inbox.append((tuple(commands), tuple(second_leg), self._orders))
            if any(one.verb is Verb.STOP_AXIS for one in commands):
                self._stop_asked = True
        self._owner.wake()

    def overtaken(self, status: Status) -> bool:
        """Whether a status that was reported is older than the newest call of `obey`.

        Whoever hands statuses from the bus' thread to another one asks this there, and drops those
        that are: a motor that rested before a GO would else look like the end of the move. A newer
        status always follows.
        """
        with self._lock:
            return getattr(status, "_order", self._orders) < self._orders

    @property
    def problem(self) -> str:
        """Why PROBLEM or COMM_ERR is set, in words; "" if neither is."""
        return self._watch.trouble or self._problem

    @property
    def top_speed_steps_s(self) -> float:
        """The highest speed that the board makes while all of its motors move; 0: not known yet.

        A motor's own `max_speed_steps_s` counts as well.
        """
        board = self._watch.top_steps_px * self._watch.pixel_hz if self._watch.limits else 0.0
        return min(board, self.motor.max_speed_steps_s or board)

    def close(self) -> None:
        """Stop the motor if this drive moves it, and report nothing more."""
        with self._lock:
            self._on_status, self.closed = None, True
        self._owner.wake()

    # What the bus' thread calls.

    @property
    def stop_due(self) -> bool:
        """True if a stop is to go out now, before all else."""
        with self._lock:
            return self._stop_wanted or self._stop_asked

    @property
    def launches(self) -> bool:
        """True while a motion has not begun: its requests come before looks and streams."""
        motion = self._motion
        return self._work is not None and motion is not None and motion.armed_s is None

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
        motion = self._motion
        if motion is None or motion.armed_s is None or isinstance(motion, Jog):
            return math.inf
        if isinstance(motion, Move) and motion.holding:
            return motion.hold_until_s
        if isinstance(motion, Move) and motion.second and not motion.confirmed:
            return motion.armed_s + motion.first_s
        return motion.armed_s + motion.queued_s

    @property
    def busy(self) -> bool:
        """True while there is a motion."""
        return self._motion is not None

    def take(self) -> None:
        """Take what has come in; nothing is asked of the board."""
        with self._lock:
            batches = list(self._inbox)
            self._inbox.clear()
            self._stop_asked = False
        if self.closed:
            self._todo.clear()
            self._stop_wanted = self._stop_wanted or (
                self._motion is not None and not self._motion.stopping
            )
            return
        for commands, second_leg, order in batches:
            self._taken = order
            self._batch(commands, second_leg)
        self._advance()

    def send_stop(self) -> None:
        """Send a stop: one request, and more only if it is not acknowledged."""
        self.take()
        with self._watch.guarded():
            seam.stop(self._watch.board, self.motor.axis)
        self._stop_wanted = False
        self._work = None
        if self._motion is not None:
            self._motion.stopping = True
        self._asked = True
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
            self._broken(str(error))
        except BoardError as error:
            self._refused(motion, str(error))

    def looked(self, look: Look) -> None:
        """Take what the board says now."""
        self._look = look
        if self._resets != self._watch.resets:
            self._resets = self._watch.resets
            self._was_reset(look)
        axis = look.axes[self.motor.axis]
        motion = self._motion
        if motion is None:
            self._show(axis, moves=axis.moves)
            self._advance()
        elif motion.stopping:
            if axis.moves:
                self._show(axis, moves=True)
            else:
                self._end("")
        elif motion.armed_s is not None:
            self._judge(motion, axis, look)
        elif self._work is None:  # it did not get as far as that, and the board is back
            self._resume(motion, axis)

    def lost(self) -> None:
        """Take that the board does not answer."""
        motion = self._motion
        if motion is not None and self._owner.now_s() > motion.ends_s():
            self._motion, self._work = None, None
            self._problem = "the board did not answer to the end of a motion"
        moves = self._motion is not None
        if self._report or self._status(moves=moves) != self._last:
            self._tell(moves=moves)

    # Commands.

    def _batch(self, commands: tuple[Command, ...], second_leg: tuple[Command, ...]) -> None:
        motion = self._motion
        if isinstance(motion, Move) and motion.holding:
            if self._answered(motion, commands):
                return
            motion = self._motion
        for command in commands:
            self._command(command, second_leg)

    def _answered(self, motion: Move, commands: tuple[Command, ...]) -> bool:
        """Take the record's answer to the end of a first leg; True if it is what was announced."""
        if commands and all(one.verb is Verb.GET_INFO for one in commands):
            return True
        motion.holding = False
        if same(commands, motion.announced):
            motion.confirmed = True
            motion.turn_to_second()
            for command in commands:
                self._wanted.take(command)
            self._tell(moves=True)
            self._watch.look_soon()
            return True
        self._stop_wanted = True
        return False

    def _command(self, command: Command, second_leg: tuple[Command, ...]) -> None:
        verb = command.verb
        if self._wanted.take(command):
            return
        if verb in _TARGETS:
            self._prepared = command
        elif verb is Verb.GO:
            prepared, self._prepared = self._prepared, None
            if prepared is not None:
                self._begin(_Start(self._absolute(prepared), second_leg))
            self._report = True
        elif verb is Verb.JOG:
            self._begin(_Start(command))
        elif verb is Verb.JOG_VELOCITY:
            self._change_jog(command)
        elif verb is Verb.STOP_AXIS:
            self._todo.clear()
            self._stop_wanted = True
        elif verb is Verb.LOAD_POS:
            self._todo.append(float(command.argument or 0.0))
        else:
            self._asked = True
            self._watch.look_soon()

    def _absolute(self, prepared: Command) -> Command:
        """Return a relative move as one to a target: from where the record has seen the motor."""
        if prepared.verb is not Verb.MOVE_REL:
            return prepared
        return Command(Verb.MOVE_ABS, self._shown_steps + (prepared.argument or 0.0))

    def _begin(self, start: _Start) -> None:
        """Begin a motion; what moves already is stopped before, unless it is the same."""
        if self._watch.failures:
            self._problem, self._report = self._watch.trouble, True
            return
        motion = self._motion
        if isinstance(motion, Jog) and start.command.verb is Verb.JOG and not motion.stopping:
            self._change_jog(start.command)
            return
        if (
            isinstance(motion, Move)
            and not (motion.stopping or self._stop_wanted)
            and start.command.verb is Verb.MOVE_ABS
            and whole(start.command.argument) == motion.target_steps
        ):
            return
        self._todo = deque(one for one in self._todo if not isinstance(one, _Start))
        self._todo.append(start)
        if motion is not None and not motion.stopping:
            self._stop_wanted = True

    def _change_jog(self, command: Command) -> None:
        motion, velocity = self._motion, command.argument or 0.0
        for at, one in enumerate(self._todo):
            if isinstance(one, _Start) and one.command.verb is Verb.JOG:
                self._todo[at] = _Start(Command(Verb.JOG, velocity))
        if isinstance(motion, Jog) and not motion.stopping:
            motion.change(velocity, self._kinematics(abs(velocity)))
            self._plus = motion.direction > 0

    def _advance(self) -> None:
        """Do what is next as soon as the motor rests."""
        while self._motion is None and not self._stop_wanted and self._todo:
            if self._look is None:
                break
            item = self._todo.popleft()
            if isinstance(item, float):
                self._load(item)
            else:
                self._start(item)
        if self._report and not self._stop_wanted and not self._holding:
            self._tell(moves=self._moves())

    def _load(self, position: float) -> None:
        axis = self._axis()
        self._offset_steps = seam.set_position(whole(position), axis.position_steps)
        self._unknown, self._problem = False, ""
        self._shown_steps = axis.position_steps + self._offset_steps
        self._report = True

    def _start(self, start: _Start) -> None:
        """Begin a motion from rest."""
        self._problem, self._report = "", True
        try:
            motion = self._made(start)
        except BoardError as error:
            self._problem = str(error)
            return
        if motion is None:
            return
        axis = self._axis()
        self._motion, self._plus = motion, motion.direction > 0
        motion.began_steps, motion.lines_before = axis.position_steps, axis.lines_done
        self._work, self._work_due_s = self._launch(motion), 0.0

    def _made(self, start: _Start) -> Motion | None:
        """Return the motion; None for one of no steps, or against a limit switch."""
        axis, verb, value = self._axis(), start.command.verb, start.command.argument or 0.0
        require_idle(axis.state, self.motor.axis)
        if verb is Verb.JOG:
            direction = (value > 0) - (value < 0)
            if not direction or self._at_limit(axis, direction):
                return None
            return Jog(value, self._kinematics(abs(value)), self._pixels())
        if verb is not Verb.MOVE_ABS:
            raise BoardError("homing is not there yet")
        if self._unknown:
            raise BoardError(self._lost_position())
        here, target = axis.position_steps + self._offset_steps, whole(value)
        if target == here or self._at_limit(axis, target - here):
            return None
        first = Leg(self._kinematics(), target)
        second = second_of(start.announced, self._wanted.kinematics, target)
        if second is not None:
            limited = self._limited(second.kinematics)
            second = Leg(limited, second.target_steps) if second.target_steps != target else None
        return Move(here, first, second, start.announced, self._pixels())

    # Motions.

    def _launch(self, motion: Motion) -> Steps:
        """Queue and arm; what the board was left with by others is cleared away before."""
        yield from self._clear()
        for last in (False, True):
            axis = self._axis()
            motion.began_steps, motion.lines_before = axis.position_steps, axis.lines_done
            motion.feed = Feed(self._watch.board, self.motor.axis, motion.entries(), axis.registers)
            if isinstance(motion, Move):
                motion.begin_second_at_once()
            try:
                yield from motion.feed.begin()
                break
            except (NoReplyError, LineLostError):
                raise
            except BoardError:
                if last:
                    raise
            yield from seam.discard(self._watch.board, self.motor.axis)
            self._look = self._watch.look()  # another program was here since the last look
            yield 0.0
        motion.armed(self._owner.now_s())
        self._watch.look_soon()
        if motion.feed is not None:
            yield from motion.feed.stream(1 / self._watch.pixel_hz)

    def _clear(self) -> Steps:
        look = self._look
        if look is not None and look.fault:
            seam.clear_fault(self._watch.board, len(look.axes))
            yield 0.0
        elif self._axis().state in ("refused", "loading"):
            yield from seam.discard(self._watch.board, self.motor.axis)
        else:
            return
        self._look = self._watch.look()
        yield 0.0

    def _judge(self, motion: Motion, axis: AxisLook, look: Look) -> None:
        """Judge a motion under way by what the board says."""
        made = lines_since(axis.lines_done, motion.lines_before)
        if axis.state == "fault":
            self._end(self._fault_text(look))
        elif axis.state in ("empty", "refused"):
            if axis.stopping:
                self._show(axis, moves=True)
            else:
                self._end("the motion was stopped by another program")
        elif isinstance(motion, Move):
            self._judge_move(motion, axis, made)
        elif axis.state in ("done", "loaded"):  # the next line of a jog came too late
            self._again(motion, axis)
            self._show(axis, moves=True)
        else:
            self._show(axis, moves=True)

    def _judge_move(self, motion: Move, axis: AxisLook, made: int) -> None:
        over = axis.state in ("done", "loaded")
        now_s = self._owner.now_s()
        if motion.second and motion.queued_second and not motion.confirmed:
            past = made >= 1 and motion.armed_s is not None
            if past and (over or now_s >= (motion.armed_s or 0.0) + motion.first_s):
                self._first_over(motion, now_s)
                return
        elif over and made >= motion.lines:
            self._end(self._misplaced(motion, axis))
            return
        if over and made >= 1 and motion.confirmed:
            self._again(motion, axis)
        elif over:
            self._end("the motion was ended by another program")
            return
        self._show(axis, moves=True)

    def _first_over(self, motion: Move, now_s: float) -> None:
        """Report the end of the first leg, once; then wait for the record's answer."""
        if not motion.holding:
            motion.holding, motion.hold_until_s = True, now_s + _GRACE_S
            self._shown_steps = motion.first.target_steps
            self._tell(moves=False)
        elif now_s > motion.hold_until_s:
            motion.holding = False
            self._stop_wanted = True

    def _again(self, motion: Motion, axis: AxisLook) -> None:
        """Begin lines that came when those before them were over."""
        feed = motion.feed
        if feed is None:
            return
        if isinstance(motion, Jog) and axis.state == "done":
            motion.ran_dry()
        motion.armed_s = None

        def work() -> Iterator[float]:
            yield from feed.begin_again(axis.registers)
            motion.armed(self._owner.now_s())
            yield from feed.stream(1 / self._watch.pixel_hz)

        self._work, self._work_due_s = work(), 0.0

    def _misplaced(self, motion: Move, axis: AxisLook) -> str:
        ends = axis.position_steps + self._offset_steps
        if ends == motion.target_steps:
            return ""
        return f"the move ended at {ends} instead of {motion.target_steps} steps"

    def _resume(self, motion: Motion, axis: AxisLook) -> None:
        """Go on with a motion whose launch was broken off, or end it."""
        if axis.state in ("armed", "running"):
            motion.armed(self._owner.now_s())
            if motion.feed is not None:
                self._work = motion.feed.stream(1 / self._watch.pixel_hz)
            self._show(axis, moves=True)
            return
        self._end("the board did not answer when a motion was to begin")

    def _broken(self, text: str) -> None:
        """A request had no answer: what the board does is not known until it is looked at."""
        motion = self._motion
        self._work = None
        if motion is not None and motion.armed_s is not None and motion.feed is not None:
            self._work = motion.feed.stream(1 / self._watch.pixel_hz)
            self._work_due_s = self._owner.now_s() + self._watch.pause_s
        _log.info("%s: %s", self.motor.name, text)

    def _refused(self, motion: Motion, text: str) -> None:
        """The board refuses a motion; what it has queued of it is forgotten at the next start."""
        self._work = None
        if motion.armed_s is None:
            self._end(text)
        else:
            self._problem, self._stop_wanted = text, True

    def _end(self, text: str) -> None:
        """The motor rests."""
        self._motion = self._work = None
        if text:
            self._problem = text
        follows = any(isinstance(one, _Start) for one in self._todo)
        self._shown_steps = self._axis().position_steps + self._offset_steps
        if not follows:
            self._tell(moves=False)
        self._advance()

    def _was_reset(self, look: Look) -> None:
        """A board that was reset counts from 0: the last position is shown, and is not to trust."""
        here = look.axes[self.motor.axis].position_steps
        self._offset_steps = self._shown_steps - here
        self._unknown, self._homed = True, False
        self._motion = self._work = None
        self._todo.clear()
        self._problem = self._lost_position()
        self._report = True

    def _lost_position(self) -> str:
        return (
            f"board {self._watch.unit} was reset: the position of axis {self.motor.axis} is not "
            f"known; home it, or set its position"
        )

    def _fault_text(self, look: Look) -> str:
        """Return what a fault means for this axis; "" for its own limit switch, which has a bit."""
        if look.fault in _LIMITS and look.fault_axis == self.motor.axis:
            return ""
        return f"axis {look.fault_axis} of board {self._watch.unit}: fault {look.fault}"

    # Statuses.

    @property
    def _holding(self) -> bool:
        """True from the end of a first leg until the record has answered it."""
        return isinstance(self._motion, Move) and self._motion.holding

    def _moves(self) -> bool:
        return self._motion is not None or (self._look is not None and self._axis().moves)

    def _show(self, axis: AxisLook, *, moves: bool) -> None:
        """Report a look at the axis: each one that moves, another one if it says something new."""
        if self._holding:
            return
        self._shown_steps = axis.position_steps + self._offset_steps
        if (
            not (moves or self._report or self._asked)
            and self._last is not None
            and (self._status(moves=moves) == self._last)
        ):
            return
        self._tell(moves=moves)

    def _tell(self, *, moves: bool) -> None:
        """Report the motor as it is now."""
        self._report = self._asked = False
        status = self._status(moves=moves)
        object.__setattr__(status, "_order", self._taken)
        self._last = status
        with self._lock:
            listener = self._on_status
        if listener is not None:
            try:
                listener(status)
            except Exception:
                _log.exception("%s: a listener to statuses failed", self.motor.name)

    def _status(self, *, moves: bool) -> Status:
        flags = Msta.MOVING if moves else Msta.DONE
        if self._plus:
            flags |= Msta.DIRECTION
        look = self._look
        if look is not None:
            switches = look.axes[self.motor.axis].switches
            for bit, on in (
                (Msta.PLUS_LS, switches.limit_plus),
                (Msta.MINUS_LS, switches.limit_minus),
                (Msta.HOME, switches.home),
                (Msta.PROBLEM, look.estop),
                (Msta.HOMED, self._homed),
            ):
                if on:
                    flags |= bit
        if self._problem:
            flags |= Msta.PROBLEM
        if self._watch.failures:
            flags |= Msta.COMM_ERR
        return Status(self._shown_steps, 0, flags, self._speed(moves=moves))

    def _speed(self, *, moves: bool) -> float:
        """Return the mean speed since the status before."""
        look, before = self._look, self._before
        if not moves or look is None:
            self._before = None
            return 0.0
        self._before = (look.time_s, self._shown_steps)
        if before is None or look.time_s <= before[0]:
            return 0.0
        return abs(self._shown_steps - before[1]) / (look.time_s - before[0])

    # The board.

    def _axis(self) -> AxisLook:
        assert self._look is not None
        return self._look.axes[self.motor.axis]

    def _pixels(self) -> Pixels:
        watch = self._watch
        return Pixels(watch.pixel_hz, watch.top_steps_px, watch.turns_below_steps_px, watch.rest_px)

    def _kinematics(self, speed_steps_s: float | None = None) -> Kinematics:
        wanted = self._wanted.kinematics
        if speed_steps_s is not None:
            wanted = replace(wanted, speed_steps_s=speed_steps_s)
        return self._limited(wanted)

    def _limited(self, wanted: Kinematics) -> Kinematics:
        """Return what board and motor can do of it."""
        most = self.motor.max_speed_steps_s or wanted.speed_steps_s
        wanted = replace(wanted, speed_steps_s=min(wanted.speed_steps_s, most))
        watch = self._watch
        return wanted.within(
            watch.top_steps_px, watch.pixel_hz, self.motor.max_acceleration_steps_s2
        )

    def _at_limit(self, axis: AxisLook, direction: int) -> bool:
        switches = axis.switches
        return switches.limit_plus if direction > 0 else switches.limit_minus
