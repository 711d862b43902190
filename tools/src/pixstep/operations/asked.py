# SPDX-License-Identifier: MIT
"""Errors that speak of a request's fields; each front end puts its own words on them."""

from collections.abc import Mapping
from typing import Any

from pixstep.errors import RefusedError, UserError
from pixstep.operations.field import Field


class AskedError(UserError):
    """A request that cannot be: `AskedError("{pixels} and {length}: a line has one of them")`.

    A name in braces that is no other value given here is a field. The text has the names of Python;
    `told` has a front end's. `cure` is what would do, after all else that is said.
    """

    def __init__(self, template: str, cure: str = "", **values: Any) -> None:
        self.template, self.cure, self.values = template, cure, values
        super().__init__(self.told({}) + self.cured({}))

    def told(self, names: Mapping[str, str]) -> str:
        """Return the text with names for fields; a field without one keeps its own."""
        return self.template.format_map(_Names({**names, **self.values}))

    def cured(self, names: Mapping[str, str]) -> str:
        """Return what would do, in the same way."""
        return self.cure.format_map(_Names({**names, **self.values}))


class AskedRefusedError(AskedError, RefusedError):
    """What a check refuses, and which field would let it pass."""


class _Names(dict[str, Any]):
    def __missing__(self, name: str) -> str:
        return name


class FieldError(UserError):
    """A value of a request that does not fit; each front end says the field in its own words."""

    def __init__(self, field: Field, reason: str) -> None:
        super().__init__(f"{field.name}: {reason}")
        self.field, self.reason = field, reason

    def __reduce__(self) -> tuple[Any, ...]:
        again, (kind, texts, _) = super().__reduce__()
        return again, (kind, texts, {})  # what a machine file gives a field stays in its process


class MissingError(FieldError):
    """A value that a request needs and that nothing says."""

    def __init__(self, field: Field) -> None:
        super().__init__(field, "is missing")
