# SPDX-License-Identifier: MIT
"""A machine file as a program sees it: boards and motors, all figures in steps and pixels."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, cast

from pixstep import arguments
from pixstep.api.shown import Facts, Shown
from pixstep.api.words import BoardKind, Decode, Sync
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep.lines.line_check import Limits
from pixstep.lines.units import Quantity, Scale

if TYPE_CHECKING:
    from pixstep.machine import files
    from pixstep.machine.model import MotorTable
else:
    files = lazy("pixstep.machine.files")  # pydantic takes a while to load


@dataclass(frozen=True, repr=False)
class Motor(Shown):
    """A motor of a machine: its place, its kind and its limits, `machine["M39"]`."""

    name: str
    """Name in the machine file."""
    axis: int
    """Axis of its board, from 0."""
    decode: Decode
    """`"smooth"` (the speed changes inside a pixel) or `"plain"` (one speed in each pixel)."""
    board: BoardKind
    """Kind of its board: `"uno"`, `"mega"` or `"m1284"`."""
    pixel_hz: Fraction
    """Frequency of the machine's pixels in Hz, exact."""
    divider: int
    """Edges of the machine's clock in a pixel."""
    sync: Sync | None
    """What its lines are to the clock: `"free"`, `"start"`, `"lock"`; None: not said."""
    gate_edges: int | None
    """How many edges behind the first one of a burst of a gated clock its lines begin; 0: the clock
    is not gated, None: not said."""
    clock_out_hz: int | None
    """The pixel clock in Hz that its board makes itself, on pin CLOCK_OUT; None: not said."""
    backlash_steps: int
    """Play between motor and load in steps."""
    negative: bool
    """True if the load's positive direction is the motor's negative one."""
    steps_per_unit: Scale | None
    """Steps for a millimetre or a degree of the load; None if the file does not say."""
    limits: Limits
    """What the motor can do, in steps and pixels; None where the file has no limit."""
    profile: Path | None
    """Its acceleration profile for lines, if the file names one."""
    port: str | None
    """Serial port of its board, if the file names one."""
    unit: int
    """Modbus address of its board."""
    move_profile: Path | None = None
    """Its acceleration profile for moves, if the file names one."""
    home_profile: Path | None = None
    """Its acceleration profile for homing, if the file names one."""

    @property
    def smooth(self) -> bool:
        """True if its speed changes inside a pixel."""
        return self.decode == "smooth"

    def _headline(self) -> str:
        return f"{self.name}: {self.decode}, axis {self.axis} of a {self.board}"

    def _facts(self) -> Facts:
        yield "pixels", f"{float(self.pixel_hz):g} Hz"
        yield "clock edges of a pixel", self.divider
        yield "backlash", f"{self.backlash_steps} steps"
        yield "direction", "-" if self.negative else "+"
        yield "scale", self.steps_per_unit or "not said"
        for name, value in vars(self.limits).items():
            if value is not None:
                yield name.replace("_", " "), value


@dataclass(frozen=True, repr=False)
class Machine(Shown):
    """A machine file (docs/MACHINE.md), read and checked.

    Example:
        >>> machine = Machine.load("printer.toml")
        >>> machine["M39"].backlash_steps
        250
        >>> [motor.name for motor in machine.motors]
        ['M39', 'M40']
    """

    path: Path
    """The file."""
    pixel_hz: Fraction
    """Frequency of its pixels in Hz, exact."""
    divider: int
    """Edges of its clock in a pixel: the clock has `divider` times the frequency of the pixels."""
    sync: Sync | None
    """What lines are to the clock: `"free"`, `"start"`, `"lock"`; None: not said."""
    motors: tuple[Motor, ...]
    """All motors, in the order of the file."""

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Machine:
        """Read a machine file.

        Raises UserError naming file, line, key and value of the first mistake.
        """
        read = files.MachineFile.load(arguments.path("path", path))
        motors = tuple(_motor(read, motor) for motor in read.motors.values())
        return cls(read.path, read.pixel_hz, read.clock.edges, read.clock.sync, motors)

    def __getitem__(self, name: str) -> Motor:
        """Return a motor by its name; raises UserError naming those that there are."""
        for motor in self.motors:
            if isinstance(name, str) and motor.name == name:
                return motor
        known = ", ".join(motor.name for motor in self.motors)
        raise UserError(f"{self.path}: there is no motor {arguments.shown(name)}: {known}")

    def _headline(self) -> str:
        motors = ", ".join(motor.name for motor in self.motors)
        return f"{self.path}: {float(self.pixel_hz):g} Hz, motors {motors}"

    def _facts(self) -> Facts:
        for motor in self.motors:
            yield motor.name, motor._headline().partition(": ")[2]


def _motor(read: files.MachineFile, table: MotorTable) -> Motor:
    board = read.board_of(table)
    return Motor(
        name=table.name,
        axis=table.axis,
        decode=cast(Decode, table.decode),
        board=cast(BoardKind, board.kind),
        pixel_hz=read.pixel_hz,
        divider=read.clock.edges,
        sync=read.clock.sync,
        gate_edges=read.clock.gate_edges,
        clock_out_hz=board.clock_out_hz,
        backlash_steps=table.backlash_steps,
        negative=table.negative,
        steps_per_unit=table.steps_per_unit,
        limits=_limits(table, read.pixel_hz),
        profile=read.profile(table, "line"),
        port=board.port,
        unit=board.unit,
        move_profile=read.profile(table, "move"),
        home_profile=read.profile(table, "home"),
    )


def _limits(table: MotorTable, hz: Fraction) -> Limits:
    """Return the limits of a motor in whole steps and pixels, rounded down."""

    def whole(quantity: Quantity | None) -> int | None:
        return None if quantity is None else int(quantity.per_pixel(hz))

    return Limits(
        max_speed=whole(table.limit("max_speed")),
        max_acceleration=whole(table.limit("max_acceleration")),
        start_stop=whole(table.limit("start_stop")),
        jerk_warning=whole(table.limit("max_jerk")),
    )
