# SPDX-License-Identifier: MIT
"""A motion on its way while its caller does something else: watched, stopped, awaited.

Who fills the board's queue meanwhile? A thread of the motion's own. A `poll` for the caller would
be simpler, but an Uno's queue of a line with a count of its own in each pixel lasts 0.2 s at 2 kHz,
and a program that draws or saves does not come back in time. The thread and the caller share the
bus (`port.Turns`): each has it for one request, so that a caller who asks a board costs the
stream the time of that request alone. `status` and `records` ask nothing at all: they show what the
thread has read. A stop is made by the thread, which sends nothing of the line afterwards.

Of boards whose time passes only while someone waits for it, as a simulated one's, the thread runs
only while the caller waits or asks, never both (shared_time.py).
"""

import atexit
import contextlib
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Self, TypeVar

from pixstep import signals
from pixstep.board import run, shared_time
from pixstep.board.errors import BoardError, MotionStoppedError, MotionTimeoutError
from pixstep.board.link import Link, World
from pixstep.board.port import InterruptedBusError
from pixstep.board.run import LinesOfBoard
from pixstep.progress import Progress, unseen

Result = TypeVar("Result")
_REACTS_S = 0.1  # within this time a thread ends that was interrupted, unless it waits elsewhere
_ENDS_S = 5.0


@dataclass(frozen=True)
class Course:
    """What a motion is made with."""

    world: World
    """The boards' time."""
    progress: Progress
    """Takes the share done."""
    begun: Callable[[], None]
    """To be called when the lines are armed: until then `start` waits."""


class Handle(Generic[Result]):
    """A motion on its way; `make` makes it, in a thread of its own, and returns its result.

    `share` is how much of it is done, 0 to 1.
    """

    def __init__(
        self,
        link: Link,
        group: list[LinesOfBoard],
        make: Callable[[Course], Result],
        progress: Progress = unseen,
    ) -> None:
        self._group, self._make, self._shows = group, make, progress
        self._turns, self._time = link.modbus.turns, shared_time.of_link(link)
        self._begun, self._over = threading.Event(), threading.Event()
        self.share = 0.0
        self._stopped = self._armed = self._noticed = False
        self._made: list[Result] = []
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="pixstep motion", daemon=True)

    def begin(self) -> Self:
        """Start, and wait until the lines are armed; raises what keeps them from that."""
        atexit.register(self._at_exit, os.getpid())
        self._thread.start()
        try:
            self._time.pass_until(self._begun, None)
        except BaseException as error:
            self._halted(error)
            raise
        if not self._armed and self._error:
            self._outcome()
        return self

    @property
    def done(self) -> bool:
        """True once nothing moves any more; a boards' time that waits for that goes on a little."""
        self.advance()
        return self.over

    @property
    def over(self) -> bool:
        """True once nothing moves any more: at the end, or after a fault or a stop."""
        return self._over.is_set()

    @property
    def failed_unnoticed(self) -> bool:
        """True if it was ended by what nobody has been told of yet."""
        return self.over and bool(self._error) and not (self._noticed or self._stopped)

    def advance(self) -> None:
        """Let the thread look at its boards once, if their time waits for the caller."""
        if not self.over:
            self._time.advance()

    def wait(self, timeout_s: float | None = None) -> Result:
        """Wait for the end and return the result.

        Ctrl-C stops the axes. Raises MotionTimeoutError if it takes longer; the motion goes on
        then. Raises MotionStoppedError if it was stopped, and what went wrong.
        """
        try:
            in_time = self._time.pass_until(self._over, timeout_s)
        except BaseException as error:
            self._halted(error)
            raise
        return self._outcome_in_time(in_time, timeout_s)

    async def wait_async(self, timeout_s: float | None = None) -> Result:
        """Do the same while other tasks go on; to cancel it stops the axes."""
        try:
            in_time = await self._time.pass_until_async(self._over, timeout_s)
        except BaseException as error:
            self._halted(error)
            raise
        return self._outcome_in_time(in_time, timeout_s)

    def halt(self) -> None:
        """Stop all axes unless the motion is over, and wait until its thread has ended."""
        if self._over.is_set():
            return
        thread = self._thread.ident or 0
        with signals.ignored():
            self._stopped = True
            self._turns.interrupt(thread)
            self._time.wake()
            if not self._time.pass_until(self._over, _REACTS_S):
                self._stop_here()
                self._time.pass_until(self._over, _ENDS_S)
            self._turns.forget(thread)

    def leave(self, error: BaseException | None) -> None:
        """Wait for the end; after an error of the caller's stop all axes instead."""
        if error is not None:
            self._halted(error)
        elif not self._stopped:
            self.wait()

    async def leave_async(self, error: BaseException | None) -> None:
        """Do the same while other tasks go on."""
        if error is not None:
            self._halted(error)
        elif not self._stopped:
            await self.wait_async()

    def _at_exit(self, process: int) -> None:
        """Stop all axes at the end of the program, not of a process that it has forked."""
        if os.getpid() == process:
            self.halt()

    def _run(self) -> None:
        """Make the motion: this is the thread."""
        try:
            self._time.enter()
            with self._turns.favoured():
                self._made.append(self._make(Course(self._time, self._show, self._arm)))
        except BaseException as error:  # the caller gets it, of whatever kind
            self._error = error
        finally:
            atexit.unregister(self._at_exit)
            self._begun.set()  # or it never will
            self._over.set()
            self._time.leave()  # the caller goes on now, and finds that all is over

    def _arm(self) -> None:
        for lines in self._group:
            run.look(lines)
        self._armed = True
        self._begun.set()

    def _show(self, share: float) -> None:
        self.share = share
        self._shows(share)

    def _outcome_in_time(self, in_time: bool, timeout_s: float | None) -> Result:
        if not in_time:
            raise MotionTimeoutError(f"the motion takes longer than {timeout_s:g} s")
        return self._outcome()

    def _outcome(self) -> Result:
        """Return the result. Raises what has ended the motion before its end."""
        error = self._error
        if error is None:
            return self._made[0]
        self._noticed = True
        stopped = self._stopped and isinstance(error, BoardError)
        if stopped or isinstance(error, InterruptedBusError):
            raise MotionStoppedError(f"the motion was stopped: {self._told()}") from None
        raise error

    def _told(self) -> str:
        """Return where the axes are, as whoever stopped them has said."""
        error = self._error
        return "; ".join(getattr(error, "__notes__", ())) or str(error or "it was over")

    def _halted(self, error: BaseException) -> None:
        """Stop all axes because of an exception, which is told where they are."""
        if not self._over.is_set():
            self.halt()
            error.add_note(self._told())

    def _stop_here(self) -> None:
        """Stop the axes from this thread, because the motion's own waits for something else."""
        for lines in self._group:
            with contextlib.suppress(BoardError):
                run.stop_axes(lines.board, lines.axes)
