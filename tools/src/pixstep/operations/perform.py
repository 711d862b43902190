# SPDX-License-Identifier: MIT
"""From what a caller gives to a request, and from the request to its result.

What the caller says comes first, then the machine file, then the default of the field. Where pixels
are too short for limits that an operation was given, its error says which divider would do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep import atomic
from pixstep.errors import UserError
from pixstep.lines.units import Quantity, TooLittleError, enough_edges, hz_words
from pixstep.machine import NO_FILE, find_file
from pixstep.operations.asked import AskedError, Field, FieldError, MissingError, refuse_outputs
from pixstep.operations.desk import Desk, Source
from pixstep.operations.facts import Facts, named_by
from pixstep.operations.kinds import FindScale, no_scale
from pixstep.operations.request import Request, fields
from pixstep.operations.result import Result
from pixstep.profiles.origin import MOST_EDGES

if TYPE_CHECKING:
    from pixstep.machine.files import MachineFile
    from pixstep.operations.desk import Desk
    from pixstep.operations.request import Request


@dataclass(frozen=True)
class Caller:
    """What a caller says besides the values: the machine file, its motors, what may be replaced.

    `machine` None looks for a file where `look` says so, as the command line does.
    """

    machine: str | None = None
    motors: tuple[str, ...] = ()
    force: bool = False
    look: bool = False

    def find(self, named: str | None) -> Path | None:
        """Return the machine file in force, if there is one."""
        return find_file(named) if self.look or named else None


def facts_of(request: type[Request], given: Mapping[str, Any], caller: Caller) -> Facts:
    """Return the facts of a request, of which nothing has been looked up yet.

    `given` are the values of fields that need no scale; the others are not looked at.
    """
    known = fields(request)
    named = named_by(known, given, caller.machine, caller.motors, own=request.own_motor)
    return Facts(known, named, caller.find)


def resolve(
    request: type[Request], given: Mapping[str, Any], facts: Facts
) -> tuple[Request, dict[str, Source]]:
    """Return the request, and where each of its values comes from.

    Raises FieldError for a value that does not fit and for one that is missing, UserError for
    motors that the file does not have.
    """
    if facts.named.any:
        _ = facts.found
    sources: dict[str, Source] = {}
    facts.values.update(given)
    for name, one in facts.fields.items():
        if name in given:
            value, sources[name] = _read(one, given[name], facts.scale), Source.CALLER
        else:
            value, sources[name] = _not_given(one, facts)
        facts.values[name] = value
    request.complete(facts.values, sources)
    if facts.named.machine not in (None, NO_FILE):
        _ = facts.found  # a file that is named is refused also if nothing of it is used
    return request(**{name: facts.values[name] for name in facts.fields}), sources


def _read(field: Field, value: Any, scale: FindScale) -> Any:
    several = value if isinstance(value, (list, tuple)) else (value,)
    if field.many and field.required and not several:
        raise MissingError(field)
    try:
        if field.many:
            return tuple(field.kind.read(one, scale) for one in several)
        return field.kind.read(value, scale)
    except UserError as error:
        raise FieldError(field, str(error)) from None


def _not_given(field: Field, facts: Facts) -> tuple[Any, Source]:
    value = _of_machine(field, facts)
    if value is not None:
        return _read(field, value, facts.scale), Source.MACHINE
    if field.required:
        raise MissingError(field)
    return field.default, Source.DEFAULT


def _of_machine(field: Field, facts: Facts) -> Any:
    if field.machine is None or facts.found is None:
        return None
    try:
        return field.machine(facts)
    except UserError:
        if field.required or facts.named.any or field.name == "axis":
            raise
        return None


def _without_scale(request: type[Request], given: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield what is given, read where that needs no motor: the motors depend on it."""
    for name, one in fields(request).items():
        if name in given:
            scaled = one.kind.scaled
            yield name, given[name] if scaled else _read(one, given[name], no_scale)


def outputs(request: Request) -> list[tuple[Field, Path]]:
    """Return the files and folders that a request writes, with their fields."""
    return [(field, path) for field, path in _paths(request) if field.writes]


def _paths(request: Request) -> list[tuple[Field, Path]]:
    return [
        (field, path)
        for name, field in fields(type(request)).items()
        for path in _several(getattr(request, name))
        if isinstance(path, Path)
    ]


def _several(value: object) -> Iterator[object]:
    """Yield a value, or all that are in it: files may stand in pairs with names."""
    if isinstance(value, tuple):
        for one in value:
            yield from _several(one)
    else:
        yield value


def _inputs(request: Request, desk: Desk) -> list[Path]:
    """Return the files that the request reads, which it never replaces."""
    # To look for a machine file says that it was used.
    writes = request.needs_machine and bool(outputs(request))
    machine = desk.facts.found if writes else None
    named = [path for field, path in _paths(request) if not field.writes]
    return named if machine is None else [*named, machine.path]


def perform(
    request: type[Request],
    given: Mapping[str, Any],
    caller: Caller,
    make_desk: Callable[[Facts, dict[str, Source]], Desk] = Desk,
) -> Result:
    """Run an operation for a program.

    Raises UserError for what does not fit, RefusedError for what a check refuses, BoardError for a
    board that does not do as asked.
    """
    given = dict(_without_scale(request, given))
    facts = facts_of(request, given, caller)
    desk = make_desk(facts, {})
    request.prepare(facts, desk.say)
    made, desk.sources = resolve(request, given, facts)
    with atomic.rules(atomic.WriteRules(caller.force)):
        return finish(made, desk)


def finish(request: Request, desk: Desk) -> Result:
    """Run a request that is whole; every front end does it here."""
    try:
        with atomic.inputs(_inputs(request, desk)):
            refuse_outputs((field.name, path) for field, path in outputs(request))
            return request.run(desk)
    except TooLittleError as error:
        raise _advised(error, request, desk) from None


_LIMITS = ("max_speed", "max_acceleration", "max_jerk")


def _advised(error: TooLittleError, request: Request, desk: Desk) -> AskedError:
    """Return an error of an operation with the field it is about, and with what would do."""
    values = vars(request)
    name = _field_of(error, values, desk.by_machine)
    told = "{reason}" if name is None else f"{{{name}}}: {{reason}}"
    cured = _cure(error, values, desk)
    return AskedError(told, cured, reason=str(error))


def _field_of(
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
