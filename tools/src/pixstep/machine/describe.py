# SPDX-License-Identifier: MIT
"""A machine as plain data, per pixel and per second, and what its boards cannot do."""

from collections.abc import Iterator
from fractions import Fraction

from pixstep.board import boards, capability, settings
from pixstep.errors import UserError
from pixstep.lines.units import ACCELERATION, JERK, SPEED, per_second, refuse_period, unit
from pixstep.machine.model import LimitsTable, LineTable, MachineTables, MotorTable
from pixstep.profiles.origin import MOST_EDGES

LEAST = {"smooth": 2, "plain": 1}  # acceleration that counts can have, steps/px2
ORDERS = {
    "max_speed": SPEED,
    "max_acceleration": ACCELERATION,
    "max_jerk": JERK,
    "start_stop": SPEED,
}


def as_json(machine: MachineTables) -> dict[str, object]:
    """Return everything that a machine file says, and what follows from it."""
    return {
        "machine": str(machine.path),
        "pixel_hz": str(machine.pixel_hz),
        "clock_hz": str(machine.clock_hz),
        "divider": machine.clock.divider,
        "sync": machine.clock.sync,
        "gate_edges": machine.clock.gate_edges,
        "line": _line_json(machine.line),
        "program": machine.program.model_dump(mode="json"),
        "epics": machine.epics.model_dump(),
        "boards": {name: board.model_dump() for name, board in machine.boards.items()},
        "motors": {name: motor_json(machine, motor) for name, motor in machine.motors.items()},
    }


def _line_json(line: LineTable) -> dict[str, object]:
    """Return what lines have in common; offsets as they are written."""
    told = line.model_dump(exclude={"scan_offset_forward", "scan_offset_back"})
    told["scan_offset_forward"] = line.scan_offset_forward.text
    told["scan_offset_back"] = line.scan_offset_back.text
    return told


def motor_json(machine: MachineTables, motor: MotorTable) -> dict[str, object]:
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
        "epics": motor.epics.model_dump(),
        "limits": {
            key: limit_json(motor, key, machine.pixel_hz)
            for key in LimitsTable.model_fields
            if motor.limit(key)
        },
        "profiles": {
            use: str(machine.profile(motor, use)) for use in ("line", "move", "home")
            if machine.profile(motor, use)
        },
    }  # fmt: skip


def limit_per_second(motor: MotorTable, key: str, hz: Fraction) -> Fraction | None:
    """Return a limit in steps, by the second; None if the file has none."""
    limit = motor.limit(key)
    return None if limit is None else per_second(limit.per_pixel(hz), ORDERS[key], hz)


def limit_json(motor: MotorTable, key: str, hz: Fraction) -> dict[str, float]:
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


def warnings(machine: MachineTables) -> Iterator[str]:
    """Yield what the file asks of a board that it cannot do, and the divider that would do."""
    enough = None
    for motor in machine.motors.values():
        try:
            able = _able(machine, motor)
        except UserError as error:
            kind = machine.board_of(motor).kind
            yield f"clock.{_wrong_key(machine, kind)}: {kind}: {error}"
            continue
        yield from _too_fast(machine, motor, able)
        slow = _too_slow(machine, motor)
        if slow and _depends_on_pixels(motor):
            enough = enough or enough_divider(machine)
            slow += f": divider = {enough} in the table [clock] would do" if enough else ""
        if slow:
            yield slow


def enough_divider(machine: MachineTables, faults: int | None = None) -> int | None:
    """Return the fewest clock edges of a pixel by which the motors' accelerations are kept, if any.

    No more may be wrong then of clock and speeds than is now, or than `faults`: pixels have a
    longest and a shortest time, and so many steps at most.
    """
    allowed = _faults(machine) if faults is None else faults
    dividers = range(1, MOST_EDGES + 1)
    return next((one for one in dividers if _keeps(with_divider(machine, one), allowed)), None)


def with_divider(machine: MachineTables, edges: int) -> MachineTables:
    """Return a machine with other pixels of the same clock."""
    return machine.model_copy(update={"clock": machine.clock.model_copy(update={"divider": edges})})


def _keeps(machine: MachineTables, allowed: int) -> bool:
    """True if no limit is too low for a machine's pixels, and no more of the rest is wrong."""
    motors = filter(_depends_on_pixels, machine.motors.values())
    return not any(_too_slow(machine, motor) for motor in motors) and _faults(machine) <= allowed


def _faults(machine: MachineTables) -> int:
    """Return how much of a machine its boards cannot do, limits that are too low left out."""
    count = 0
    for motor in machine.motors.values():
        try:
            count += len([*_too_fast(machine, motor, _able(machine, motor))])
        except UserError:
            count += 1
    return count


def _able(machine: MachineTables, motor: MotorTable) -> capability.Capability:
    """Return what a motor's board can do. Raises UserError for a clock that it cannot follow."""
    clock = settings.of_clock(machine.clock.sync, machine.clock.edges)
    return capability.of(machine.board_of(motor).kind, machine.pixel_hz, clock=clock)


def _too_fast(
    machine: MachineTables, motor: MotorTable, able: capability.Capability
) -> Iterator[str]:
    speed, most = motor.limit("max_speed"), able.top_speed(motor.kind)
    if speed and speed.per_pixel(machine.pixel_hz) > most:
        yield (
            f"motors.{motor.name}.limits.max_speed = {speed.text!r}: the {able.board.name} makes "
            f"{most} steps/px = {float(able.rate(motor.kind)):g} steps/s at most"
        )


def _too_slow(machine: MachineTables, motor: MotorTable) -> str:
    """Return that an acceleration is less than the counts of a line can have; "" if it is not."""
    limit, order = motor.limit("max_acceleration"), ORDERS["max_acceleration"]
    least = LEAST[motor.kind]
    if limit is None or limit.per_pixel(machine.pixel_hz) >= least:
        return ""
    figure = per_second(least, order, machine.pixel_hz)
    return (
        f"motors.{motor.name}.limits.max_acceleration = {limit.text!r}: a {motor.kind} line has "
        f"{float(figure):g} {unit(order, per_second=True)} at least"
    )


def _depends_on_pixels(motor: MotorTable) -> bool:
    limit = motor.limit("max_acceleration")
    return limit is not None and limit.per_second


def _wrong_key(machine: MachineTables, kind: str) -> str:
    """Return which key of the clock a board cannot follow: its edges, or what is made of them."""
    if machine.clock.edges > 1:
        try:
            refuse_period(machine.clock_hz, boards.load(kind).tick_hz)
        except UserError:
            return "pixel"
        return "divider"
    return "pixel"


def notes(machine: MachineTables) -> Iterator[str]:
    """Yield the profiles that are not there yet: a machine file comes before its profiles."""
    for motor in machine.motors.values():
        for use in ("line", "move", "home"):
            path = machine.profile(motor, use)
            if path and not path.is_file():
                yield (
                    f"motors.{motor.name}.profiles.{use}: {path}: there is no such file yet "
                    f"(`pixstep profile make` makes one)"
                )
