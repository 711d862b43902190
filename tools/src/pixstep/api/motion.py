# SPDX-License-Identifier: MIT
"""A motion on its way, of one board or several, with the axes and records that it is told by."""

from __future__ import annotations

import contextlib
import threading
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

from pixstep import arguments
from pixstep.api import given
from pixstep.api.shown import Facts, Shown, count, frame
from pixstep.board import recording
from pixstep.board import registers as regs
from pixstep.board import run as running
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.handle import Course, Handle
from pixstep.board.link import Link
from pixstep.board.recording import RecordedPixel, Recorder
from pixstep.board.run import LinesOfBoard
from pixstep.board.state import Record
from pixstep.lazy import np, npt
from pixstep.progress import Progress
from pixstep.simulation.small_pickle import SmallPickle


@dataclass(frozen=True, eq=False, repr=False)
class AxisRecords(SmallPickle, Shown):
    """The records of an axis: where the motor should have been and was at each pixel's edge."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis of the board, from 0."""
    every: int
    """Every how many pixels there is a record; 1: of each. Deviations have one besides."""
    missed: int
    """Records that were overwritten on the board before they were read."""
    line: npt.NDArray[np.int32] = field(repr=False)
    """Line of the axis since the board's reset, from 1."""
    pixel: npt.NDArray[np.int32] = field(repr=False)
    """Pixel, from 1."""
    expected_steps: npt.NDArray[np.int32] = field(repr=False)
    """Position at its edge by exact arithmetic, in steps from the beginning of the line."""
    actual_steps: npt.NDArray[np.int32] = field(repr=False)
    """Position by the steps that were made, from there too."""
    edge_error_ticks: npt.NDArray[np.int32] = field(repr=False)
    """Edge of the pixel clock minus the planned edge, in ticks of the board's timer; 0 also where
    no edge came and a locked line went on without: the board's clock_missing counts those."""

    def __len__(self) -> int:
        """Return the number of records."""
        return len(self.pixel)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write a CSV or Parquet file, by its ending; return its path.

        An existing file is replaced.
        """
        target = arguments.path("path", path)
        with recording.writing(target) as rows:
            for line, *values in zip(*(column.tolist() for column in self._columns), strict=True):
                rows.take(self.unit, RecordedPixel(line, self.axis, Record(*values)))
        return target

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table without pandas: a row a record."""
        names = ("line", "pixel", "expected_steps", "actual_steps", "edge_error_ticks")
        return frame(dict(zip(names, self._columns, strict=True)))

    def _headline(self) -> str:
        every = "of each pixel" if self.every == 1 else f"of one pixel in {self.every}"
        missed = f", {self.missed} missed" if self.missed else ""
        return f"board {self.unit} axis {self.axis}: {count(len(self), 'record')} {every}{missed}"

    def _facts(self) -> Facts:
        if len(self):
            yield "last pixel", int(self.pixel[-1])
            yield "last position, steps", int(self.actual_steps[-1])
            off = np.abs(self.expected_steps - self.actual_steps)
            yield "largest position error, steps", int(off.max())
            yield "largest edge error, ticks", int(np.abs(self.edge_error_ticks).max())

    @property
    def _columns(self) -> tuple[npt.NDArray[np.int32], ...]:
        return self.line, self.pixel, self.expected_steps, self.actual_steps, self.edge_error_ticks


class Recording:
    """Takes the records of one board's axes while they run; they may be looked at meanwhile."""

    def __init__(self, unit: int, axes: Sequence[int]) -> None:
        self._unit, self._axes = unit, axes
        self._lock = threading.Lock()
        self._values: dict[int, array[int]] = {axis: array("i") for axis in axes}
        self.recorder: Recorder | None = None
        """What reads them; None of a board that keeps none."""

    def take(self, row: RecordedPixel) -> None:
        """Take a record."""
        found = row.record
        with self._lock:
            self._values[row.axis].extend((
                row.line, found.pixel, found.expected_steps, found.actual_steps,
                found.edge_error_ticks,
            ))  # fmt: skip

    def read_last(self) -> None:
        """Read what lines that were stopped have left on the board, if it still answers."""
        if self.recorder is not None:
            with contextlib.suppress(BoardError):
                self.recorder.look([], ended=True)

    def of(self, axis: int) -> AxisRecords | None:
        """Return the records of an axis so far; None of a board that keeps none."""
        if self.recorder is None:
            return None
        with self._lock:
            values = self._values[axis][:]
        table = np.array(values, dtype=np.int32).reshape(-1, 5)
        return AxisRecords(
            self._unit, axis, self.recorder.every, self.recorder.missed[axis],
            *np.ascontiguousarray(table.T),
        )  # fmt: skip

    def records(self) -> tuple[AxisRecords, ...]:
        """Return the records of all axes so far."""
        found = (self.of(axis) for axis in self._axes)
        return tuple(one for one in found if one is not None)


@dataclass(frozen=True)
class AxisState:
    """An axis of a board at rest or in motion."""

    axis: int
    """Axis, from 0."""
    state: str
    """`"empty"`, `"loaded"`, `"armed"`, `"running"`, `"done"`, `"fault"` and so on."""
    position_steps: int
    """Its position in steps, as the board counts."""
    play_known: bool = True
    """False if its newest line with backlash began without knowing the play, as after a reset."""
    records: AxisRecords | None = field(default=None, repr=False, compare=False)
    """The per-pixel records of the line that a run has made; None of an axis at rest, of a board
    that keeps none, and without numpy."""


@dataclass(frozen=True)
class AxisProgress:
    """An axis of a motion on its way, as the board was last asked of it."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis, from 0."""
    state: str
    """`"loaded"`, `"armed"`, `"running"`, `"done"`, `"fault"` and so on."""
    position_steps: int
    """Its position in steps, as the board counts."""
    pixel: int
    """The pixel of its line that it is in, from 1; 0 before the first."""
    pixels: int | None
    """Pixels of its line; None where that is not known beforehand."""
    share: float
    """How much of its motion is done, 0 to 1."""


def states_of(device: Device, axes: Sequence[int]) -> tuple[AxisState, ...]:
    """Return what a board says of some axes."""
    wanted = list(axes)
    states = running.states(device, wanted)
    places = running.positions(device, wanted)
    unknown = running.play_unknown(device, wanted)
    return tuple(AxisState(axis, states[axis], places[axis], axis not in unknown) for axis in axes)


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
        ...     with board.start(line([2, 6, 8, 8, 8, 8, 6, 2], pixel_hz=100)) as motion:
        ...         before = motion.status()[0]
        ...     after = motion.wait()[0]
        >>> before.pixels, before.share < 1, after.state, after.position_steps
        (8, True, 'done', 48)
    """

    def __init__(
        self,
        handle: Handle[Result],
        group: Sequence[LinesOfBoard],
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
        return self._handle.wait(given.maybe(given.time, "timeout_s", timeout_s))

    async def wait_async(self, timeout_s: float | str | None = None) -> Result:
        """Wait in the same way while other tasks go on. To cancel it stops the axes."""
        return await self._handle.wait_async(given.maybe(given.time, "timeout_s", timeout_s))

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

    def _progress(self, lines: LinesOfBoard, axis: int) -> AxisProgress:
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
        group: list[LinesOfBoard],
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
