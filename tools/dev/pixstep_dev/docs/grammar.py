# SPDX-License-Identifier: MIT
"""The generated part of docs/COMMANDS.md: the commands with their options, and who has which."""

from collections.abc import Iterator

import click

from pixstep.cli.command import OutFileType, OutFolderType
from pixstep.cli.main import main
from pixstep_dev.markdown import table

_PORT = {"--port", "--baud", "--parity", "--timeout", "--unit"}
_SHARED = (
    ("--decode", "what the motor is: smooth or plain"),
    ("--clock-hz", "the frequency of the pixel clock's edges: 30, 29.97 or 30000/1001"),
    ("--pixel-hz", "the frequency of pixels: that of the clock, where a pixel is one edge"),
    ("--divider", "the clock edges of a pixel"),
    ("--backlash", "steps of play, of a smooth line"),
    ("--board", "the board: its clock, its limits, its image"),
    ("--axis", "the axis, its motor in the machine file; of several files the first, or one each"),
    ("--line", "which line of a file of many"),
    ("--raw", "take every row after a CSV header as a value"),
    ("--lenient", "accept LF and other old quirks, each with a note"),
    ("-o", "the file to write; `-` is the standard output"),
    ("--out", "the folder for the results of a run"),
    ("--plot", "draw: into the folder of `--out`, else into a file"),
    ("--force", "replace files that exist"),
    ("--no-check", "leave the host's check of a line out"),
    ("--details", "print every interrupt's figures too"),
    ("--json", "facts for programs, with `schema`"),
)


def grammar() -> str:
    """Return the generated part as Markdown."""
    commands = dict(_commands())
    rows = [(f"`{name}`", *_cells(command)) for name, command in sorted(commands.items())]
    parts = ["### Commands\n", table(("command", "takes", "writes", "options of its own"), rows)]
    shared = [(f"`{name}`", about, _having(commands, name)) for name, about in _SHARED]
    parts += ["\n### Options that mean the same everywhere\n"]
    parts += [table(("option", "means", "commands"), shared)]
    return "\n".join(parts) + "\n"


def _commands(
    command: click.Command = main, words: str = ""
) -> Iterator[tuple[str, click.Command]]:
    """Yield every command with the words that call it."""
    if not isinstance(command, click.Group):
        yield words, command
        return
    context = click.Context(command)
    for name in command.list_commands(context):
        found = command.get_command(context, name)
        if found and name != "bench":  # which belongs to pixstep-dev
            yield from _commands(found, f"{words} {name}".strip())


def _options(command: click.Command) -> list[click.Option]:
    options = (param for param in command.params if isinstance(param, click.Option))
    return [option for option in options if not option.hidden]


def _cells(command: click.Command) -> tuple[str, str, str]:
    """Return what a command takes, what it writes, and the options that no table explains."""
    arguments = [param for param in command.params if isinstance(param, click.Argument)]
    takes = [_argument(param) for param in arguments if not isinstance(param.type, OutFileType)]
    names = {name for option in _options(command) for name in option.opts}
    takes += ["a port"] if names >= _PORT else []
    writes = [_argument(param) for param in arguments if isinstance(param.type, OutFileType)]
    writes += [f"`{_short(option)}`" for option in _options(command) if _writes(option)]
    known = {name for name, _ in _SHARED} | _PORT
    own = [_short(option) for option in _options(command) if not known & {*option.opts}]
    return ", ".join(takes), ", ".join(writes), " ".join(f"`{name}`" for name in own)


def _argument(param: click.Argument) -> str:
    return f"`{param.human_readable_name.strip('[].')}`"


def _writes(option: click.Option) -> bool:
    return isinstance(option.type, (OutFileType, OutFolderType))


def _short(option: click.Option) -> str:
    """Return the name to know an option by: of --ask/--no-ask the one that changes anything."""
    if option.secondary_opts and option.default:
        return option.secondary_opts[0]
    return "--plot" if "--plot" in option.opts else min(option.opts, key=len)


def _having(commands: dict[str, click.Command], name: str) -> str:
    """Return which commands have an option; if more than half have it, which have not."""
    have = [one for one in sorted(commands) if any(name in o.opts for o in _options(commands[one]))]
    if 2 * len(have) <= len(commands):
        return ", ".join(f"`{one}`" for one in have)
    lack = [one for one in sorted(commands) if one not in have]
    return "all but " + ", ".join(f"`{one}`" for one in lack)
