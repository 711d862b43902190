# SPDX-License-Identifier: MIT
"""`pixstep-dev release`: all that is given away of a version, in one folder."""

from pathlib import Path

import click

from pixstep import progress
from pixstep.cli.command import command
from pixstep_dev import release


@command("release")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    help="Folder for the release; it must not exist, or be empty.",
)
def release_command(out: Path) -> None:
    """Make a release: wheels, images, the documents' site, checksums, a page of notes.

    Files of the clone must not differ from its commit, and docs/releases must have a page for the
    version.
    """
    with progress.shown("release") as show:
        made = release.make(out, show)
    for path in made:
        click.echo(f"{path}: {path.stat().st_size / 1e6:.2f} MB")


COMMANDS = (release_command,)
