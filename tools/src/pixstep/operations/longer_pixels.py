# SPDX-License-Identifier: MIT
"""The divider by which pixels are long enough for limits that an operation was given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from pixstep.lines.units import Quantity, TooLittleError, enough_edges, hz_words
from pixstep.operations.asked import AskedError
from pixstep.profiles.origin import MOST_EDGES

if TYPE_CHECKING:
    from pixstep.machine.files import MachineFile
    from pixstep.operations.desk import Desk
    from pixstep.operations.request import Request

_LIMITS = ("max_speed", "max_acceleration", "max_jerk")


def advised(error: TooLittleError, request: Request, desk: Desk) -> AskedError:
    """Return an error of an operation with the field it is about, and with what would do."""
    values = vars(request)
    name = field(error, values, desk.by_machine)
    told = "{reason}" if name is None else f"{{{name}}}: {{reason}}"
    cured = _cure(error, values, desk)
    return AskedError(told, cured, reason=str(error))


def field(
    error: TooLittleError, values: Mapping[str, Any], by_machine: Callable[[str], bool]
) -> str | None:
    """Return the field that the caller gave the limit by which is too little."""
    if error.given is None:
        return None
    names = (name for name, value in values.items() if value is error.given)
    return next((name for name in names if not by_machine(name)), None)


def divider_words(desk: Desk, clock_hz: Fraction, edges: int) -> str:
    """Return the fields by which pixels have so many clock edges, as a template of `AskedError`."""
    known = desk.given("clock_hz") or desk.by_machine("clock_hz")
    clock = "" if known else f"{{clock_hz}} {hz_words(clock_hz)} "
    return f"{clock}{{divider}} {edges}"


def _cure(error: TooLittleError, values: Mapping[str, Any], desk: Desk) -> str:
    """Return which divider cures an error, as a template of `AskedError`; "" if none does."""
    by_machine, machine = desk.by_machine, desk.facts.used
    clock_hz = _clock_hz(values, by_machine, machine)
    if error.quantity is None or clock_hz is None:
        return ""
    given = [values.get(name) for name in _LIMITS]
    limits = [error.quantity, *(limit for limit in given if isinstance(limit, Quantity))]
    edges = max(enough_edges(limit, clock_hz, error.least) or 1 for limit in limits)
    if edges > MOST_EDGES:
        return ""
    file = f"divider = {edges} in the table [clock] of {_plain(machine.path)}" if machine else ""
    if "divider" in values:
        would = f": {divider_words(desk, clock_hz, edges)} would do"
        return would + (f", or {file}" if file else "")
    if file and by_machine("pixel_hz"):
        return f": {file} would do"
    hz = f"{float(clock_hz / edges):.10g}"
    return f": pixels of {edges} clock edges would do, {{pixel_hz}} {hz}"


def _clock_hz(
    values: Mapping[str, Any], by_machine: Callable[[str], bool], machine: MachineFile | None
) -> Fraction | None:
    """Return the frequency of the clock's edges; of pixels where nothing says how many they are."""
    if "divider" not in values and by_machine("pixel_hz"):
        return machine.clock_hz if machine else None
    hz = values.get("clock_hz", values.get("pixel_hz"))
    return hz if isinstance(hz, Fraction) else None


def _plain(text: object) -> str:
    """Return a text that stands in a template as it is."""
    return str(text).replace("{", "{{").replace("}", "}}")
