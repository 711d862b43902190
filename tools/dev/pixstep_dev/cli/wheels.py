# SPDX-License-Identifier: MIT
"""`pixstep-dev wheels`: the packages that are installed without a clone."""

from pathlib import Path

import click

from pixstep import progress
from pixstep.cli.command import command
from pixstep_dev import wheels


@command("wheels")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    help="Folder for the wheels; those of the same names are replaced.",
)
@click.option(
    "--machine",
    type=click.Choice([*wheels.CROSS]),
    help="Build for this kind of processor by a cross compiler. [default: this machine's]",
)
def wheels_command(out: Path, machine: str | None) -> None:
    """Build the wheels of pixstep and of pixstep-sim, its simulator, from this tree."""
    with progress.shown("building") as show:
        made = wheels.build(out, machine, show)
    for path in made:
        click.echo(f"{path}: {path.stat().st_size / 1e6:.2f} MB")


COMMANDS = (wheels_command,)
