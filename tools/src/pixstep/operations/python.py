# SPDX-License-Identifier: MIT
"""Operations as functions of Python, which `pixstep.ops` has."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from pixstep import arguments
from pixstep.errors import UserError, told
from pixstep.operations import catalog
from pixstep.operations.asked import Field
from pixstep.operations.desk import Desk, nobody_watches
from pixstep.operations.perform import Caller, perform
from pixstep.operations.request import Request, fields
from pixstep.operations.result import Result

if TYPE_CHECKING:
    from pixstep.board.link import Link
    from pixstep.operations.desk import Shown

_BESIDE = ("machine", "motor", "force", "link", "progress")
"""What every function takes besides the fields of its request."""


@runtime_checkable
class HasLink(Protocol):
    """A px.Bus, or a px.Board, whose address is then meant."""

    @property
    def link(self) -> Link:
        """The open bus."""


def name_of(words: str) -> str:
    """Return the function that stands for a command: `line_make` of "line make"."""
    return words.replace(" ", "_").replace("-", "_")


def run(
    request: type[Request],
    given: dict[str, Any],
    *,
    machine: str | PathLike[str] | None = None,
    motor: str | Iterable[str] = (),
    force: bool = True,
    link: Link | HasLink | None = None,
    progress: Shown = nobody_watches,
) -> Result:
    """Run an operation for a program; see `perform.perform`.

    `machine` is a machine file, `motor` the motors of it that are meant, one for each line; `link`
    is an open bus, as px.connect or px.simulated_bus opens it, or a board of one; with `force`
    False no file is replaced. Notes come with the result.
    """
    known = fields(request)
    for name in given:
        if name not in known:
            raise UserError(f"{name}: {name_of(request.words)} takes {', '.join(known)}")
    motors = (motor,) if isinstance(motor, str) else tuple(motor)
    caller = Caller(
        None if machine is None else fspath(machine), motors, arguments.flag("force", force)
    )
    notes: list[str] = []
    found = link.link if isinstance(link, HasLink) else link
    if found is not None and "port" in known:
        unit = getattr(link, "unit", None)
        named = {} if unit is None else dict.fromkeys({"unit", "units"} & known.keys(), unit)
        given = {"port": found.port, **named, **given}
    words = _words(request)
    try:
        result = perform(request, given, caller, desk_of(notes, found, progress))
    except UserError as error:
        if len(error.args) == 1:
            error.args = (told(error, words),)
        raise
    return replace(result, notes=tuple(told(note, words) for note in notes))


def _words(request: type[Request]) -> dict[str, str]:
    """Return the fields whose options have other names, by these: `line_number` of "line"."""
    known = fields(request)
    spelled = {one.option: name for name, one in known.items()}
    spelled |= {one.off: f"{name}=False" for name, one in known.items() if one.off}
    spelled |= {one.option: f"{name}=False" for name, one in known.items() if one.unless}
    words = {option.strip("-").replace("-", "_"): word for option, word in spelled.items()}
    return {word: name for word, name in words.items() if word not in known}


def desk_of(notes: list[str], link: Link | None, progress: Shown) -> Callable[..., Desk]:
    """Return what makes the desk of a program: what it is told is kept."""

    def take(more: Iterable[str]) -> None:
        notes.extend(more)

    def make(facts: Any, sources: Any) -> Desk:
        return Desk(
            facts, sources, say=take, warn=take, complain=lambda error: take((str(error),)),
            aside=lambda text: take((text,)), progress=progress, link=link,
        )  # fmt: skip

    return make


@cache
def function(name: str) -> Callable[..., Result]:
    """Return the function of an operation by its name. Raises AttributeError if there is none."""
    words = next((words for words in catalog.OPERATIONS if name_of(words) == name), None)
    if words is None:
        raise AttributeError(f"no operation is called {name}")
    request = catalog.load(words)
    signature = _signature(request)

    def call(*places: Any, **given: Any) -> Result:
        beside = {key: given.pop(key) for key in _BESIDE if key in given and key not in own}
        for (key, _), value in zip(positional, places, strict=False):
            given.setdefault(key, value)
        if len(places) > len(positional):
            raise UserError(f"{name}: takes {len(positional)} values without a name")
        return run(request, given, **beside)

    own = fields(request)
    positional = [(key, one) for key, one in own.items() if one.argument]
    call.__name__ = call.__qualname__ = name
    call.__module__ = "pixstep.ops"
    call.__doc__ = _doc(request)
    call.__signature__ = signature  # type: ignore[attr-defined]  # what help() shows
    return call


def _signature(request: type[Request]) -> inspect.Signature:
    kinds = inspect.Parameter
    found = [
        kinds(
            name, kinds.POSITIONAL_OR_KEYWORD if one.argument else kinds.KEYWORD_ONLY,
            default=kinds.empty if one.required and not one.machine else one.default,
            annotation=one.python,
        )
        for name, one in fields(request).items()
    ]  # fmt: skip
    for name in _BESIDE:
        if name not in fields(request):
            found.append(kinds(name, kinds.KEYWORD_ONLY, default=_defaults()[name]))
    return inspect.Signature(found, return_annotation="Result")


@cache
def _defaults() -> dict[str, Any]:
    return {key: one.default for key, one in inspect.signature(run).parameters.items()}


def _doc(request: type[Request]) -> str:
    about = inspect.getdoc(request) or ""
    rows = [f"    {name}: {_told(one)}" for name, one in fields(request).items()]
    return "\n".join([about, "", "Args:", *rows])


def _told(one: Field) -> str:
    text = one.about or one.kind.name
    if one.unless:  # as the option is told, which says no
        text = f"False: {text[:1].lower()}{text[1:]}"
    return text + (f" [default: {one.default_text}]" if one.default_text else "")
