# SPDX-License-Identifier: MIT
"""`pixstep-dev site`: the documents as pages with search."""

import time
from pathlib import Path

import click

from pixstep.cli.command import command
from pixstep_dev import site


@command("site")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    help="Folder for the pages; an earlier site there is replaced.",
)
def site_command(out: Path) -> None:
    """Build the documents as a site that is read without network, with search.

    A link or an anchor that leads nowhere, or a document that the contents do not name, is an
    error.
    """
    began = time.monotonic()
    pages = site.build(out)
    click.echo(f"{out / 'index.html'}: {pages} pages, {time.monotonic() - began:.0f} s")


COMMANDS = (site_command,)
