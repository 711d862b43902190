# SPDX-License-Identifier: MIT
"""Homing for a record: the legs of `moves.homing` at the record's speeds, in a thread of its own.

The home switch's edge becomes position 0, on which the motor then stands. The thread shares the
bus with that of the drives, request by request.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from fractions import Fraction

from pixstep.board import run, shared_time
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import InterruptedBusError
from pixstep.errors import PlainError
from pixstep.lines.runs import seek_entries
from pixstep.motor_drive.motions import DrivenMotion
from pixstep.motor_drive.watch import BoardWatch
from pixstep.moves import homing, legs
from pixstep.moves.fast import Acceleration
from pixstep.moves.legs import HomingPlan, HomingRequest
from pixstep.moves.trapezoid import MoveKinematics, ramp_counts


class Home(DrivenMotion):
    """A homing under way. `over` is True when its thread has ended; `text` says why it failed."""

    def __init__(self, direction: int) -> None:
        super().__init__(direction)
        self.over = False
        self.homed = False
        self.text = ""
        self._link: Link | None = None
        self._time: shared_time.SharedTime | None = None
        self._thread: threading.Thread | None = None

    def start(self, watch: BoardWatch, plan: HomingPlan, ended: Callable[[], None]) -> None:
        """Begin: from here on the legs are made. `ended` is called by the thread at its end."""
        # The longest that the first leg can last: what is waited for if the board is not heard.
        self.queued_s = plan.search_steps / (plan.slow * watch.pixel_hz)
        self._link = watch.link
        self._time = time = shared_time.of_link(watch.link)

        def body() -> None:
            try:
                time.enter()
                with watch.link.modbus.turns.favoured():
                    self._make(watch, plan, time)
            finally:
                self.over = True
                ended()
                time.leave()

        self._thread = threading.Thread(target=body, name="pixstep homing", daemon=True)
        self._thread.start()

    def interrupt(self) -> None:
        """Let the thread ask the board nothing more, and end."""
        if self._link and self._time and self._thread and not self.over:
            self._link.modbus.turns.interrupt(self._thread.ident or 0)
            self._time.wake()

    def forget(self) -> None:
        """Take an interruption back that has not come: the thread has ended by itself."""
        if self._link and self._thread:
            self._link.modbus.turns.forget(self._thread.ident or 0)

    def _make(self, watch: BoardWatch, plan: HomingPlan, time: shared_time.SharedTime) -> None:
        board = watch.link.board(watch.unit)
        try:
            run.command(board, "enable", [plan.axis])
            homing.home(board, plan, Fraction(watch.pixel_hz), time)
            self.homed = True
        except InterruptedBusError:
            self.text = ""
        except PlainError as error:
            self.text = str(error)


def plan_of(
    watch: BoardWatch,
    axis: int,
    direction: int,
    wanted: MoveKinematics,
    search_steps: int,
    room: int,
) -> HomingPlan:
    """Return the legs at kinematics; raises BoardError for a board that cannot home.

    A seek must fit the queue, `room` entries. A ramp that is too long for that ends at a lower
    speed, and the approach is slower than asked.
    """
    watch.board.require("homing")
    counts = ramp_counts(wanted, watch.pixel_hz)
    while True:
        profile = Acceleration(tuple(counts), len(counts), "the record's speeds")
        try:
            request = HomingRequest(axis, direction, search_steps=search_steps)
            plan = legs.plan(profile, request, Fraction(watch.pixel_hz))
            if len(seek_entries(plan.approach())) > room and len(counts) > 1:
                counts.pop()
                continue
            if watch.limits is not None:
                legs.refuse(plan, watch.limits)
        except PlainError as error:
            raise BoardError(str(error)) from None
        return plan
