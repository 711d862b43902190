# SPDX-License-Identifier: MIT
"""`pixstep completion`: the shell completes commands, options and files."""

import os
from dataclasses import dataclass
from pathlib import Path

import click
from click.shell_completion import get_completion_class

from pixstep import atomic
from pixstep.cli.command import OUTPUT, command
from pixstep.errors import UserError

_PROGRAM = "pixstep"
_VARIABLE = "_PIXSTEP_COMPLETE"


@dataclass(frozen=True)
class _Shell:
    """Where a shell looks for a program's completion, and what its user may have to add."""

    variable: str  # of the folder, by the XDG rules
    otherwise: str  # that folder below the home folder, where the variable is not set
    place: str
    hint: str = ""


_SHELLS = {
    "bash": _Shell("XDG_DATA_HOME", ".local/share", f"bash-completion/completions/{_PROGRAM}"),
    "zsh": _Shell(
        "XDG_DATA_HOME",
        ".local/share",
        f"zsh/site-functions/_{_PROGRAM}",
        "add to ~/.zshrc, before compinit: fpath+=({folder})",
    ),
    "fish": _Shell("XDG_CONFIG_HOME", ".config", f"fish/completions/{_PROGRAM}.fish"),
}


@command("completion")
@click.argument("shell", type=click.Choice(list(_SHELLS)), required=False)
@click.option("-o", "--output", type=OUTPUT, help="File to write.  [default: where SHELL looks]")
def completion(shell: str | None, output: Path | None) -> None:
    """Complete commands, options and files in the shell: install it.

    For bash, zsh or fish; without SHELL for the one that runs, by the variable SHELL. It works in
    the next shell that is opened. `-o -` prints it instead.
    """
    name = shell or _present()
    target = output or _place(name)
    completer = get_completion_class(name)
    if completer is None:
        raise UserError(f"{name}: the installed click completes nothing in this shell")
    script = completer(click.Group(), {}, _PROGRAM, _VARIABLE).source()
    atomic.write_text(target, script.strip() + "\n")
    if atomic.is_stdout(target):
        return
    click.echo(f"{target}: completion for {name}")
    if output is None and _SHELLS[name].hint:
        click.echo(_SHELLS[name].hint.format(folder=target.parent))


def _present() -> str:
    """Return the user's shell."""
    name = Path(os.environ.get("SHELL", "")).name
    if name not in _SHELLS:
        raise UserError(f"which shell? name one: {', '.join(_SHELLS)}")
    return name


def _place(name: str) -> Path:
    shell = _SHELLS[name]
    folder = os.environ.get(shell.variable)
    return (Path(folder) if folder else Path.home() / shell.otherwise) / shell.place
