# SPDX-License-Identifier: MIT
"""The classes that all commands are made of: their files, their errors, their exit status."""

import errno
import importlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from pathlib import Path
from typing import Any, NamedTuple

import click
from click.shell_completion import CompletionItem

from pixstep import atomic, signals
from pixstep.cli import process
from pixstep.cli.examples import EXAMPLES
from pixstep.cli.failures import complain, complain_of_system, complain_of_usage
from pixstep.errors import MISUSE, PlainError, UserError
from pixstep.lazy import missing_package, require_package
from pixstep.operations.asked import refuse_outputs

PICTURES = (".png", ".svg", ".pdf")
FILE = click.Path(path_type=Path, dir_okay=False)


class OutFileType(click.Path[Path]):
    """A file that a command writes; "-" is the standard output."""

    def __init__(self, *, folder: bool = False) -> None:
        super().__init__(path_type=Path, dir_okay=folder, allow_dash=True)


class OutPictureType(OutFileType):
    """A drawing that a command writes; its name says the format, a stream gets PNG."""

    def convert(
        self,
        value: str | os.PathLike[str],
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Path:
        """Refuse a name that says no format."""
        require_package("matplotlib")  # before anything else is done
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        if path.suffix.lower() not in PICTURES and not atomic.is_stream(path):
            raise UserError(f"{path}: a drawing ends with {', '.join(PICTURES)}")
        return path


class OutFolderType(click.Path[Path]):
    """A folder for the results of a run."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, file_okay=False)


OUTPUT = OutFileType()
PICTURE = OutPictureType()
OUTPUT_OR_FOLDER = OutFileType(folder=True)
FOLDER = OutFolderType()
_FORCE = "force"


class Command(click.Command):
    """A command whose outputs replace nothing unless --force says so, and its inputs never.

    Every command that writes files has --force by itself.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        if any(isinstance(param.type, (OutFileType, OutFolderType)) for param in self.params):
            self.params.append(
                click.Option(
                    ["--force"],
                    is_flag=True,
                    expose_value=False,
                    callback=_note_force,
                    help="Replace files that exist.",
                )
            )

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples; they are not wrapped, so that they can be copied."""
        super().format_epilog(ctx, formatter)
        program, _, name = ctx.command_path.partition(" ")
        if name in EXAMPLES:
            with formatter.section("Examples"):
                for example in EXAMPLES[name]:
                    formatter.write(f"{'':{formatter.current_indent}}{program} {example}\n")

    def invoke(self, ctx: click.Context) -> object:
        """Run the command under the rules for its files."""
        named = list(_paths(ctx, OutFileType))
        inputs = tuple(path for _, path in _paths(ctx, click.Path, _is_input))
        with atomic.rules(atomic.WriteRules(ctx.meta.get(_FORCE, False), inputs)):
            _refuse_outputs(ctx, named)
            try:
                return super().invoke(ctx)
            except ModuleNotFoundError as error:
                raise missing_package(error) or error from None


class LazyCommand(NamedTuple):
    """A command that is imported when it is called, so that help and completion are quick."""

    place: str  # module:name
    about: str  # the first sentence of its help


class _Commands(MutableMapping[str, click.Command]):
    """The commands of a group by name; those that come late are imported when looked up."""

    def __init__(self, late: Mapping[str, LazyCommand]) -> None:
        self.late = late
        self._loaded: dict[str, click.Command] = {}

    def __getitem__(self, name: str) -> click.Command:
        if name not in self._loaded:
            late = self.late[name]
            module, _, attribute = late.place.partition(":")
            found = getattr(importlib.import_module(module), attribute)
            if isinstance(found, type):  # an operation: its command is made of it
                maker = importlib.import_module("pixstep.cli.from_operation")
                found = maker.command_of(found)
            self._loaded[name] = found
        return self._loaded[name]

    def __setitem__(self, name: str, new: click.Command) -> None:
        self._loaded[name] = new

    def __delitem__(self, name: str) -> None:
        del self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter({**self.late, **self._loaded})

    def __len__(self) -> int:
        return len({**self.late, **self._loaded})

    def about(self, name: str) -> str:
        """Return the first sentence of a command's help, without an import where that can be."""
        return self.late[name].about if name in self.late else self[name].get_short_help_str(500)


class Group(click.Group):
    """Turns what ends a command early into one line and an exit status.

    A PlainError has its own; a wrong command line and what the system refuses are misuse; Ctrl-C,
    SIGTERM and SIGHUP are 128 and the signal's number.
    """

    command_class = Command
    group_class = type
    commands: _Commands

    def __init__(
        self, *arguments: Any, late: Mapping[str, LazyCommand] | None = None, **options: Any
    ) -> None:
        super().__init__(*arguments, **options)
        early = self.commands
        self.commands = _Commands(late or {})
        self.commands.update(early)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        rows = [(name, self.commands.about(name)) for name in self.list_commands(ctx)]
        if rows:
            with formatter.section("Commands"):
                formatter.write_dl(rows)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete the name of a command without importing any."""
        found = [
            CompletionItem(name, help=self.commands.about(name))
            for name in self.list_commands(ctx)
            if name.startswith(incomplete)
        ]
        return found + click.Command.shell_complete(self, ctx, incomplete)

    def main(self, *arguments: Any, **options: Any) -> Any:  # as click's own, which is overloaded
        """Run the command line; SIGTERM and SIGHUP end it as Ctrl-C does."""
        process.prepare()
        try:
            with signals.caught():
                return super().main(*arguments, **options)
        except OSError as error:  # of what click prints by itself, as --help
            complain_of_system(error)
            sys.exit(MISUSE)
        finally:
            _let_go_of_streams()

    def make_context(self, *arguments: Any, **options: Any) -> click.Context:
        """Read the words of this group; its own mistakes have no group above that tells of them."""
        try:
            return super().make_context(*arguments, **options)
        except click.UsageError as error:
            if error.ctx is None or error.ctx.parent is not None:
                raise
            complain_of_usage(error)
            sys.exit(error.exit_code)

    def invoke(self, ctx: click.Context) -> object:
        """Run a command."""
        try:
            result = super().invoke(ctx)
            if sys.stdout:
                sys.stdout.flush()  # a full disk is told of here, not when Python ends
            return result
        except click.UsageError as error:
            complain_of_usage(error)
            return ctx.exit(error.exit_code)
        except PlainError as error:
            complain(error)
            return ctx.exit(error.status)
        except KeyboardInterrupt as error:
            complain(f"ended by {signals.name(error)}")
            return ctx.exit(signals.status(error))
        except OSError as error:
            if error.errno == errno.EPIPE:  # click ends the command in order
                raise
            complain_of_system(error)
            return ctx.exit(MISUSE)
        except click.Abort as error:  # at a prompt, for which click takes a KeyboardInterrupt
            ended = error.__context__
            if not isinstance(ended, KeyboardInterrupt):
                raise
            complain(f"ended by {signals.name(ended)}")
            return ctx.exit(signals.status(ended))


def command(name: str, **options: Any) -> Callable[[Callable[..., Any]], Command]:
    """Return what makes a command of a function."""
    return click.command(name, cls=Command, **options)


def group(name: str, **options: Any) -> Callable[[Callable[..., Any]], Group]:
    """Return what makes a group of commands of a function."""
    return click.group(name, cls=Group, **options)


def _let_go_of_streams() -> None:
    """Drop what a full disk or a closed terminal does not take.

    Python would try to write that once more when it ends, fail, and exit with a status of its own.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        try:
            if stream:
                stream.flush()
        except OSError:
            setattr(sys, name, None)


def _note_force(ctx: click.Context, _param: click.Parameter, value: bool) -> None:
    ctx.meta[_FORCE] = value


def _is_input(param: click.Parameter) -> bool:
    return not isinstance(param.type, (OutFileType, OutFolderType))


def _paths(
    ctx: click.Context,
    kind: type[click.Path[Path]],
    wanted: Callable[[click.Parameter], bool] = lambda _: True,
) -> Iterator[tuple[str, Path]]:
    """Yield the paths given for parameters of a type, with the parameter's name."""
    for param in ctx.command.params:
        if isinstance(param.type, kind) and wanted(param):
            value = ctx.params.get(param.name)
            values = value if isinstance(value, tuple) else (value,)
            yield from ((_name(param), path) for path in values if path is not None)


def _name(param: click.Parameter) -> str:
    return (
        min(param.opts, key=len) if isinstance(param, click.Option) else param.human_readable_name
    )


def _refuse_outputs(ctx: click.Context, named: list[tuple[str, Path]]) -> None:
    """Refuse outputs that cannot be written; each with its option."""
    if ctx.params.get("as_json") and any(atomic.is_stdout(path) for _, path in named):
        raise UserError("--json and the output both go to the standard output: name a file")
    refuse_outputs(named)
