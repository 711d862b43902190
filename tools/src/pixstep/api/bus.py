# SPDX-License-Identifier: MIT
"""Boards on a bus: checked, loaded, run, stopped."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Self

from pixstep import arguments
from pixstep.api import given
from pixstep.api.axes import Lines
from pixstep.api.axes import by_axis as axes_of
from pixstep.api.clocking import Clocking
from pixstep.api.motions import CheckResult, MotionLine
from pixstep.api.programs import MotionProgram
from pixstep.api.records import AxisRecords, Collector
from pixstep.board import clockstate, limits, recording, settings, upload
from pixstep.board import run as running
from pixstep.board.device import Board as Device
from pixstep.board.link import Link
from pixstep.board.port import LAST_UNIT, LEAST_BAUD, MOST_BAUD, TIMEOUTS_S, Port
from pixstep.board.recording import Recorder
from pixstep.errors import RefusedError, UserError
from pixstep.lines.rational import refuse_period
from pixstep.machine.reading import Machine as MachineFile
from pixstep.programs import onboard
from pixstep.progress import Progress, unseen
from pixstep.server import remote


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
    """The per-pixel records of the line that `run` or `run_program` has run; else None."""


class Board:
    """A board on the bus: `bus.board(1)`."""

    def __init__(self, link: Link, unit: int) -> None:
        self._link = link
        self.unit = unit
        self.device: Device = link.board(unit)
        """Registers, commands and settings one by one, below this interface."""

    @property
    def kind(self) -> str:
        """What board it says it is: `"uno"`, `"mega"` or `"m1284"`."""
        return self.device.who().board

    @property
    def pixel_hz(self) -> Fraction:
        """The frequency of pixels in Hz that it is set to."""
        return limits.connected(self.device).pixel_hz

    def axes(self) -> tuple[AxisState, ...]:
        """Return the state and the position of every axis."""
        return self._states([*range(self.device.input("axis_count"))])

    def check(
        self,
        line: MotionLine,
        *,
        axes: int = 1,
        sync: str | None = None,
        divider: int | None = None,
    ) -> CheckResult:
        """Check a line by the limits that the board has now; nothing is sent.

        `axes` is the number of axes that move together, its own included; `sync` and `divider` are
        those that `run` is to set.
        """
        arguments.instance("line", line, MotionLine, "a MotionLine")
        clock = settings.of_clock(given.sync(sync), given.divider(divider))
        count = given.axes(axes, None)
        bounds = limits.connected(self.device, line.pixel_hz, count, clock)
        return line.check_by(bounds.of(line.line), self.kind)

    def run(
        self,
        lines: Lines,
        axis: int | None = None,
        *,
        sync: str | None = None,
        divider: int | None = None,
        gate_edges: int | None = None,
        check: bool = True,
        progress: Progress = unseen,
    ) -> tuple[AxisState, ...]:
        """Run lines to their end and return the axes that moved: this blocks until then.

        `lines` is one line for `axis` (by default that of its motor), several lines for the axes of
        their motors, or lines by axis; they start on one pixel clock edge. A line of a motor goes
        to that motor's axis or is refused. Each is checked first; then the board's pixel frequency
        is set to that of the lines, and a line longer than the queue is streamed. `sync` (`"free"`,
        `"start"`, `"lock"`), `divider`, the clock edges of a pixel, and `gate_edges`, those from a
        burst's first one to line zero, are set as well if they are given or a machine file has
        them; otherwise the board's stay. To lock the board must have measured its clock: that is
        waited for. The states that come back have the per-pixel records, of every Nth pixel where
        the bus is too slow for all. Ctrl-C and any error of the program stop the axes.
        Raises RefusedError for a line that the board or its motor's limits refuse (nothing is sent
        then), unless `check` is False; UserError
        for a divider that is not that of the lines' machine, BoardError for a fault, a clock that
        cannot be measured and a board that does not answer.
        """
        by_axis = axes_of(lines, axis)
        arguments.function("progress", progress)
        check = arguments.flag("check", check)
        hz = _one_frequency(by_axis)
        clock = Clocking.of(by_axis, sync, divider, gate_edges)
        refuse_period(hz, self.device.tick_hz())
        kind = self.kind
        has = self.device.input("axis_count")
        if max(by_axis) >= has:
            raise UserError(f"axis {max(by_axis)}: board {self.unit} has {has}: 0 to {has - 1}")
        for item in by_axis.values():
            given.refuse_empty(item.line)
            if item.motor and item.motor.board != kind:
                raise RefusedError(
                    f"{item.line.name}: motor {item.motor.name} is on a {item.motor.board}, board "
                    f"{self.unit} is a {kind}"
                )
            if item.line.backlash:
                self.device.require("backlash")
            if check:
                self.check(
                    item, axes=len(by_axis), sync=clock.sync, divider=clock.divider
                ).raise_if_refused()
        edges = clock.divider or settings.divider(self.device)
        axes = list(by_axis)
        upload.require_idle(self.device, axes)
        settings.set_clock(self.device, hz * edges, clock.sync, clock.divider, clock.gate_edges)
        motions = {number: item.line for number, item in by_axis.items()}
        group = [running.Lines(self.device, axes)]
        collector = Collector(self.unit)
        with (
            recording.recorded(group[0], collector.take) as recorder,
            running.stopped_on_failure(group),
        ):
            clockstate.await_lock(self.device, self._link.world)
            group[0].uploads += upload.begin(self.device, motions, edges)
            running.arm_queued(group[0])
            longest = max(item.pixels for item in by_axis.values())
            running.follow(group, self._link.world, longest, progress)
        return self._recorded(axes, collector, recorder)

    def run_program(
        self, program: MotionProgram, *, check: bool = True, progress: Progress = unseen
    ) -> tuple[AxisState, ...]:
        """Run a motion program while it is planned and return the axes that it moved.

        Memory does not grow with its length. The board's pixel clock, divider and sync become those
        of the machine file. With `check` the program is planned once beforehand,
        so that a mistake in it is found while nothing moves. Ctrl-C and any error of the program
        stop the axes. Raises UserError for a mistake, RefusedError for what the board would refuse,
        BoardError for a fault and for a board that does not answer.
        """
        arguments.instance("program", program, MotionProgram, "a MotionProgram")
        arguments.function("progress", progress)
        check, request = arguments.flag("check", check), program.request
        onboard.require_fitting(MachineFile.load(program.machine.path), request.setup, self.kind)
        known = onboard.rehearse(self.device, request) if check else None
        collector = Collector(self.unit)
        with (
            onboard.prepared(self.device, request, known) as run,
            recording.recorded(run.lines, collector.take) as recorder,
            running.stopped_on_failure([run.lines]),
        ):
            run.run(self._link.world, progress)
        return self._recorded(run.lines.axes, collector, recorder)

    def stop(self) -> tuple[AxisState, ...]:
        """Stop all axes; return where they are."""
        axes = [*range(self.device.input("axis_count"))]
        running.stop_axes(self.device, axes)
        running.rests(self.device, axes, self._link.world)
        return self._states(axes)

    def _recorded(
        self, axes: list[int], collector: Collector, recorder: Recorder | None
    ) -> tuple[AxisState, ...]:
        """Return the states of axes with the records of their lines."""
        return tuple(
            replace(state, records=collector.of(state.axis, recorder))
            for state in self._states(axes)
        )

    def _states(self, axes: list[int]) -> tuple[AxisState, ...]:
        states = running.states(self.device, axes)
        places = running.positions(self.device, axes)
        unknown = running.play_unknown(self.device, axes)
        return tuple(
            AxisState(axis, states[axis], places[axis], axis not in unknown) for axis in axes
        )


class Bus:
    """A bus with boards, a context manager: `with connect("/dev/ttyACM0") as bus:`."""

    def __init__(self, link: Link) -> None:
        self._link = link

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def port(self) -> str:
        """The name of the port."""
        return self._link.port

    def board(self, unit: int = 1) -> Board:
        """Return the board with a Modbus address; nothing is asked of it yet."""
        return Board(self._link, arguments.whole("unit", unit, 1, LAST_UNIT))

    def close(self) -> None:
        """Give the port back."""
        self._link.close()


def connect(
    port: str,
    *,
    baud: int = 115_200,
    parity: str | None = None,
    timeout_s: float | None = None,
) -> Bus:
    """Open the port of a bus with boards; use it in a `with` statement.

    `parity` is `"E"`, `"O"` or `"N"`: even by default, none on a pseudo terminal. Opening the port
    resets a board that is plugged in by USB: its boot loader is given its time. Raises UserError
    saying why a port cannot be opened.
    """
    parity = None if parity is None else arguments.one_of("parity", parity, ("E", "O", "N"))
    if timeout_s is not None:
        timeout_s = arguments.finite("timeout_s", timeout_s, *TIMEOUTS_S)
    name = str(arguments.path("port", port))
    rate = arguments.whole("baud", baud, LEAST_BAUD, MOST_BAUD)
    return Bus(remote.open_bus(Port(name, rate, parity, timeout_s)))


def _one_frequency(lines: Mapping[int, MotionLine]) -> Fraction:
    found = {item.hz for item in lines.values()}
    if len(found) > 1:
        text = " and ".join(f"{hz} Hz" for hz in sorted(found))
        raise UserError(f"lines for {text}: one pixel clock drives all axes")
    return found.pop()
