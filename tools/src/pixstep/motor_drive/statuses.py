# SPDX-License-Identifier: MIT
"""The statuses of one motor, from looks at its board and what its drive knows."""

from __future__ import annotations

from pixstep.motor_drive.inbox import Inbox
from pixstep.motor_drive.known import KnownAxis
from pixstep.motor_drive.watch import BoardWatch
from pixstep.motor_record.traffic import Msta, Status


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
