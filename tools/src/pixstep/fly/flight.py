# SPDX-License-Identifier: MIT
"""One flight: lines armed, begun by the pixel clock, watched to their end, in a thread of its own.

bluesky asks for a flight from its event loop, which must not wait; a simulated board's time passes
only while someone waits. So a thread does all that takes time, and ends two statuses: `armed`, and
`over`.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from pixstep.api.motion import AxisRecords, Motion
from pixstep.board import snapshot
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, MotionStoppedError, MotionTimeoutError
from pixstep.board.link import Link
from pixstep.errors import PlainError
from pixstep.fly.clock_times import ClockTimes
from pixstep.fly.documents import Columns, DocumentLayout, FlightRows
from pixstep.fly.places import FlownAxis
from pixstep.fly.status import FlightStatus
from pixstep.fly.tracks import FlightTrack
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
else:
    np, npt = lazy("numpy"), lazy("numpy.typing")

_LOOK_S = 0.25  # between two looks at the records and at the clock
_ENDS_S = 10.0  # within this time a flight ends that was stopped
_WAITING = ("loaded", "armed")


class Flight:
    """A flight on its way. `begin` starts lines and returns their Motion."""

    def __init__(
        self,
        layout: DocumentLayout,
        link: Link,
        devices: Sequence[Device],
        begin: Callable[[], Motion[Any]],
        clock_timeout_s: float,
    ) -> None:
        self._layout, self._world, self._devices = layout, link.world, devices
        self._begin, self._clock_timeout_s = begin, clock_timeout_s
        self.armed = FlightStatus(f"{layout.name}: kickoff")
        self.over = FlightStatus(f"{layout.name}: complete")
        self._motion: Motion[Any] | None = None
        self._rows: FlightRows | None = None
        self._seen: tuple[AxisRecords, ...] = ()
        self._clock: ClockTimes | None = None
        self._epoch_s = 0.0  # of the world's second 0
        self._lock = threading.Lock()  # of rows and clock, which both sides use
        self._awaited_s: float | None = None  # since when the end is waited for
        self._stopping = threading.Lock()  # held until a stop has read the last records
        self._reason = ""  # why it was stopped
        self._ended = False  # all lines came to their end
        self._well = False  # it was stopped, and that is no failure
        self._thread = threading.Thread(
            target=self._fly, name=f"pixstep flight {layout.name}", daemon=True
        )
        self._thread.start()

    def await_end(self) -> FlightStatus:
        """Note that the end is waited for: the clock has to come from now on."""
        if self._awaited_s is None:
            self._awaited_s = self._world.now_s()
        return self.over

    @property
    def awaited(self) -> bool:
        """True once the end is waited for."""
        return self._awaited_s is not None

    @property
    def pixel(self) -> int:
        """The newest pixel that any axis has a record of; 0 before the first."""
        return max((int(one.pixel[-1]) for one in self._seen if len(one)), default=0)

    def stop(self, reason: str, *, well: bool = False) -> None:
        """Stop the axes unless they are at their end, and wait until the flight is over.

        `well`: the flight does not fail by that.
        """
        if self.over.done:
            return
        with self._stopping:
            self._reason, self._well = self._reason or reason, self._well or well
            if self._motion is not None:
                with contextlib.suppress(PlainError):  # the motion's own end says more
                    self._motion.stop()
        if threading.current_thread() is not self._thread:
            with contextlib.suppress(TimeoutError):
                self.over.wait(_ENDS_S)

    def columns(self) -> tuple[Columns, npt.NDArray[np.float64]] | None:
        """Return the columns of new rows and their times, s since the epoch; None of none."""
        with self._lock:
            if self._rows is None or self._clock is None or self._motion is None:
                return None
            found = self._rows.take(self._seen, over=self.over.done, ended=self._ended)
            if found is None:
                return None
            pixels = found[self._layout.key("pixel")]
            instants = self._clock.of_pixels(np.concatenate([[0], pixels]))
            found[self._layout.key("time")] = instants[1:] - instants[0]
            return found, instants[1:] + self._epoch_s

    def _fly(self) -> None:
        """Fly: this is the thread."""
        error: BaseException | None = None
        try:
            self._arm()
            self.armed.finish()
            self._follow()
        except BaseException as failure:  # whoever waits gets it, of whatever kind
            error = self._explained(failure)
        self.armed.finish(error)
        self.over.finish(error)

    def _arm(self) -> None:
        """Start the lines; return when the axes are armed."""
        places = self._layout.places
        tracks = [FlightTrack(place, place.origin(self._position(place))) for place in places]
        clock = ClockTimes(self._devices[0], self._world)
        with self._stopping:
            if self._reason:
                raise MotionStoppedError("nothing has moved")
            self._motion = self._begin()
        clock.armed()
        with self._lock:
            self._epoch_s = time.time() - self._world.now_s()
            self._clock = clock
            self._rows = FlightRows(self._layout, tracks, self._devices[0].tick_hz())

    def _position(self, place: FlownAxis) -> int:
        """Return where the motor of a place is, steps."""
        device = next(one for one in self._devices if one.unit == place.unit)
        return device.axis(place.axis)["position_steps"]

    def _follow(self) -> None:
        """Watch the motion to its end; raises what has ended it before."""
        motion = self._motion
        assert motion is not None
        try:
            while not self._waited(motion):
                self._look(motion)
        finally:
            with self._stopping:
                self._look(motion)
        self._ended = True

    def _waited(self, motion: Motion[Any]) -> bool:
        """Wait a little; return True at the end. Raises what has ended it before."""
        try:
            motion.wait(_LOOK_S)
        except MotionTimeoutError:
            return False
        return True

    def _look(self, motion: Motion[Any]) -> None:
        """Take what the motion has recorded, and look at the clock."""
        if not self._has_begun(motion):
            self._require_clock(motion)
            return
        records = motion.records()
        with self._lock:
            self._seen = records
            if self._clock is not None:
                with contextlib.suppress(PlainError):  # times are then by fewer looks
                    self._clock.look()

    def _has_begun(self, motion: Motion[Any]) -> bool:
        return any(one.pixel or one.state not in _WAITING for one in motion.status())

    def _require_clock(self, motion: Motion[Any]) -> None:
        """Stop the axes if the clock does not come in time."""
        since_s = self._awaited_s
        if motion.done or since_s is None:
            return
        if self._world.now_s() - since_s > self._clock_timeout_s:
            said = snapshot.clock_beside(self._devices[0], self._world)
            motion.stop()
            raise BoardError(
                f"no pixel clock in {self._clock_timeout_s:g} s, nothing has moved: {said}"
            )

    def _explained(self, error: BaseException) -> BaseException | None:
        """Return an error that says why the flight was stopped, if it was; None if it is none."""
        if self._reason and isinstance(error, MotionStoppedError):
            if self._well:
                return None
            return MotionStoppedError(f"{self._reason}: {error}")
        return error
