# SPDX-License-Identifier: MIT
"""Boards on a bus: checked, loaded, run, stopped."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Self

from pixstep import arguments
from pixstep.api import given, moving, running
from pixstep.api.given import Hz
from pixstep.api.machines import Motor
from pixstep.api.motion import AxisState, Motion, Motions, Recording, states_of
from pixstep.api.motions import CheckResult, MotionLine
from pixstep.api.moving import (
    HomeResult,
    Homing,
    MoveResult,
    ProfileLike,
    SeekResult,
    Which,
)
from pixstep.api.programs import MotionProgram
from pixstep.api.running import Clocking, Lines
from pixstep.api.words import Decode, Direction, Parity, SharedLimit, Switches, Sync, Until
from pixstep.board import capability, recording
from pixstep.board.device import Device
from pixstep.board.handle import Course
from pixstep.board.link import Link
from pixstep.board.port import LAST_UNIT, LEAST_BAUD, MOST_BAUD, TIMEOUTS_S, Port
from pixstep.board.run import LinesOfBoard, command, rests, stop_axes, stopped_on_failure
from pixstep.lazy import lazy
from pixstep.moves.legs import SEARCH_STEPS
from pixstep.progress import Progress, unseen
from pixstep.server import remote

if TYPE_CHECKING:
    from pixstep.machine import files
    from pixstep.programs import streaming
else:  # numpy and pydantic take a while to load
    files, streaming = lazy("pixstep.machine.files"), lazy("pixstep.programs.streaming")


class Board:
    """A board on the bus: `bus.board(1)`."""

    def __init__(self, link: Link, unit: int, motions: Motions | None = None) -> None:
        self._link = link
        self._motions = motions or Motions()
        self.unit: int = unit
        """Its Modbus address."""
        self.device: Device = link.board(unit)
        """Registers, commands and settings one by one, below this interface."""

    @property
    def link(self) -> Link:
        """The open bus, below this interface. Operations take the board itself: `link=board`."""
        return self._link

    @property
    def kind(self) -> str:
        """What board it says it is: `"uno"`, `"mega"` or `"m1284"`."""
        return self.device.who().board

    @property
    def pixel_hz(self) -> Fraction:
        """The frequency of pixels in Hz that it is set to."""
        return capability.connected_limits(self.device).pixel_hz

    def axes(self) -> tuple[AxisState, ...]:
        """Return the state and the position of every axis."""
        return states_of(self.device, range(self.device.input("axis_count")))

    def check(
        self,
        line: MotionLine,
        *,
        axes: int = 1,
        sync: Sync | None = None,
        divider: int | None = None,
        guaranteed: bool = True,
    ) -> CheckResult:
        """Check a line by the limits that the board has now; nothing is sent.

        `axes` is the number of axes that move together, its own included: each of them by a line
        like this one; `sync` and `divider` are those that `run` is to set. `guaranteed=False`
        leaves out whether the board has the time for the line (`beyond_guarantee`).
        """
        arguments.instance("line", line, MotionLine, "a MotionLine")
        wanted = Clocking(sync, divider)
        guaranteed = arguments.flag("guaranteed", guaranteed)
        return running.check(self.device, line, axes, wanted, guaranteed=guaranteed)

    def start(
        self,
        lines: Lines,
        axis: int | None = None,
        *,
        sync: Sync | None = None,
        divider: int | None = None,
        gate_edges: int | None = None,
        check: bool = True,
        beyond: bool = False,
        progress: Progress = unseen,
    ) -> Motion[tuple[AxisState, ...]]:
        """Start lines and return the Motion, which watches, stops and awaits them.

        `lines` is one line for `axis` (by default that of its motor), several lines for the axes of
        their motors, or lines by axis; they start on one pixel clock edge. A line of a motor goes
        to that motor's axis or is refused. Each is checked first; then the board's pixel frequency
        is set to that of the lines, and a line longer than the queue is streamed. `sync` (`"free"`,
        `"start"`, `"lock"`), `divider`, the clock edges of a pixel, and `gate_edges`, those from a
        burst's first one to line zero, are set as well if they are given or a machine file has
        them; otherwise the board's stay. To lock the board must have measured its clock: that is
        waited for. When `start` returns the axes are armed. `progress` is called by the motion's
        thread, with the share done.
        Raises RefusedError for a line that the board or its motor's limits refuse (nothing is sent
        then), unless `check` is False, and for lines that the board may not have the time for,
        unless `beyond` is True; UserError
        for a divider that is not that of the lines' machine, BoardError for a clock that
        cannot be measured and a board that does not answer. A fault later on is raised by `wait`.
        """
        arguments.function("progress", progress)
        clock = Clocking(sync, divider, gate_edges)
        prepared = running.prepare(self.device, lines, axis, clock, checked=check, beyond=beyond)
        prepared.set_clock()
        return self._motions.begin(
            self._link, [prepared.lines], partial(running.make, prepared), progress,
            prepared.pixels, [prepared.records],
        )  # fmt: skip

    def run(
        self,
        lines: Lines,
        axis: int | None = None,
        *,
        sync: Sync | None = None,
        divider: int | None = None,
        gate_edges: int | None = None,
        check: bool = True,
        beyond: bool = False,
        progress: Progress = unseen,
    ) -> tuple[AxisState, ...]:
        """Run lines to their end and return the axes that moved: `start(...).wait()`.

        The states that come back have the per-pixel records, of every Nth pixel where
        the bus is too slow for all. Ctrl-C and any error of the program stop the axes. `progress`
        is called with the share done, 0 to 1. Raises what `start` and `Motion.wait` raise.
        """
        return self.start(
            lines, axis, sync=sync, divider=divider, gate_edges=gate_edges, check=check,
            beyond=beyond, progress=progress,
        ).wait()  # fmt: skip

    def start_program(
        self, program: MotionProgram, *, check: bool = True, progress: Progress = unseen
    ) -> Motion[tuple[AxisState, ...]]:
        """Start a motion program, which is planned while it runs, and return the Motion.

        Memory does not grow with its length. The board's pixel clock, divider and sync become those
        of the machine file. With `check` the program is planned once beforehand,
        so that a mistake in it is found while nothing moves. Raises UserError for a mistake,
        RefusedError for what the board would refuse.
        """
        arguments.instance("program", program, MotionProgram, "a MotionProgram")
        arguments.function("progress", progress)
        check, request = arguments.flag("check", check), program.request
        streaming.require_fitting(
            files.MachineFile.load(program.machine.path), request.setup, self.kind
        )
        known = streaming.rehearse(self.device, request) if check else None
        axes = [motor.axis for motor in request.setup.motors]
        group: list[LinesOfBoard] = []
        records = Recording(self.unit, axes)
        pixels = {(self.unit, axis): known.pixels for axis in axes} if known else {}

        def make(course: Course) -> tuple[AxisState, ...]:
            with (
                streaming.prepared(self.device, request, known) as run,
                recording.recorded(run.lines, records.take) as records.recorder,
                stopped_on_failure([run.lines]),
            ):
                group.append(run.lines)
                run.run(course.world, course.progress, course.begun)
            return running.with_records(self.device, axes, records)

        return self._motions.begin(self._link, group, make, progress, pixels, [records])

    def run_program(
        self, program: MotionProgram, *, check: bool = True, progress: Progress = unseen
    ) -> tuple[AxisState, ...]:
        """Run a motion program to its end: `start_program(...).wait()`.

        Ctrl-C and any error of the program stop the axes.
        """
        return self.start_program(program, check=check, progress=progress).wait()

    def move(
        self,
        steps: int | str,
        *,
        profile: ProfileLike | None = None,
        motor: Motor | None = None,
        axis: int | None = None,
        max_speed: int | str | None = None,
        number: int | None = None,
        pixel_hz: Hz | None = None,
        divider: int | None = None,
        progress: Progress = unseen,
    ) -> Motion[MoveResult]:
        """Start a move of exactly so many steps, signed, and return the Motion.

        `steps` may be a text with a unit, `"-3mm"`, of a motor with steps_per_unit; with a motor it
        is in the load's direction. `profile` is a CSV or CSB file (line `number` of several), a
        Profile, or the steps of each pixel of an acceleration from rest; by default that of the
        motor for moves. `max_speed` is in steps/pixel or as `"12mm/s"`. No pixel clock is needed.
        `pixel_hz` and `divider` set the board's; by default they are the motor's machine's, else
        the board's. Raises RefusedError for what the board would refuse.
        """
        which = Which(axis, motor, pixel_hz, divider)
        ready = moving.ready_move(self.device, steps, profile, which, max_speed, number)
        place = ready.lines.axes[0]

        def make(course: Course) -> MoveResult:
            with stopped_on_failure([ready.lines]):
                made = ready.make(course.world, course.progress, course.begun)
            return moving.moved(self.device, place, made)

        pixels = {(self.unit, place): ready.move.pixels}
        return self._motions.begin(self._link, [ready.lines], make, progress, pixels)

    def home(
        self,
        *,
        profile: ProfileLike | None = None,
        motor: Motor | None = None,
        axis: int | None = None,
        direction: Direction = "plus",
        decode: Decode | None = None,
        haps: int | None = None,
        slow: int | str | None = None,
        search: int | str = SEARCH_STEPS,
        clear: int | str | None = None,
        inverted: Switches | None = None,
        filter_us: int | None = None,
        home_is_limit: SharedLimit | None = None,
        number: int | None = None,
        pixel_hz: Hz | None = None,
        divider: int | None = None,
        progress: Progress = unseen,
    ) -> Motion[HomeResult]:
        """Start to home an axis by its switch, whose edge becomes position 0; return the Motion.

        Off the switch, in `direction` until it closes, back, slowly again; then the axis stands
        on 0. `haps` are the entries of the profile that may be used, by default as its header says,
        of a program's own profile all; `slow` the speed of the second approach, `search` after how
        many steps a leg gives up, `clear` from how far away the second approach begins at least.
        `inverted` (`"none"`, `"home"`, `"limits"`, `"both"`), `filter_us` and `home_is_limit`
        (`"none"`, `"minus"`, `"plus"`) are set on the board if they are given. The rest is as
        `move` has it. `wait` raises HomingError if the switch is not found; the fault stays until
        `clear_fault`.
        """
        which = Which(axis, motor, pixel_hz, divider)
        wanted = Homing(direction, decode, haps, slow, search, clear, number)
        told = moving.inputs(inverted, filter_us, home_is_limit)
        ready = moving.ready_homing(self.device, profile, which, wanted, told)

        def make(course: Course) -> HomeResult:
            course.begun()
            with stopped_on_failure([ready.lines]):
                found = ready.make(course.world, course.progress)
            return moving.homed(self.device, found)

        return self._motions.begin(self._link, [ready.lines], make, progress)

    def seek(
        self,
        *,
        profile: ProfileLike | None = None,
        motor: Motor | None = None,
        axis: int | None = None,
        direction: Direction = "plus",
        until: Until = "closed",
        decode: Decode | None = None,
        haps: int | None = None,
        search: int | str = SEARCH_STEPS,
        number: int | None = None,
        pixel_hz: Hz | None = None,
        divider: int | None = None,
        progress: Progress = unseen,
    ) -> Motion[SeekResult]:
        """Start to move an axis until its home switch is `"closed"` or `"open"`; return the Motion.

        The axis slows down after the edge, whose position the hardware captures; nothing is zeroed.
        All else is as `home` has it.
        """
        opens = arguments.one_of("until", until, ("closed", "open")) == "open"
        which = Which(axis, motor, pixel_hz, divider)
        wanted = Homing(direction, decode, haps, None, search, None, number)
        told = moving.inputs(None, None, None)
        ready = moving.ready_homing(self.device, profile, which, wanted, told)

        def make(course: Course) -> SeekResult:
            course.begun()
            with stopped_on_failure([ready.lines]):
                leg = ready.seek(course.world, course.progress, opens=opens)
            return moving.sought(self.device, ready.plan.axis, leg)

        return self._motions.begin(self._link, [ready.lines], make, progress)

    def clear_fault(self) -> None:
        """Clear the board's fault. Raises BoardError while what has caused it lasts."""
        command(self.device, "clear_fault", [*range(self.device.input("axis_count"))])

    def stop(self) -> tuple[AxisState, ...]:
        """Stop all axes, and the motions that move them; return where they are."""
        self._motions.stop(self.unit)
        axes = [*range(self.device.input("axis_count"))]
        stop_axes(self.device, axes)
        rests(self.device, axes, self._link.world)
        return states_of(self.device, axes)


class Bus:
    """A bus with boards, a context manager: `with connect("/dev/ttyACM0") as bus:`.

    The end of the block waits for the motions that are still on their way; an exception that leaves
    it stops them.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self._motions = Motions()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self._motions.wait()
        finally:
            self.close()

    @property
    def link(self) -> Link:
        """The open bus, below this interface. Operations take the bus itself: `link=bus`."""
        return self._link

    @property
    def port(self) -> str:
        """The name of the port."""
        return self._link.port

    def board(self, unit: int = 1) -> Board:
        """Return the board with a Modbus address; nothing is asked of it yet."""
        return Board(self._link, arguments.whole("unit", unit, 1, LAST_UNIT), self._motions)

    def start(
        self,
        lines: Mapping[int, Lines],
        *,
        sync: Sync | None = None,
        divider: int | None = None,
        gate_edges: int | None = None,
        check: bool = True,
        beyond: bool = False,
        progress: Progress = unseen,
    ) -> Motion[dict[int, tuple[AxisState, ...]]]:
        """Start lines of several boards on one edge of their common clock; return the Motion.

        `lines` are those of each board by its address: `bus.start({1: [x, y], 2: z})`; the rest is
        as `Board.start` has it. When `start` returns all are armed; while the clock rests they wait
        for it. If one of them cannot begin on the edge that all agree on, all are stopped. At the
        end the boards' counts of clock edges are compared. `wait` returns the states by address.
        """
        arguments.function("progress", progress)
        clock = Clocking(sync, divider, gate_edges)
        several = running.prepare_several(
            lines, lambda unit: self.board(unit).device, clock, checked=check, beyond=beyond
        )
        for one in several:
            one.set_clock()
        pixels = {place: count for one in several for place, count in one.pixels.items()}
        return self._motions.begin(
            self._link, [one.lines for one in several], partial(running.make_together, several),
            progress, pixels, [one.records for one in several],
        )  # fmt: skip

    def close(self) -> None:
        """Stop what still moves by a Motion, and give the port back."""
        self._motions.stop()
        self._link.close()


def connect(
    port: str,
    *,
    baud: int = 115_200,
    parity: Parity | None = None,
    timeout_s: float | None = None,
) -> Bus:
    """Open the port of a bus with boards; use it in a `with` statement.

    `parity` is `"E"`, `"O"` or `"N"`: even by default, none on a pseudo terminal. Opening the port
    resets a board that is plugged in by USB: its boot loader is given its time. Raises UserError
    saying why a port cannot be opened.
    """
    letter = given.maybe(arguments.one_of, "parity", parity, ("E", "O", "N"))
    timeout_s = given.maybe(arguments.finite, "timeout_s", timeout_s, *TIMEOUTS_S)
    name = str(arguments.path("port", port))
    rate = arguments.whole("baud", baud, LEAST_BAUD, MOST_BAUD)
    return Bus(remote.open_bus(Port(name, rate, letter, timeout_s)))
