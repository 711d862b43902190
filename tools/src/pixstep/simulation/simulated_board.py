# SPDX-License-Identifier: MIT
"""A simulated board from its boot to its last edge, on a link like a serial port's.

with SimulatedBoard("mega", Fraction(30), edges=path) as run:
    run.set_up(run.pixel_hz, [0])
    run.load({0: line})
    in_time = run.make()
    run.settle()
    run.finish()

Its lines are armed, streamed and followed by a `Handle` and `board.run`, as those of a real board.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import cycle, islice
from pathlib import Path
from typing import Any, Self

from pixstep import natives
from pixstep.board import bauds, run, snapshot
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, FaultError, MotionTimeoutError, NotPossibleError
from pixstep.board.handle import Course, Handle
from pixstep.board.link import Link, World
from pixstep.board.modbus import SimClient
from pixstep.board.run import LinesOfBoard, Reader
from pixstep.board.upload import LineUpload, said_divider
from pixstep.errors import UserError
from pixstep.lines.line import Line
from pixstep.lines.runs import queue_entries
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulator import SimOptions, Simulator

SETTLE_PIXELS = 2
_MEASURING_EDGES = 3000  # of a clock however bad, after which a board that can has measured it
_SLOWEST = 1.06  # the longest pixel that a lock to the clock may make, and a little more
_START_PIXELS, _START_S = 10, 0.5  # from arming to the last pixel there is this much to spare
_BURST = 4  # requests of a load between two looks at the time
_MAX_READ = 125  # registers in one read


@dataclass(frozen=True)
class SimWorld:
    """The simulator's time."""

    simulator: Simulator

    def now_s(self) -> float:
        """Return simulated seconds since the start."""
        return self.simulator.cycle / self.simulator.tick_hz

    def wait(self, seconds: float) -> None:
        """Let simulated time pass."""
        self.simulator.wait_s(seconds)


class SimLink:
    """The bus of simulated boards that have booted; use as a context manager."""

    port = "the simulator"

    def __init__(self, options: SimOptions, program: Sequence[str | Path] | None = None) -> None:
        self.simulator = Simulator(options, program)
        try:
            self.simulator.boot()
        except BaseException:
            self.simulator.kill()
            raise
        self.modbus = SimClient(self.simulator)
        self.world = SimWorld(self.simulator)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def board(self, unit: int = 1) -> Device:
        """Return a unit of the bus, the first board's if no other is given."""
        return Device(self.modbus, unit)

    def close(self) -> None:
        """End the simulator if it still runs."""
        self.simulator.kill()


class BoardUnderTest:
    """One board of a link and the lines that it makes; methods raise BoardError as `Device` does.

    Nothing is asked of it that a run does not need: the same calls give the same cycles.
    """

    def __init__(self, link: Link, unit: int = 1) -> None:
        self.link, self.board = link, link.board(unit)
        self.lines = LinesOfBoard(self.board, [])
        self.lasts_s = 0.0  # from arming to the last pixel, at most
        self._clock_s = self._period_s = 0.0
        self._pixels = 0
        self._divider: int | None = None  # that lines say
        self._late: Handle[Any] | None = None  # of a motion that was not over in time

    @property
    def axes(self) -> list[int]:
        """The axes that were set up."""
        return self.lines.axes

    @property
    def uploads(self) -> dict[int, LineUpload]:
        """The lines on their way, by axis."""
        return {upload.axis: upload for upload in self.lines.uploads}

    def set_up(self, pixel_hz: Fraction, axes: list[int], **settings: int) -> None:
        """Set the pixel clock and some settings by name, enable the axes.

        Setting `divider` goes with the lines, if the board takes it so.
        """
        self.lines.axes = sorted(axes)
        self._clock_s = float(1 / pixel_hz)
        self._period_s = settings.get("divider", 1) * self._clock_s
        self._divider = said_divider(self.board, settings.get("divider"))
        if self._divider is not None:
            del settings["divider"]
        self.board.set_pixel_hz(pixel_hz)
        for name, value in settings.items():
            self.board.write_setting(name, value)
        self.board.command("enable", self.axes)

    def load(self, lines: Mapping[int, Line]) -> None:
        """Queue every line, or as much of it as the queue holds.

        Raises LineRefusedByBoardError if the board refuses one.
        """
        self.lines.uploads = []
        self._pixels = max(line.pixels for line in lines.values())
        for axis, line in sorted(lines.items()):
            upload = LineUpload(self.board, axis, queue_entries(line, self._divider))
            self.lines.uploads.append(upload)
            upload.push()
            state = regs.axis_state(self.board.axis(axis)["axis_state"])
            if state == "refused":
                raise self.board.refusal(axis)
            if state != "loaded":
                raise BoardError(f"axis {axis}: {state} after the upload, not loaded")
        self.lasts_s = (self._pixels + _START_PIXELS) * self._period_s * _SLOWEST + _START_S

    def await_clock(self) -> None:
        """Wait until the board has measured the pixel clock: what a locked line begins with."""
        snapshot.await_measured(self.board, self.link.world, self._clock_s, _MEASURING_EDGES)

    def arm(self) -> None:
        """Arm all loaded axes at once: their lines start on one pixel clock edge.

        Raises LineRefusedByBoardError for lines that are too fast together.
        """
        try:
            run.arm(self.board, sorted(self.uploads))
        except NotPossibleError:
            for axis in sorted(self.uploads):
                refusal = self.board.refusal(axis)
                if refusal.name == "too_fast_together":
                    raise refusal from None
            raise

    def states(self) -> dict[int, str]:
        """Return the state of each axis by name."""
        return run.states(self.board, self.axes)

    def make(
        self, reader: Callable[[], Reader] | None = None,
        world: Callable[[World], World] | None = None, progress: Progress = unseen, *,
        armed: bool = False,
    ) -> bool:  # fmt: skip
        """Arm the loaded lines and follow them to their end, or to a fault; False if it is late.

        `reader` returns what reads their records, once they are armed, and `world` the time they
        are followed in, by that of the thread that follows them. Lines may be `armed` already.
        """

        def make(course: Course) -> None:
            if not armed:
                self.arm()
            course.begun()
            self.lines.recorder = reader() if reader else None
            lived = world(course.world) if world else course.world
            with contextlib.suppress(FaultError):  # whoever wants to know it asks the board
                run.follow([self.lines], lived, self._pixels, course.progress)

        handle = Handle(self.link, [self.lines], make, progress).begin()
        try:
            handle.wait(self.lasts_s)
        except MotionTimeoutError:
            self._late = handle  # its lines go on
            return False
        return True

    def close(self) -> None:
        """End the link, and the thread of a motion that was late."""
        self.link.close()
        if self._late:
            with contextlib.suppress(UserError):
                self._late.halt()


class SimulatedBoard(BoardUnderTest):
    """One board alone in the simulator, booted; use as a context manager.

    `more` are other fields of SimOptions.
    """

    link: SimLink

    def __init__(
        self,
        name: str,
        pixel_hz: Fraction,
        *,
        image: Path | None = None,
        program: Sequence[str | Path] | None = None,
        **more: Any,
    ) -> None:
        self.name, self.pixel_hz = name, pixel_hz
        options = SimOptions([(name, image or natives.image(name))], pixel_hz)
        super().__init__(SimLink(replace(options, **more), program))
        self.simulator, self.client = self.link.simulator, self.link.modbus

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def talk_at(self, baud: int) -> None:
        """Set the board and the simulator's end of the bus to another rate, a multiple of 100.

        Raises UserError for a rate that the board cannot make.
        """
        try:
            self.board.write_setting("baud_100", baud // 100)
        except BoardError as error:
            if error.code is None:
                raise
            raise UserError(bauds.refusal(self.name, baud) or str(error)) from None
        self.simulator.command(f"baud {baud} E")

    def settle(self) -> None:
        """Let late edges show themselves."""
        self.simulator.run(int(SETTLE_PIXELS * self.simulator.tick_hz / self.pixel_hz))

    def finish(self) -> None:
        """End the simulator; all of its files are complete afterwards."""
        self.simulator.quit()


class SerialLoad:
    """Valid requests of many kinds that saturate the bus: the next follows the reply at once.

    Maximum-size reads and writes are among them; the write repeats the last queue block, which
    the board acknowledges and drops. `exceptions` counts exception answers (a setting that may
    not change while moving is one), which are valid traffic too.
    """

    def __init__(self, board: Device, axes: list[int], uploads: dict[int, LineUpload]) -> None:
        self.sent = self.exceptions = 0
        self._board, self._uploads = board, uploads
        self._requests = cycle(self._kinds(axes))

    def until(self, simulator: Simulator, cycle: int) -> None:
        """Send at least one request, at most _BURST, until the simulated time is `cycle`.

        Raises BoardError only if one stays without a reply.
        """
        for request in islice(self._requests, _BURST):
            self.sent += 1
            try:
                request()
            except BoardError as error:
                if error.code is None:
                    raise
                self.exceptions += 1
            if simulator.cycle >= cycle:
                return

    def _kinds(self, axes: list[int]) -> list[Callable[[], object]]:
        """Return one rotation of requests."""
        board = self._board
        records = regs.RECORD_STRIDE * (axes[-1] + 1)
        setup = board.map.holding("dir_setup_us")
        setup_us = board.read_holdings(setup.address, 1)[0]
        kinds: list[Callable[[], object]] = [
            lambda: board.read_inputs(regs.RECORD_BASE, min(records, _MAX_READ)),
            board.inputs,
            board.identify if board.has("diagnosis") else board.who,
            lambda: board.read_holdings(0, 6),
            lambda: board.write_one(setup.address, setup_us),
            lambda: board.write(setup.address, [setup_us]),
        ]
        for axis in axes:
            kinds += [partial(board.axis, axis), partial(board.records, axis)]
            # As a master does that lost the reply.
            kinds.append(partial(LineUpload.repeat_last, self._uploads[axis]))
        return kinds
