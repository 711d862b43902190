# SPDX-License-Identifier: MIT
"""The statuses of one motor, from looks at its board and what its drive knows.

What is known of one axis: the newest look at its board, and what its positions count from.

What other threads leave for the bus' thread: commands, a stop, who listens.

What the drive of a motor wants of the bus that gives it its turns.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from pixstep.motor_drive.feed import set_position
from pixstep.motor_drive.watch import AxisLook, BoardSnapshot, BoardWatch
from pixstep.motor_record.traffic import MotorCommand, Msta, Status, Verb


class KnownAxis:
    """One axis of a board; the bus' thread alone."""

    def __init__(self, unit: int, axis: int) -> None:
        self._unit, self._axis = unit, axis
        self.look: BoardSnapshot | None = None
        """The newest look; None before the first."""
        self.offset_steps = 0
        """What is added to the board's register: see `set_position`."""
        self.lost = False
        """Whether the board was reset and the position is not known since."""

    @property
    def axis(self) -> AxisLook:
        """The axis at the newest look; there must be one."""
        assert self.look is not None
        return self.look.axes[self._axis]

    @property
    def moves(self) -> bool:
        """True if the axis moves or is about to."""
        return self.look is not None and self.axis.moves

    @property
    def position_steps(self) -> int:
        """The record's raw position."""
        return self.axis.position_steps + self.offset_steps

    @property
    def lost_text(self) -> str:
        """What is to be done about a position that is not known."""
        return (
            f"board {self._unit} was reset: the position of axis {self._axis} is not "
            f"known; home it, or set its position"
        )

    def load(self, position_steps: int) -> None:
        """Make a position that of the motor where it is."""
        self._count_from(position_steps)
        self.lost = False

    def homed(self) -> None:
        """Take that a homing has set the board's register."""
        self.offset_steps, self.lost = 0, False

    def lose(self, shown_steps: int) -> None:
        """Take that the board was reset: the position shown stays, and is not to be trusted."""
        self._count_from(shown_steps)
        self.lost = True

    def _count_from(self, position_steps: int) -> None:
        self.offset_steps = set_position(position_steps, self.axis.position_steps)


OnStatus = Callable[[Status], None]
_ANSWERED = (Verb.GO, Verb.JOG, Verb.STOP_AXIS, Verb.LOAD_POS)  # a status follows each
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Batch:
    """The commands of one Outcome, and what it has announced."""

    commands: tuple[MotorCommand, ...]
    second_leg: tuple[MotorCommand, ...]
    order: int


class Inbox:
    """The commands of one motor that nobody has taken yet; from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._batches: list[Batch] = []
        self._orders = 0
        self._listener: OnStatus | None = None
        self._stop = self._closed = False

    def listen(self, listener: OnStatus) -> None:
        """Let somebody hear statuses, from the next look at the board on."""
        with self._lock:
            self._listener = listener
            self._batches.append(Batch((MotorCommand(Verb.GET_INFO),), (), self._orders))

    def put(self, commands: Sequence[MotorCommand], second_leg: Sequence[MotorCommand]) -> None:
        """Leave commands."""
        with self._lock:
            self._orders += any(one.verb in _ANSWERED for one in commands)
            self._batches.append(Batch(tuple(commands), tuple(second_leg), self._orders))
            self._stop = self._stop or any(one.verb is Verb.STOP_AXIS for one in commands)

    def take(self) -> list[Batch]:
        """Take all that is there."""
        with self._lock:
            found, self._batches, self._stop = self._batches, [], False
            return found

    def close(self) -> None:
        """Let nobody hear anything more."""
        with self._lock:
            self._listener, self._closed = None, True

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return self._closed

    @property
    def has_stop(self) -> bool:
        """True if a stop is among what is there."""
        return self._stop

    def overtaken(self, status: Status) -> bool:
        """Whether a status was made before the newest command that another status answers."""
        with self._lock:
            return getattr(status, "_order", self._orders) < self._orders

    def tell(self, status: Status, order: int, name: str) -> None:
        """Let the listener hear a status, made when the commands up to `order` were taken."""
        object.__setattr__(status, "_order", order)
        with self._lock:
            listener = self._listener
        if listener is None:
            return
        try:
            listener(status)
        except Exception:
            _log.exception("%s: a listener to statuses failed", name)


class TurnGiver(Protocol):
    """The bus that gives a motor its turns."""

    def wake(self) -> None:
        """There is something to do; from any thread."""

    def now_s(self) -> float:
        """Return the boards' time."""

    @property
    def motions(self) -> int:
        """How many motions there are."""


class Statuses:
    """What was told last, what is to be told now; the bus' thread alone.

    `at_once` asks for a status as soon as commands were taken, `at_look` for one by the next look.
    """

    def __init__(self, inbox: Inbox, watch: BoardWatch, name: str, known: KnownAxis) -> None:
        self._inbox, self._watch, self._name, self._known = inbox, watch, name, known
        self.order = 0
        """The newest commands that were taken."""
        self.at_once = self.at_look = False
        self.position_steps = 0
        """The record's raw position that was told last, or is to be told."""
        self.plus = True
        """Whether the last motion went in the positive direction."""
        self.homed = False
        self.problem = ""
        """Why PROBLEM is set; "" if it is not."""
        self.stopped_elsewhere = False
        """Whether somebody else has stopped the last motion: it must not go on by itself."""
        self._last: Status | None = None
        self._before: tuple[float, int] | None = None

    def tell(self, *, moves: bool) -> None:
        """Tell how the motor is."""
        self.at_once = self.at_look = False
        self._last = self._status(moves=moves)
        self._inbox.tell(self._last, self.order, self._name)

    def tell_news(self, *, moves: bool) -> None:
        """Tell how the motor is if somebody has asked, or it is not as it was told last."""
        asked = self.at_once or self.at_look
        if asked or self._last is None or self._status(moves=moves) != self._last:
            self.tell(moves=moves)

    def _status(self, *, moves: bool) -> Status:
        flags = Msta.MOVING if moves else Msta.DONE
        known = [
            (Msta.DIRECTION, self.plus),
            (Msta.HOMED, self.homed),
            (Msta.PROBLEM, bool(self.problem)),
            (Msta.COMM_ERR, bool(self._watch.failures)),
        ]
        look = self._known.look
        if look is not None:
            switches = self._known.axis.switches
            known += [
                (Msta.PLUS_LS, switches.limit_plus),
                (Msta.MINUS_LS, switches.limit_minus),
                (Msta.HOME, switches.home),
                (Msta.PROBLEM, look.estop),
            ]
        for bit, on in known:
            if on:
                flags |= bit
        return Status(self.position_steps, 0, flags, self._speed(moves=moves))

    def _speed(self, *, moves: bool) -> float:
        """Return the mean speed since the look before."""
        before, look = self._before, self._known.look
        if not moves or look is None:
            self._before = None
            return 0.0
        if before is None or look.time_s > before[0]:
            self._before = (look.time_s, self.position_steps)
        if before is None or look.time_s <= before[0]:
            return 0.0
        return abs(self.position_steps - before[1]) / (look.time_s - before[0])
