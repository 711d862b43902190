# SPDX-License-Identifier: MIT
"""How motors come to speed in a job's lines: by their profiles, else by their limits.

A motor that scans goes through the speeds of its line profile. One that steps or turns makes a move
of exactly so many steps, by its move profile (a turning one by its line profile first).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep import formats
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN
from pixstep.lines.units import SPEED, Quantity
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable
from pixstep.moves import fast
from pixstep.moves.fast import Acceleration
from pixstep.profiles import accelerate, generator, origin
from pixstep.profiles.accelerate import WantedLine
from pixstep.profiles.generator import LineRequest

LINE, MOVE = "line", "move"
OWN = "own"  # a line profile that was named, instead of the machine file's


@dataclass(frozen=True)
class RampFromRest:
    """An acceleration from rest: speeds at the ends of its pixels, and the steps of each.

    `use` is the profile that it comes from; "" for limits.
    """

    ends: tuple[int, ...]
    counts: tuple[int, ...]
    notes: tuple[str, ...] = ()
    use: str = ""

    @property
    def pixels(self) -> int:
        """How long it is."""
        return len(self.counts)

    @property
    def speed(self) -> int:
        """The speed after it, steps/pixel."""
        return self.ends[-1]

    def falling(self, rest: int, *, plain: bool) -> tuple[int, ...]:
        """Return the deceleration, with a pixel more that adds `rest` steps if that is not 0."""
        if not rest:
            return self.counts[::-1]
        ends = [*self.ends]
        return tuple(accelerate.falling_with_rest([*self.counts], ends, rest, plain=plain))


def scanning(
    machine: MachineFile, motor: MotorTable, speed: int, profile: Path | None
) -> RampFromRest:
    """Return the acceleration of a motor to the speed of its lines.

    Raises UserError for a motor that has neither a profile nor a limit of the acceleration.
    """
    path = profile or machine.profile(motor, LINE)
    use = OWN if profile else LINE
    said: tuple[str, ...] = ()
    if path is None:
        top = Quantity(Fraction(speed), SPEED, False, f"{speed}")
        wanted = _wanted(machine, motor, top)
        speeds = accelerate.speeds(wanted, speed, machine.clock.edges)
        path, use = Path(motor.name), ""
    else:
        speeds, notes = formats.read_prn(path)
        other = origin.frequency_notes(path, None, machine.pixel_hz, refuse=True)
        said = (*notes, *other)
    make = generator.acceleration_counts if motor.smooth else generator.plain_counts
    counts = make(speeds, speed, str(path))
    ends = (*(one for one in speeds if one < speed), speed)
    return RampFromRest(ends, tuple(counts), said, use)


def move(machine: MachineFile, motor: MotorTable, steps: int, uses: Sequence[str]) -> RampFromRest:
    """Return a move of exactly so many steps as counts, by the first profile that is there.

    Raises UserError for a motor that has neither a profile nor limits.
    """
    if motor.smooth:
        return _smooth_move(machine, motor, steps)
    profile, use = _acceleration(machine, motor, uses)
    limit = motor.limit("max_speed")
    top = None if limit is None else int(limit.per_pixel(machine.pixel_hz))
    limited = profile.limited(top)
    if fast.fewest_pixels(limited, abs(steps)) > generator.MOST_PIXELS:
        raise UserError(
            f"motor {motor.name}: {abs(steps)} steps at {limited.top} steps/px at most take more "
            f"than the {generator.MOST_PIXELS} pixels of a line"
        )
    made = fast.plan(limited, steps)
    notes = profile.notes_at(machine.pixel_hz, refuse=True)
    return RampFromRest((made.top,), made.counts, tuple(notes), use)


def _acceleration(
    machine: MachineFile, motor: MotorTable, uses: Sequence[str]
) -> tuple[Acceleration, str]:
    """Return the acceleration of a plain motor and what it comes from; of a PRN counts."""
    for use in uses:
        path = machine.profile(motor, use)
        if path is None:
            continue
        if use == MOVE:
            return fast.read(path), use
        speeds, notes = formats.read_prn(path)
        named = origin.frequency_of(path, None)
        made = Acceleration(tuple(speeds), source=str(path), made_for_hz=named, notes=tuple(notes))
        return made, use
    return by_limits(machine, motor), ""


def by_limits(machine: MachineFile, motor: MotorTable) -> Acceleration:
    """Return the acceleration that a motor's limits allow. Raises UserError if it has none."""
    wanted = _wanted(machine, motor)
    top = int(wanted.speed.per_pixel(machine.pixel_hz))
    counts = accelerate.speeds(wanted, top, machine.clock.edges)
    return Acceleration(tuple(counts), source=f"motor {motor.name}")


def _smooth_move(machine: MachineFile, motor: MotorTable, steps: int) -> RampFromRest:
    wanted = _wanted(machine, motor)
    top = int(wanted.speed.per_pixel(machine.pixel_hz)) // 2 * 2
    asked = LineRequest(0, 0, plain=motor.decode == PLAIN)
    made, speed = accelerate.line_of_length(wanted, top, machine.clock.edges, abs(steps), asked)
    return RampFromRest((speed,), tuple(made.counts))


def _wanted(machine: MachineFile, motor: MotorTable, speed: Quantity | None = None) -> WantedLine:
    """Return what a motor's limits want of a line, at its highest speed if no other is given."""
    speed, acceleration = speed or motor.limit("max_speed"), motor.limit("max_acceleration")
    if speed is None or acceleration is None:
        raise UserError(
            f"{machine.path}: motor {motor.name} has no profile for this, and no limits.max_speed "
            f"and limits.max_acceleration by which one could be made"
        )
    return WantedLine(
        speed, acceleration, motor.limit("max_jerk"), machine.clock_hz, not motor.smooth
    )
