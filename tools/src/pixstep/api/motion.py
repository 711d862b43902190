# SPDX-License-Identifier: MIT
"""A motion on its way, of one board or several: what `start`, `move`, `home` and `seek` return."""

from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

from pixstep.api import given
from pixstep.api.records import AxisRecords, Recording
from pixstep.api.states import AxisProgress, AxisState, states_of
from pixstep.board import registers as regs
from pixstep.board.handle import Course, Handle
from pixstep.board.link import Link
from pixstep.board.run import Lines
from pixstep.progress import Progress

Result = TypeVar("Result")


class Motion(Generic[Result]):
    """A motion on its way, which a thread of its own follows and feeds.

    The caller goes on meanwhile, and may ask the board other things: the two share the bus request
    by request, and the thread goes first, so that a line waits for no more than one request of the
    caller's. (What keeps Python's lock for long, as some libraries' computations do, keeps the
    thread waiting too, and so does a processor without a moment to spare: give such work a process
    of its own.) Of a simulated board, whose time passes only while someone asks it, the thread goes
    on in `wait`, and by one look at the board in each `status`, `records` and `done`: a run is the
    same every time.

    In a `with` or `async with` statement the end of the block waits for the end of the motion;
    an exception that leaves the block stops all axes, and so do Ctrl-C in `wait`, the end of the
    program, and `close` of the bus.

    Example:
        >>> from pixstep import line, simulated_board
        >>> with simulated_board("uno", pixel_hz=100) as board:
        ...     with board.start(line([2, 6, 8, 6, 2], pixel_hz=100)) as motion:
        ...         before = motion.status()[0]
        ...     after = motion.wait()[0]
        >>> before.pixels, before.share < 1, after.state, after.position_steps
        (5, True, 'done', 24)
    """

    def __init__(
        self,
        handle: Handle[Result],
        group: Sequence[Lines],
        pixels: Mapping[tuple[int, int], int] | None = None,
        recordings: Sequence[Recording] = (),
    ) -> None:
        self._handle, self._group = handle, group
        self._pixels, self._recordings = pixels or {}, recordings

    @property
    def done(self) -> bool:
        """True once nothing moves any more: at the end, or after a fault or a stop."""
        return self._handle.done

    def status(self) -> tuple[AxisProgress, ...]:
        """Return how far each axis is, as it was last seen, at most some 0.3 s ago.

        Nothing is asked of the board for that, so that it may be called as often as one likes.
        """
        self._handle.advance()
        return tuple(
            self._progress(lines, axis)
            for lines in self._group
            for axis in lines.axes
            if axis in lines.seen
        )

    @property
    def _over(self) -> bool:
        """The same, of a simulated board without letting its time go on."""
        return self._handle.over

    @property
    def _needs_care(self) -> bool:
        """True until it is over and what has ended it, if anything has, was raised."""
        return not self._handle.over or self._handle.failed_unnoticed

    def _halt(self) -> None:
        """Stop all axes, and ask nothing more."""
        self._handle.halt()

    def records(self) -> tuple[AxisRecords, ...]:
        """Return the per-pixel records that have come so far, of each axis that makes any."""
        self._handle.advance()
        return tuple(found for one in self._recordings for found in one.records())

    def stop(self) -> tuple[AxisState, ...]:
        """Stop all axes and return where they are; `records` has all that they have made.

        `wait` raises MotionStoppedError then, unless the motion was over.
        """
        if not self._handle.over:
            self._handle.halt()
            for one in self._recordings:
                one.read_last()
        return tuple(state for lines in self._group for state in states_of(lines.board, lines.axes))

    def wait(self, timeout_s: float | str | None = None) -> Result:
        """Wait for the end and return the result, of `start` the states of the axes that moved.

        `timeout_s` is in the time of the board, in seconds or as `"500 ms"`: MotionTimeoutError is
        raised then, and the motion goes on. Raises MotionStoppedError if it was stopped, and what
        ended it: FaultError for a fault of the board, other BoardErrors.
        """
        return self._handle.wait(given.seconds("timeout_s", timeout_s))

    async def wait_async(self, timeout_s: float | str | None = None) -> Result:
        """Wait in the same way while other tasks go on. To cancel it stops the axes."""
        return await self._handle.wait_async(given.seconds("timeout_s", timeout_s))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._handle.leave(error)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self._handle.leave_async(error)

    def __repr__(self) -> str:
        axes = ", ".join(
            f"board {lines.board.unit} axis {axis}" for lines in self._group for axis in lines.axes
        )
        state = "over" if self._handle.over else f"{self._handle.share:.0%} done"
        return f"<Motion of {axes}: {state}>"

    def _progress(self, lines: Lines, axis: int) -> AxisProgress:
        """Return how far an axis is."""
        found = lines.seen[axis]
        state, pixel = regs.axis_state(found["axis_state"]), found["pixel"]
        pixels = self._pixels.get((lines.board.unit, axis))
        share = self._handle.share if pixels is None else pixel / pixels
        ended = self._handle.over and state in ("done", "loaded")
        return AxisProgress(
            unit=lines.board.unit,
            axis=axis,
            state=state,
            position_steps=found["position_steps"],
            pixel=pixel,
            pixels=pixels,
            share=1.0 if ended else min(1.0, share),
        )


class Motions:
    """The motions of a bus that are on their way."""

    def __init__(self) -> None:
        self._known: list[Motion[Any]] = []

    def begin(
        self,
        link: Link,
        group: list[Lines],
        make: Callable[[Course], Result],
        progress: Progress,
        pixels: Mapping[tuple[int, int], int] | None = None,
        recordings: Sequence[Recording] = (),
    ) -> Motion[Result]:
        """Start a motion; raises what keeps its lines from being armed."""
        handle = Handle(link, group, make, progress)
        motion = Motion(handle, group, pixels, recordings)
        self._known = [one for one in self._known if one._needs_care]
        self._known.append(motion)
        handle.begin()
        return motion

    def wait(self) -> None:
        """Wait for all of them; raises what goes wrong with one, or has gone in silence."""
        for motion in self._known:
            if motion._needs_care:
                motion.wait()

    def stop(self, unit: int | None = None) -> None:
        """Stop all of them, or those that move axes of one board."""
        for motion in self._known:
            if unit is None or any(lines.board.unit == unit for lines in motion._group):
                motion._halt()
