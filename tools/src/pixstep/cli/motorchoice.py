# SPDX-License-Identifier: MIT
"""What a command line says of motors, read before click asks for defaults: they depend on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import click

from pixstep.operations.motor_choice import TABLE_AXES, Named

_IN_A_ROW = "axis"  # the parameter of commands whose lines go to axes in a row, or to those given
_AS_A_SET = "axes"  # that of commands that do the same with each axis


def read(ctx: click.Context, args: Sequence[str]) -> Named | None:
    """Return what a command line says of axes, boards and lines; what is wrong is left out.

    None if it only asks for help. The values are read here before click asks for defaults, because
    those depend on them.
    """
    params = {param.name or "": param for param in ctx.command.params}
    try:
        words, _, _ = ctx.command.make_parser(ctx).parse_args(list(args))
    except click.UsageError:  # click will say so itself
        words = {}
    asks = ctx.command.get_help_option(ctx)
    if asks and words.get(asks.name or ""):
        return None
    table = _IN_A_ROW in params and bool(getattr(params.get("play"), "multiple", False))
    found = Named(lines=TABLE_AXES if table else _lines(params, words), table=table)
    found.machine = _text_of(words, "machine") or params["machine"].resolve_envvar_value(ctx)
    if params["motor"].expose_value:
        found.own = _text_of(words, "motor")
    else:
        found.motors = _texts(words.get("motor"))
    for name in (_IN_A_ROW, _AS_A_SET):
        if name in params and getattr(params[name], "opts", []) == ["--axis"]:
            found.axes = tuple(_values(ctx, params[name], words))
    for name in ("unit", "units"):
        if name in params:
            found.units = tuple(_values(ctx, params[name], words))
    return found


def _lines(params: dict[str, click.Parameter], words: dict[str, object]) -> int:
    if _IN_A_ROW not in params:
        return 0
    files = words.get("csv")
    return len(files) if isinstance(files, (list, tuple)) else 1


def _texts(value: object) -> tuple[str, ...]:
    several = value if isinstance(value, (list, tuple)) else (value,)
    return tuple(one for one in several if isinstance(one, str))


def _text_of(words: dict[str, object], name: str) -> str | None:
    return next(iter(_texts(words.get(name))), None)


def _values(ctx: click.Context, param: click.Parameter, words: dict[str, object]) -> Iterator[int]:
    """Yield the numbers that a parameter has on the command line."""
    if not param.name or not isinstance(words.get(param.name), (str, list, tuple)):
        return
    try:
        value = param.type_cast_value(ctx, words[param.name])
    except click.BadParameter:
        return
    yield from (one for one in (value if isinstance(value, tuple) else (value,)) if one is not None)
