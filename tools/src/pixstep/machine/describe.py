# SPDX-License-Identifier: MIT
"""A machine as plain data, per pixel and per second, and what its boards cannot do."""

from collections.abc import Iterator
from fractions import Fraction

from pixstep.board import boards, capability, settings
from pixstep.errors import UserError
from pixstep.lines.rational import refuse_period
from pixstep.lines.units import ACCELERATION, JERK, SPEED, per_second, unit
from pixstep.machine.model import Limits, Motor, Tables

ORDERS = {
    "max_speed": SPEED,
    "max_acceleration": ACCELERATION,
    "max_jerk": JERK,
    "start_stop": SPEED,
}


def as_json(machine: Tables) -> dict[str, object]:
    """Return everything that a machine file says, and what follows from it."""
    return {
        "machine": str(machine.path),
        "pixel_hz": str(machine.pixel_hz),
        "clock_hz": str(machine.clock_hz),
        "divider": machine.clock.divider,
        "sync": machine.clock.sync,
        "gate_edges": machine.clock.gate_edges,
        "line": machine.line.model_dump(),
        "program": machine.program.model_dump(mode="json"),
        "boards": {name: board.model_dump() for name, board in machine.boards.items()},
        "motors": {name: motor_json(machine, motor) for name, motor in machine.motors.items()},
    }


def motor_json(machine: Tables, motor: Motor) -> dict[str, object]:
    """Return a motor: lengths in steps, limits per pixel and per second."""
    scale = motor.steps_per_unit
    return {
        "board": machine.board_name(motor),
        "axis": motor.axis,
        "word": motor.word,
        "kind": motor.kind,
        "direction": motor.direction,
        f"steps_per_{scale.length}" if scale else "steps_per_unit": (
            float(scale.steps_per_unit) if scale else None
        ),
        "backlash_steps": motor.backlash_steps,
        "home_is_limit": motor.home_is_limit,
        "limits": {
            key: limit_json(motor, key, machine.pixel_hz)
            for key in Limits.model_fields
            if motor.limit(key)
        },
        "profiles": {
            use: str(machine.profile(motor, use)) for use in ("line", "move", "home")
            if machine.profile(motor, use)
        },
    }  # fmt: skip


def limit_json(motor: Motor, key: str, hz: Fraction) -> dict[str, float]:
    """Return a limit in steps per pixel and second, and in the motor's unit of length."""
    order, scale = ORDERS[key], motor.steps_per_unit
    limit = motor.limit(key)
    assert limit is not None  # the caller has looked
    value = limit.per_pixel(hz)
    second = per_second(value, order, hz)
    told = {unit(order): float(value), unit(order, per_second=True): float(second)}
    if scale:
        told[unit(order, per_second=True, length=scale.length)] = float(
            second / scale.steps_per_unit
        )
    return told


def warnings(machine: Tables) -> Iterator[str]:
    """Yield what the file asks of a board that it cannot do."""
    for motor in machine.motors.values():
        kind = machine.board_of(motor).kind
        try:
            clock = settings.of_clock(machine.clock.sync, machine.clock.edges)
            able = capability.of(kind, machine.pixel_hz, clock=clock)
        except UserError as error:
            yield f"clock.{_wrong_key(machine, kind)}: {kind}: {error}"
            continue
        speed, most = motor.limit("max_speed"), able.top_speed(motor.kind)
        if speed and speed.per_pixel(machine.pixel_hz) > most:
            yield (
                f"motors.{motor.name}.limits.max_speed = {speed.text!r}: the {kind} makes "
                f"{most} steps/px = {float(able.rate(motor.kind)):g} steps/s at most"
            )
        acceleration = motor.limit("max_acceleration")
        least = able.least_acceleration(motor.kind)
        if acceleration and acceleration.per_pixel(machine.pixel_hz) < least / machine.pixel_hz**2:
            yield (
                f"motors.{motor.name}.limits.max_acceleration = {acceleration.text!r}: a "
                f"{motor.kind} line has {float(least):g} steps/s2 at least"
            )


def _wrong_key(machine: Tables, kind: str) -> str:
    """Return which key of the clock a board cannot follow: its edges, or what is made of them."""
    if machine.clock.edges > 1:
        try:
            refuse_period(machine.clock_hz, boards.load(kind).tick_hz)
        except UserError:
            return "pixel"
        return "divider"
    return "pixel"


def notes(machine: Tables) -> Iterator[str]:
    """Yield the profiles that are not there yet: a machine file comes before its profiles."""
    for motor in machine.motors.values():
        for use in ("line", "move", "home"):
            path = machine.profile(motor, use)
            if path and not path.is_file():
                yield (
                    f"motors.{motor.name}.profiles.{use}: {path}: there is no such file yet "
                    f"(`pixstep profile make` makes one)"
                )
