# SPDX-License-Identifier: MIT
"""Requests: frozen dataclasses whose fields say what they are.

    @operation("line make")
    class LineMake(Request):
        '''Make a line: up, constant speed, down.

        More of the help.
        '''

        speed: Quantity = option(SPEED_FIGURE, "Constant speed.", required=True)
        output: Path = option(OUTPUT, "CSV file to write.", "-o", required=True)

        def run(self, desk: Desk) -> Result: ...

A field's help, unit, range, default, machine file's key and the spelling of its option are said
here and nowhere else: the command line, its help and completion, Python's functions, the documents
and the schemas come from them.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, dataclass_transform

from pixstep.operations.asked import Field
from pixstep.operations.kinds import FLAG, Kind

if TYPE_CHECKING:
    from pixstep.operations.desk import Desk, Source
    from pixstep.operations.facts import Facts
    from pixstep.operations.result import Result


_FIELD = "pixstep"


class Request:
    """What all requests have. `result` is the type of the result's data."""

    words: ClassVar[str] = ""
    result: ClassVar[Any] = dict[str, Any]
    own_motor: ClassVar[bool] = False  # a field `motor` of its own chooses the motor too
    needs_machine: ClassVar[bool] = False  # a file as a whole, of which no motor is chosen
    has_json: ClassVar[bool] = True  # what it gives back is data, and no file of its own form
    json_rows: ClassVar[str] = ""  # what is one row of JSON, where the rows come as they are found

    @classmethod
    def prepare(cls, facts: Facts, say: Callable[[Iterable[str]], None]) -> None:
        """Say of the facts what is special to this request, before they are looked up."""

    @classmethod
    def complete(cls, values: dict[str, Any], sources: dict[str, Source]) -> None:
        """Find the values that follow from others, once all are known."""

    def run(self, desk: Desk) -> Result:
        """Do it."""
        raise NotImplementedError


RequestType = TypeVar("RequestType", bound=Request)


def option(kind: Kind, about: str, *names: str, **more: Any) -> Any:
    """Return a field that is an option, by default of its own name; `more` is that of `Field`."""
    return _field(Field(kind, about, names=names, **more))


def flag(about: str, *names: str, **more: Any) -> Any:
    """Return a field that is yes or no."""
    more.setdefault("default", False)
    return _field(Field(FLAG, about, names=names, **more))


def unless(about: str, *names: str) -> Any:
    """Return a field that is yes unless its option is there, as `check` unless --no-check."""
    return _field(Field(FLAG, about, names=names, default=True, unless=True))


def argument(kind: Kind, about: str = "", **more: Any) -> Any:
    """Return a field that stands on the command line without a name, needed unless it says not."""
    more.setdefault("required", True)
    return _field(Field(kind, about, argument=True, **more))


def _field(found: Field) -> Any:
    default = () if found.many and found.default is None else found.default
    return field(default=default, metadata={_FIELD: dataclasses.replace(found, default=default)})


@dataclass_transform(
    frozen_default=True, kw_only_default=True, field_specifiers=(option, flag, unless, argument)
)
def operation(words: str) -> Callable[[type[RequestType]], type[RequestType]]:
    """Return what makes an operation of a request: `words` call it on the command line."""

    def make(request: type[RequestType]) -> type[RequestType]:
        made = dataclass(frozen=True, kw_only=True)(request)
        made.words = words
        return made

    return make


@dataclass_transform(
    frozen_default=True, kw_only_default=True, field_specifiers=(option, flag, unless, argument)
)
def shared_fields(request: type[RequestType]) -> type[RequestType]:
    """Make a class of fields that several operations have."""
    return dataclass(frozen=True, kw_only=True)(request)


def fields(request: type[Request]) -> dict[str, Field]:
    """Return the fields of an operation by name: arguments, its own, then those it shares."""
    found = list(_fields(request))
    own = inspect.get_annotations(request)
    found.sort(key=lambda one: (not one.argument, one.name not in own))
    return {one.name: one for one in found}


def _fields(request: type[Request]) -> Iterator[Field]:
    for one in dataclasses.fields(request):  # type: ignore[arg-type]  # made by `operation`
        known: Field = one.metadata[_FIELD]
        dashed = one.name.replace("_", "-")
        names = tuple(known.names)
        if not known.argument and not any(name.startswith("--") for name in names):
            names = (*names, f"--{dashed}")
        yield dataclasses.replace(known, name=one.name, names=() if known.argument else names)
