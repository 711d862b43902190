# SPDX-License-Identifier: MIT
"""What other threads leave for the bus' thread: commands, a stop, who listens."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pixstep.motor_record.traffic import MotorCommand, Status, Verb

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
