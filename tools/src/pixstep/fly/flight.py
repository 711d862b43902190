# SPDX-License-Identifier: MIT
"""One flight: lines armed, begun by the pixel clock, watched to their end, in a thread of its own.

bluesky asks for a flight from its event loop, which must not wait; a simulated board's time passes
only while someone waits. So a thread does all that takes time, and ends two statuses: `armed`, and
`over`.

When the edges of the pixel clock came, by the host's clock.

A board knows when an edge came by its own timer. A broadcast `mark`, which the board notes by a
coarse clock of its own, ties that timer to the host's time before the flight, while nothing else is
on the bus. During the flight the newest edge is looked at again and again, which says when it came;
edges between two looks are taken to be evenly spaced. Two errors are left. All times of a flight
are off by what the mark's frame took on its way, some milliseconds with a USB adapter. Each single
time is off by its edge's distance from an even clock.

What bluesky waits for: whether a flight has begun, and whether it is over.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pixstep.api.motion import AxisRecords, Motion
from pixstep.board import clock_marks, settings, snapshot, values
from pixstep.board import registers as regs
from pixstep.board.clock_marks import COUNT, TICKS, UNIT_TICKS
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, MotionStoppedError, MotionTimeoutError
from pixstep.board.link import Link, World
from pixstep.errors import PlainError
from pixstep.fly.documents import Columns, DocumentLayout, FlightRows
from pixstep.fly.tracks import FlightTrack, FlownAxis
from pixstep.lazy import np, npt

_MARK_BITS = 15 * 11  # of the frame that carries it: bytes, each with start, parity and stop


@dataclass(frozen=True)
class _Mark:
    """One instant: when the board heard a mark, by the host's clock and by its own coarse one."""

    heard_s: float
    ticks: int


class ClockTimes:
    """The times of one board's pixel clock. Make it before the lines are sent."""

    def __init__(self, device: Device, world: World) -> None:
        self._device, self._world = device, world
        self._tick_hz = device.tick_hz()
        self._mark = self._marked()
        self._begun_s = world.now_s()
        self._hz, self._edges_px, self._follows = 1.0, 1, True
        self._edges: list[int] = []  # since line zero, at each look
        self._seconds: list[float] = []  # when they came

    def armed(self) -> None:
        """Take what the lines have set; those that wait for no clock begin now."""
        self._begun_s = self._world.now_s()
        known = settings.read(self._device)
        self._hz = float(values.hz_of(known))
        self._edges_px = settings.divider_of(known)
        self._follows = known.get("sync") != regs.SYNCS["free"]

    def look(self) -> None:
        """Note the newest edge, while a line runs or after it."""
        if not self._follows:
            return
        found = self._device.inputs_from("mark_units", "clock_edge_ticks")
        edges = (found["clock_edge"] - found["zero_edge"]) % COUNT
        if self._edges:
            edges = self._edges[-1] + (edges - self._edges[-1]) % COUNT
            if edges == self._edges[-1]:  # the clock rests
                return
        ticks = UNIT_TICKS * found["started_units"] + found["clock_edge_ticks"]
        self._edges.append(edges)
        self._seconds.append(self._instant_s(ticks))

    def of_pixels(self, pixels: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        """Return when the edges that end pixels came, in the world's seconds; 0 is line zero."""
        edges = pixels * self._edges_px
        if not self._edges:
            return self._begun_s + edges / self._hz
        known, seconds = self._within(int(edges.max(initial=0)))
        if len(known) == 1:
            return seconds[0] + (edges - known[0]) / self._hz
        first = (seconds[1] - seconds[0]) / (known[1] - known[0])
        last = (seconds[-1] - seconds[-2]) / (known[-1] - known[-2])
        found = np.interp(edges, known, seconds)
        found = np.where(edges < known[0], seconds[0] + (edges - known[0]) * first, found)
        return np.where(edges > known[-1], seconds[-1] + (edges - known[-1]) * last, found)

    def _within(self, last: int) -> tuple[Sequence[int], Sequence[float]]:
        """Return the looks during a line: after its end a gated clock rests, and goes on later."""
        count = max(1, sum(edge <= last for edge in self._edges))
        return self._edges[:count], self._seconds[:count]

    def _marked(self) -> _Mark | None:
        """Make a mark; None of a board that knows none."""
        device = self._device
        if not device.has("tokens"):
            return None
        baud = 100 * device.setting("baud_100")
        heard_s = clock_marks.broadcast(device, self._world) + _MARK_BITS / baud
        return _Mark(heard_s, UNIT_TICKS * device.input("mark_units"))

    def _instant_s(self, ticks: int) -> float:
        """Return an instant by the board's coarse clock as one by the host's.

        The board's clock wraps after minutes: of the instants that `ticks` can mean, take the one
        nearest to now.
        """
        now_s = self._world.now_s()
        if self._mark is None:
            return now_s
        since_s = ((ticks - self._mark.ticks) % TICKS) / self._tick_hz
        wrap_s = TICKS / self._tick_hz
        return (
            self._mark.heard_s
            + since_s
            + wrap_s * round((now_s - self._mark.heard_s - since_s) / wrap_s)
        )


class FlightStatus:
    """A Status of bluesky's protocol. Its text has the words of what has failed."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._over = threading.Event()
        self._lock = threading.Lock()
        self._callbacks: list[Callable[[FlightStatus], None]] = []
        self._error: BaseException | None = None

    @property
    def done(self) -> bool:
        """True once it is over, well or not."""
        return self._over.is_set()

    @property
    def success(self) -> bool:
        """True once it is over and well."""
        return self.done and self._error is None

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Return what has failed, None if nothing has; wait for so many seconds before.

        Raises TimeoutError if it is not over by then.
        """
        self.wait(timeout)
        return self._error

    def wait(self, timeout: float | None = None) -> None:
        """Wait until it is over. Raises TimeoutError if it is not after so many seconds."""
        if not self._over.wait(timeout):
            raise TimeoutError(f"{self._what}: not over yet")

    def add_callback(self, callback: Callable[[FlightStatus], None]) -> None:
        """Let a function be called with this status when it is over; at once if it is."""
        with self._lock:
            if not self.done:
                self._callbacks.append(callback)
                return
        callback(self)

    def finish(self, error: BaseException | None = None) -> None:
        """End it, by an error or without; what is over stays as it is."""
        with self._lock:
            if self.done:
                return
            self._error = error
            self._over.set()
            called, self._callbacks = self._callbacks, []
        for callback in called:
            callback(self)

    def __repr__(self) -> str:
        if not self.done:
            return f"<{self._what}: not over yet>"
        return f"{self._what}: {self._error}" if self._error else f"<{self._what}: done>"


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
