# SPDX-License-Identifier: MIT
"""Errors that speak of a request's fields; each front end puts its own words on them."""

from collections.abc import Mapping
from typing import Any

from pixstep.errors import RefusedError, UserError


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
