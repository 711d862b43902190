# SPDX-License-Identifier: MIT
"""Lines of one or several boards: on which axis, by which clock; checked, then made by a Motion."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Self

from pixstep import arguments
from pixstep.api import given
from pixstep.api.motion import AxisState, Recording, states_of
from pixstep.api.motions import CheckResult, MotionLine
from pixstep.board import recording, settings, snapshot, upload
from pixstep.board import run as running
from pixstep.board.device import Device
from pixstep.board.handle import Course
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import have_package, lazy
from pixstep.lines.units import refuse_period

if TYPE_CHECKING:
    from pixstep.board import capability, guarantee, together
else:  # what the boards of a bus need when they are asked to move
    capability, guarantee = lazy("pixstep.board.capability"), lazy("pixstep.board.guarantee")
    together = lazy("pixstep.board.together")

Lines = MotionLine | Sequence[MotionLine] | Mapping[int, MotionLine]
"""One line, several, or lines by axis."""


def by_axis(lines: Lines, axis: int | None = None) -> dict[int, MotionLine]:
    """Return lines by axis.

    One line goes to `axis`, else to the axis of its motor, else to axis 0; several to those of
    their motors, or to axes 0, 1, 2 ... if none has a motor. Raises UserError for no line at all,
    for two lines of one axis, and where an axis that is named is not that of the line's motor.
    """
    if isinstance(lines, MotionLine):
        chosen = lines.axis if axis is None else given.axis(axis)
        return _agreed({chosen: lines})
    if axis is not None:
        raise UserError(f"axis {arguments.shown(axis)}: only one line has an axis by it")
    if isinstance(lines, Sequence) and not isinstance(lines, str):
        return _in_order(lines)
    return _agreed(_checked(given.by_axis("lines", lines)))


def _in_order(lines: Sequence[MotionLine]) -> dict[int, MotionLine]:
    """Return lines that are given without axes."""
    found = _checked(dict(enumerate(lines)))
    if not any(item.motor for item in found.values()):
        return found
    placed: dict[int, MotionLine] = {}
    for item in found.values():
        if item.motor is None:
            raise UserError(f"{item.line.name}: has no motor, the others have: give lines by axis")
        if item.axis in placed:
            raise UserError(f"axis {item.axis}: has two lines, of motor {item.motor.name}")
        placed[item.axis] = item
    return placed


def _checked(lines: Mapping[int, MotionLine]) -> dict[int, MotionLine]:
    if not lines:
        raise UserError("no line is given")
    for axis, item in lines.items():
        arguments.instance(f"line of axis {axis}:", item, MotionLine, "a MotionLine")
    return dict(lines)


def _agreed(lines: dict[int, MotionLine]) -> dict[int, MotionLine]:
    """Return lines by axis; raises UserError for the line of another axis' motor."""
    for axis, item in lines.items():
        if item.motor and item.motor.axis != axis:
            raise UserError(
                f"{item.line.name}: is for motor {item.motor.name}, axis {item.motor.axis}, not "
                f"for axis {axis}"
            )
    return lines


@dataclass(frozen=True)
class Clocking:
    """What lines are to the pixel clock; None is as the machine has it, else the board."""

    sync: str | None = None
    divider: int | None = None
    gate_edges: int | None = None
    clock_out_hz: int | None = None

    def of_lines(self, lines: Mapping[int, MotionLine]) -> Self:
        """Return what is given, else what the machine of the lines has.

        Raises UserError for what no board knows, and for a divider by which the pixels of a line
        would not be edges of its machine's clock.
        """
        wanted: str | None = given.sync(self.sync)
        divider, gate_edges = given.divider(self.divider), given.gate_edges(self.gate_edges)
        own = self.clock_out_hz
        for item in lines.values():
            motor = item.motor
            if item.divider is not None:
                divider = _agreed_divider(item, item.divider, divider, "the clock")
            if motor is None:
                continue
            wanted = wanted or motor.sync
            gate_edges = motor.gate_edges if gate_edges is None else gate_edges
            own = motor.clock_out_hz if own is None else own
            if item.divider is None and item.hz == motor.pixel_hz:
                divider = _agreed_divider(item, motor.divider, divider, "its machine's clock")
        return type(self)(wanted, divider, gate_edges, own)


def _agreed_divider(item: MotionLine, own: int, other: int | None, clock: str) -> int:
    """Return the divider of a line. Raises UserError if the run has another one."""
    if other not in (None, own):
        edges = "one edge" if own == 1 else f"{own} edges"
        raise UserError(f"{item.line.name}: its pixels are {edges} of {clock}, the run has {other}")
    return own


@dataclass(frozen=True)
class Prepared:
    """Lines of one board that were checked; nothing is sent yet."""

    device: Device
    by_axis: Mapping[int, MotionLine]
    clock_hz: Fraction
    edges: int  # of the clock, a pixel
    clocking: Clocking
    lines: running.LinesOfBoard
    records: Recording

    @property
    def longest(self) -> int:
        """Pixels of the longest line."""
        return max(item.pixels for item in self.by_axis.values())

    @property
    def pixels(self) -> dict[tuple[int, int], int]:
        """Pixels of each line, by unit and axis."""
        return {(self.device.unit, axis): item.pixels for axis, item in self.by_axis.items()}

    def set_clock(self) -> None:
        """Set the board's clock to that of the lines."""
        wanted = self.clocking
        settings.set_clock(
            self.device, self.clock_hz, wanted.sync, wanted.divider, wanted.gate_edges,
            wanted.clock_out_hz,
        )  # fmt: skip

    def recorded(
        self, axes_together: int
    ) -> contextlib.AbstractContextManager[recording.Recorder | None]:
        """Let the records of the lines be read along, those of so many axes on the bus."""
        return recording.recorded(self.lines, self.records.take, axes_together=axes_together)

    def queue(self) -> None:
        """Queue the lines, or as much of them as the queues hold."""
        motions = {axis: item.line for axis, item in self.by_axis.items()}
        self.lines.uploads += upload.begin(self.device, motions, self.edges)

    def states(self) -> tuple[AxisState, ...]:
        """Return where the axes are, with the records of their lines."""
        return with_records(self.device, self.lines.axes, self.records)


def with_records(device: Device, axes: Sequence[int], records: Recording) -> tuple[AxisState, ...]:
    """Return the states of some axes with the records of their lines; without, if numpy lacks."""
    states = states_of(device, axes)
    if not have_package("numpy"):  # the motion is over, and well: no reason to fail
        return states
    return tuple(replace(state, records=records.of(state.axis)) for state in states)


def check(
    device: Device, line: MotionLine, axes: int, clock: Clocking, *, guaranteed: bool
) -> CheckResult:
    """Check a line by the limits that a board has now; `axes` move together."""
    known = settings.of_clock(given.sync(clock.sync), given.divider(clock.divider))
    axes = given.axes(axes, None)
    bounds = capability.connected_limits(device, line.pixel_hz, axes, known)
    found = line.check_by(bounds.of(line.line), device.who().board)
    world = guarantee.of_board(device, bounds.pixel_hz, known) if guaranteed else None
    return found.with_guarantee(line.line, axes, world) if world else found


def prepare(
    device: Device,
    lines: Lines,
    axis: int | None,
    clock: Clocking,
    *,
    checked: bool,
    beyond: bool,
) -> Prepared:
    """Check lines for a board; nothing is sent."""
    found = by_axis(lines, axis)
    checked, beyond = arguments.flag("check", checked), arguments.flag("beyond", beyond)
    hz = _one_frequency(found)
    wanted = clock.of_lines(found)
    refuse_period(hz, device.tick_hz())
    _refuse(device, found)
    if checked:
        for item in found.values():
            check(device, item, len(found), wanted, guaranteed=False).raise_if_refused()
        known = settings.of_clock(given.sync(wanted.sync), given.divider(wanted.divider))
        world = guarantee.of_board(device, hz, known)
        if world and not beyond:
            guarantee.refuse([item.line for item in found.values()], world, guarantee.ADVICE)
    edges = wanted.divider or settings.divider(device)
    axes = list(found)
    upload.require_idle(device, axes)
    return Prepared(
        device, found, hz * edges, edges, wanted, running.LinesOfBoard(device, axes),
        Recording(device.unit, axes),
    )  # fmt: skip


def make(prepared: Prepared, course: Course) -> tuple[AxisState, ...]:
    """Make the lines of one board, to their end."""
    lines = prepared.lines
    recorded = prepared.recorded(len(lines.axes))
    with recorded as prepared.records.recorder, running.stopped_on_failure([lines]):
        snapshot.await_lock(prepared.device, course.world)
        prepared.queue()
        running.arm_queued(lines)
        course.begun()
        running.follow([lines], course.world, prepared.longest, course.progress)
    return prepared.states()


def make_together(several: Sequence[Prepared], course: Course) -> dict[int, tuple[AxisState, ...]]:
    """Make the lines of several boards, which begin on one edge of their clock, to their end."""
    group = [one.lines for one in several]
    axes_together = sum(len(lines.axes) for lines in group)
    with contextlib.ExitStack() as stack:
        for one in several:
            one.records.recorder = stack.enter_context(one.recorded(axes_together))
        stack.enter_context(running.stopped_on_failure(group))
        for one in several:
            snapshot.await_lock(one.device, course.world)
            one.queue()
        course.begun()
        started = together.start(group, course.world)
        longest = max(one.longest for one in several)
        running.follow(group, course.world, longest, course.progress)
        started.compare(course.world)
    return {one.device.unit: one.states() for one in several}


def prepare_several(
    lines: Mapping[int, Lines],
    device_of: Callable[[int], Device],
    clock: Clocking,
    *,
    checked: bool,
    beyond: bool,
) -> list[Prepared]:
    """Check lines by the addresses of their boards, and that one clock drives them all."""
    if not isinstance(lines, Mapping) or not lines:
        raise UserError(f"lines {arguments.shown(lines)}: expected lines by address of a board")
    found = [
        prepare(device_of(unit), ours, None, clock, checked=checked, beyond=beyond)
        for unit, ours in lines.items()
    ]
    clocks = {one.clock_hz for one in found}
    if len(clocks) > 1:
        text = " and ".join(f"{hz} Hz" for hz in sorted(clocks))
        raise UserError(f"lines for pixel clocks of {text}: one clock drives all boards")
    return found


def _refuse(device: Device, lines: Mapping[int, MotionLine]) -> None:
    """Raise UserError or RefusedError for lines that are not for this board."""
    kind, has = device.who().board, device.input("axis_count")
    if max(lines) >= has:
        raise UserError(f"axis {max(lines)}: board {device.unit} has {has}: 0 to {has - 1}")
    for item in lines.values():
        given.refuse_empty(item.line)
        if item.motor and item.motor.board != kind:
            raise RefusedError(
                f"{item.line.name}: motor {item.motor.name} is on a {item.motor.board}, board "
                f"{device.unit} is a {kind}"
            )
        if item.line.backlash:
            device.require("backlash")


def _one_frequency(lines: Mapping[int, MotionLine]) -> Fraction:
    found = {item.hz for item in lines.values()}
    if len(found) > 1:
        text = " and ".join(f"{hz} Hz" for hz in sorted(found))
        raise UserError(f"lines for {text}: one pixel clock drives all axes")
    return found.pop()
