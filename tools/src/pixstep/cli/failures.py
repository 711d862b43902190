# SPDX-License-Identifier: MIT
"""What ends a command early, as one line on the error stream.

The line names the option or the file, the value and what would be right. Nothing of click's own
form is left: its usage takes several lines, so a hint at --help stands for it.
"""

import contextlib
import os

import click

from pixstep.errors import one_line, told


class OptionNames(dict[str, str]):
    """Options by the fields of a command; what is no field is an option of its own name."""

    def __missing__(self, name: str) -> str:
        word = name.islower() and name.isidentifier()
        return f"--{name.replace('_', '-')}" if word else name


def complain(error: Exception | str) -> None:
    """Print an error as its one line, if its stream is still there: a closed terminal is not."""
    with contextlib.suppress(OSError):
        click.echo(f"pixstep: {one_line(told(error, OptionNames()))}", err=True)


def complain_of_system(error: OSError) -> None:
    """Print what the system refuses."""
    named = f"{os.fsdecode(error.filename)}: " if error.filename is not None else ""
    complain(f"{named}{error.strerror or error}")


def complain_of_usage(error: click.UsageError) -> None:
    """Print what is wrong with a command line, and how to see what is right."""
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        error.show()  # nothing is wrong yet: the help is the answer
        return
    hint = f" (`{error.ctx.command_path} --help` shows what is right)" if error.ctx else ""
    complain(f"{one_line(said(error))}{hint}")


def said(error: click.UsageError) -> str:
    """Return what is wrong with a command line, without click's words around it."""
    if isinstance(error, click.MissingParameter):
        return f"{_named(error)} is missing{_choices(error.param)}"
    text = error.message.strip().removesuffix(".")
    if isinstance(error, click.BadParameter):
        return f"{_named(error)}: {text}{_range(error, text)}"
    close = getattr(error, "possibilities", None)
    likely = f": did you mean {' or '.join(close)}?" if close else ""
    return f"{text[:1].lower()}{text[1:]}{likely}"


def _named(error: click.BadParameter) -> str:
    """Return the option or argument that is meant, as it is typed."""
    if isinstance(error.param, click.Option):
        return max(error.param.opts, key=len)
    if error.param is not None:
        return error.param.human_readable_name
    hint = error.param_hint
    return hint if isinstance(hint, str) else " or ".join(hint or ("the command",))


def _choices(param: click.Parameter | None) -> str:
    if param is None or not isinstance(param.type, click.Choice):
        return ""
    return f": one of {', '.join(map(str, param.type.choices))}"


def _range(error: click.BadParameter, text: str) -> str:
    """Return the range of a number, where click says only that a text is no number."""
    kind = error.param.type if error.param else None
    if not isinstance(kind, (click.IntRange, click.FloatRange)) or "not a valid" not in text:
        return ""
    low, high = kind.min, kind.max
    if low is not None and high is not None:
        return f": expected {low} to {high}"
    return f": expected {low} or more" if low is not None else ""
