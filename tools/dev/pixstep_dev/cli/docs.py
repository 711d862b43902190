# SPDX-License-Identifier: MIT
"""`pixstep-dev docs`: the generated tables of the documentation."""

import json
from collections.abc import Callable
from pathlib import Path

import click

from pixstep import progress
from pixstep.cli.command import FILE
from pixstep_dev import markdown
from pixstep_dev.docs import faults, files, front, parts, tables, wiring

_check = click.option("--check", type=FILE, help="Fail if the table in FILE is out of date.")
_write = click.option("--write", type=FILE, help="Rewrite the table in FILE between its markers.")


@click.group("docs")
def docs_group() -> None:
    """Tables generated from the firmware's own tables."""


@docs_group.command()
@click.option("--check", "action", flag_value="check", default=True, help="Say what differs.")
@click.option("--write", "action", flag_value="write", help="Rewrite outputs and pictures too.")
@click.argument("file", type=FILE)
@click.pass_context
def tutorial(ctx: click.Context, file: Path, action: str) -> None:
    """Walk a document: run its commands, compare what they print and draw with what it shows.

    Exit status 0 if all is as it says, 1 if not (or was not, with --write).
    """
    from pixstep_dev.tutorial import check as walk  # matplotlib takes a second to load

    with progress.shown("walking") as show:
        complaints = (walk.refresh if action == "write" else walk.check)(file, show)
    for text in complaints:
        click.echo(text, err=True)
    if complaints and action == "write":
        click.echo(f"{file}: rewritten where it can be; look at it, shorten it, check it")
    ctx.exit(1 if complaints else 0)


@docs_group.command()
@click.pass_context
def blocks(ctx: click.Context) -> None:
    """Count the commands of all documents: those that tests run, and what the others need.

    Exit status 1 for a block that does not say what it is.
    """
    from pixstep import natives
    from pixstep_dev.tutorial import blocks as of_documents

    found = list(of_documents.survey(natives.root()))
    for text in of_documents.table(found):
        click.echo(text)
    complaints = [text for one in found for text in one.complaints]
    for text in complaints:
        click.echo(text, err=True)
    ctx.exit(1 if complaints else 0)


def _deliver(
    ctx: click.Context, name: str, content: str, check: Path | None, write: Path | None
) -> None:
    """Print, check or write one generated part."""
    if check:
        good = markdown.check(check, name, content)
        if not good:
            click.echo(
                f"{check}: the {name} table is out of date: "
                f"pixstep-dev docs {name} --write {check}",
                err=True,
            )
        ctx.exit(0 if good else 1)
    if write:
        changed = markdown.write(write, name, content)
        click.echo(f"{write}: {'rewritten' if changed else 'up to date'}")
        return
    click.echo(markdown.marked(name, content), nl=False)


def _add_table(name: str, make: Callable[[], str], text: str) -> None:
    """Add the command that delivers one generated part."""

    @docs_group.command(name, help=text)
    @_check
    @_write
    @click.pass_context
    def table(ctx: click.Context, check: Path | None, write: Path | None) -> None:
        _deliver(ctx, name, make(), check, write)


_add_table(
    "protocol", tables.protocol, "Register map, faults and line errors, for docs/PROTOCOL.md."
)
_add_table("wiring", tables.wiring, "Pin tables of the boards, for docs/WIRING.md.")
_add_table("rates", front.rates, "Highest rates of each board, for README.md.")
_add_table("drivers", parts.drivers, "Drivers' pulse widths and microsteps, for docs/WIRING.md.")
_add_table("shields", parts.shields, "Shields beside pixstep's pins, for docs/WIRING.md.")
_add_table("flashing", tables.flashing, "avrdude's command lines, for docs/FLASHING.md.")
_add_table(
    "files",
    files.files,
    "Meanings, messages, bytes of a CSB and listings, for docs/FILES.md.",
)
_add_table(
    "faults",
    faults.faults,
    "Faults and line errors with cause, cure and test, for docs/FAULTS.md.",
)


def _epics() -> str:
    from pixstep_dev.docs import epics  # which other documents do not need

    return epics.epics()


_add_table("epics", _epics, "The PVs of motors and of their server, for docs/EPICS.md.")


def _grammar() -> str:
    from pixstep_dev.docs import grammar  # loads every command

    return grammar.grammar()


_add_table("grammar", _grammar, "All commands and their options, for docs/COMMANDS.md.")


def _operations() -> str:
    from pixstep_dev.docs import operations  # loads every operation

    return operations.operations()


_add_table(
    "operations",
    _operations,
    "All operations with their fields and results, for docs/OPERATIONS.md.",
)


@docs_group.command("drawings")
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option("--write", is_flag=True, help="Rewrite what differs.")
@click.pass_context
def drawings_command(ctx: click.Context, folder: Path, write: bool) -> None:
    """Compare the wiring drawings in FOLDER (docs/wiring) with the boards' pins.

    Exit status 0 if all are up to date (or were rewritten), else 1.
    """
    for path in wiring.write(folder) if write else ():
        click.echo(f"{path}: rewritten")
    stale = wiring.stale(folder)
    for path in stale:
        click.echo(f"{path}: out of date: pixstep-dev docs drawings {folder} --write", err=True)
    ctx.exit(1 if stale else 0)


@docs_group.command("comparison")
@click.option("--check", type=FILE, help="Fail if the picture in FILE is out of date.")
@click.option("--write", type=FILE, help="Write the picture into FILE.")
@click.pass_context
def comparison_command(ctx: click.Context, check: Path | None, write: Path | None) -> None:
    """Print the picture of README.md, other step generators beside pixstep, as SVG."""
    made = front.comparison()
    if write:
        markdown.replace(write, made)
    elif check:
        good = check.is_file() and check.read_text(encoding="utf-8") == made
        if not good:
            click.echo(
                f"{check}: out of date: pixstep-dev docs comparison --write {check}", err=True
            )
        ctx.exit(0 if good else 1)
    else:
        click.echo(made, nl=False)


@docs_group.command("schemas")
def schemas_command() -> None:
    """Print the JSON schemas of all results, for docs/schemas.json."""
    from pixstep.operations import catalog  # loads every operation

    click.echo(json.dumps(catalog.all_schemas(), indent=1, sort_keys=True))


def _commands() -> str:
    from pixstep_dev.docs import commands  # takes a while to load

    with progress.shown("commands") as show:
        return commands.commands(show)


_add_table(
    "commands",
    _commands,
    "What each command does in each state, tried on the simulated board, for docs/PROTOCOL.md.",
)


def _conformance() -> str:
    from pixstep_dev.robustness.clients import conformance  # pymodbus takes a while to load

    with progress.shown("clients") as show:
        return conformance.table(conformance.run(progress=show))


_add_table(
    "conformance",
    _conformance,
    "What mbpoll, libmodbus and pymodbus get from the simulated boards, for docs/PROTOCOL.md.",
)


def _api() -> str:
    from pixstep_dev.docs import api  # needs griffe, which only this part does

    return api.api()


_add_table("api", _api, "The interface for programs, from its docstrings, for docs/API.md.")

COMMANDS = (docs_group,)
