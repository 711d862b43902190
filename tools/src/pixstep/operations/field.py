# SPDX-License-Identifier: MIT
"""What one field of a request is: said once, for every front end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

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
