# SPDX-License-Identifier: MIT
"""Which values of a command line come from the machine file, for what is told of them."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

if TYPE_CHECKING:
    from pixstep.machine.files import MachineFile
    from pixstep.operations.facts import Facts

_FACTS = "pixstep.machine"
# A folder that only has its name by the file; a letter; a word that texts have anyhow.
_NOT_NAMED = ("out", "parity", "decode")


def hold(ctx: click.Context, facts: Facts) -> None:
    """Let what is told of a command line know the facts of its request."""
    ctx.meta[_FACTS] = facts


def told(ctx: click.Context | None) -> dict[str, str | None]:
    """Return the machine file that gave a command a default, for its JSON; None if none did.

    A command that no file could give any has nothing to tell.
    """
    if ctx is None or _FACTS not in ctx.meta:
        return {}
    machine = _used(ctx)
    return {"machine": str(machine.path) if machine else None}


def _used(ctx: click.Context) -> MachineFile | None:
    facts: Facts | None = ctx.meta.get(_FACTS)
    return None if facts is None else facts.used


def by_machine(ctx: click.Context, name: str) -> bool:
    """True if the value of a parameter comes from the machine file."""
    return ctx.get_parameter_source(name) == ParameterSource.DEFAULT_MAP


def origin(ctx: click.Context, text: str | None = None) -> str:
    """Return ` (... from machine.toml)` for defaults of the file that a text names, else "".

    Without a text something of the file is meant anyhow.
    """
    machine = _used(ctx)
    if machine is None or str(machine.path) in (text or ""):
        return ""
    if text is None:
        return f" (from {machine.path})"
    named = [
        _option(param)
        for param in ctx.command.params
        if by_machine(ctx, param.name or "") and _names(text, param, ctx.params.get(param.name))
    ]
    return f" ({', '.join(named)} from {machine.path})" if named else ""


def _option(param: click.Parameter) -> str:
    return max(param.opts, key=len)


def _names(text: str, param: click.Parameter, value: object) -> bool:
    """True if a text has a value of a parameter; of a number beside the parameter's name."""
    word = (param.name or "").removesuffix("s")
    values = value if isinstance(value, tuple) else (value,)
    return word not in _NOT_NAMED and any(
        re.search(_pattern(word, one), text) for one in values if one is not None
    )


def _pattern(word: str, value: object) -> str:
    """Return what finds a value in a text as a word of its own."""
    if isinstance(value, Fraction):
        return rf"(?<![\w.]){re.escape(f'{float(value):.10g}')} Hz"
    if isinstance(value, int):
        return rf"\b{word}s?\W+{value}\b(?!\.)|(?<![\w.]){value} {word}s?\b"
    return rf"(?<![\w./-]){re.escape(str(getattr(value, 'text', value)))}(?![\w/-])"
