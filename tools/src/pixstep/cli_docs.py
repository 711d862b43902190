# SPDX-License-Identifier: MIT
"""`pixstep docs` and `pixstep timing`: the generated tables of the documentation."""

import json

import click
from rich.console import Console

from pixstep import docs, progress, timing
from pixstep.cli_options import FILE

_check = click.option("--check", type=FILE, help="Fail if the table in FILE is out of date.")
_write = click.option("--write", type=FILE, help="Rewrite the table in FILE between its markers.")


@click.group("docs")
def docs_group() -> None:
    """Tables generated from the firmware's own tables."""


@docs_group.command()
@_check
@_write
@click.pass_context
def protocol(ctx, check, write):
    """Register map, faults and line errors, for docs/PROTOCOL.md."""
    _deliver(ctx, "protocol", docs.protocol(), check, write)


@docs_group.command()
@_check
@_write
@click.pass_context
def wiring(ctx, check, write):
    """Pin tables of the boards, for docs/WIRING.md."""
    _deliver(ctx, "wiring", docs.wiring(), check, write)


@click.command("timing")
@click.option("--json", "as_json", is_flag=True, help="Machine-readable output.")
@click.option("--quick", is_flag=True, help="Skip the search for the highest rates.")
@_write
def timing_command(as_json, quick, write):
    """Measure handlers, decoding, highest clean rates and sizes, for docs/TIMING.md."""
    with progress.shown("measuring") as show:
        measured = timing.measure(show, rates=not quick)
    if write:
        docs.write(write, "timing", timing.markdown(measured))
        click.echo(f"{write}: written", err=True)
    if as_json:
        click.echo(json.dumps(measured, indent=2))
    elif not write:
        Console(highlight=False).print(timing.markdown(measured), markup=False, soft_wrap=True)


def _deliver(ctx: click.Context, name: str, content: str, check, write) -> None:
    """Print, check or write one generated part."""
    if check:
        good = docs.check(check, name, content)
        if not good:
            click.echo(
                f"{check}: the {name} table is out of date: pixstep docs {name} --write {check}",
                err=True,
            )
        ctx.exit(0 if good else 1)
    if write:
        changed = docs.write(write, name, content)
        click.echo(f"{write}: {'rewritten' if changed else 'up to date'}")
        return
    click.echo(docs.marked(name, content), nl=False)


COMMANDS = (docs_group, timing_command)
