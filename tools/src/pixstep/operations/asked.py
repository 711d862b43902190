# SPDX-License-Identifier: MIT
"""What one field of a request is, and errors that speak of fields.

A field is said once, for every front end; each puts its own words on the errors.
"""

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pixstep import atomic
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.operations.kinds import Kind, OutFile, OutFolder

FromMachine = Callable[[Any], object]  # takes Facts; None: the file does not say it


@dataclass(frozen=True)
class Field:
    """What one field of a request is.

    `names` are its spellings on the command line, none for an argument; `machine` finds it in the
    machine file; `default_text` is what happens without it, where no value says that.
    """

    kind: Kind
    about: str
    name: str = ""
    names: tuple[str, ...] = ()
    argument: bool = False
    required: bool = False
    many: bool = False
    default: Any = None
    default_text: str | None = None
    machine: FromMachine | None = None
    variable: str | None = None  # of the environment
    shown: str | None = None  # what stands for the value in a help
    hidden: bool = False
    off: str | None = None  # the option that says no, of a flag
    alone: str | None = None  # the value of an option that stands without one
    unless: bool = False  # a flag that is yes unless its option is there

    @property
    def option(self) -> str:
        """The field as it is typed."""
        return self.shown or self.name if self.argument else max(self.names, key=len)

    @property
    def python(self) -> str:
        """What Python gives for it, as an annotation."""
        kind = f"Sequence[{self.kind.python}]" if self.many else self.kind.python
        return kind if self.required or self.many or self.default is not None else f"{kind} | None"

    @property
    def writes(self) -> bool:
        """True for a file or folder that the operation writes."""
        return isinstance(self.kind, (OutFile, OutFolder))


class AskedError(UserError):
    """A request that cannot be: `AskedError("{pixels} and {length}: a line has one of them")`.

    A name in braces that is no other value given here is a field. The text has the names of Python;
    `told` has a front end's. `cure` is what would do, after all else that is said.
    """

    def __init__(self, template: str, cure: str = "", **values: Any) -> None:
        self.cure = AskedText(cure, **values)
        super().__init__(AskedText(template + cure, **values))
        self.plain = AskedText(template, **values)

    def told(self, words: Mapping[str, str]) -> str:
        """Return the text with words for fields; a field without one keeps its name."""
        return self.plain.told(words)

    def cured(self, words: Mapping[str, str]) -> str:
        """Return what would do, in the same way."""
        return self.cure.told(words)


class AskedRefusedError(AskedError, RefusedError):
    """What a check refuses, and which field would let it pass."""


class FieldError(UserError):
    """A value of a request that does not fit; each front end says the field in its own words."""

    def __init__(self, field: Field, reason: str) -> None:
        super().__init__(AskedText("{name}: {reason}", name=field.name, reason=reason))
        self.field, self.reason = field, reason

    def __reduce__(self) -> tuple[Any, ...]:
        again, (kind, texts, _) = super().__reduce__()
        return again, (kind, texts, {})  # what a machine file gives a field stays in its process


class MissingError(FieldError):
    """A value that a request needs and that nothing says."""

    def __init__(self, field: Field) -> None:
        super().__init__(field, "is missing")


def refuse_outputs(named: Iterable[tuple[str, Path]]) -> None:
    """Refuse outputs that the rules forbid, or that share a file or a stream.

    The names are those of fields, or what a front end calls them.
    """
    seen: dict[str, str] = {}
    for name, path in named:
        stream = atomic.is_stdout(path)
        place = str(atomic.STDOUT) if stream else os.path.realpath(path)
        if place in seen and (stream or not path.is_char_device()):  # a device takes both
            both = f"{{{seen[place]}}} and {{{name}}}"
            raise AskedError(f"{{path}}: {both} are the same file", path=path)
        seen[place] = name
        atomic.refuse(path)
