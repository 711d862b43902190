# SPDX-License-Identifier: MIT
"""The `pixstep` command. Exit status: 0 fine, 1 failed or warnings, 2 refused."""

import click

from pixstep import __version__
from pixstep.cli import (
    board,
    file,
    flash,
    home,
    late,
    line,
    move,
    profile,
    show,
    sim,
)
from pixstep.cli.options import Group


@click.group(cls=Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="pixstep")
def main() -> None:
    """Line files to exact STEP edges: make, check, plan, simulate."""


_groups = (
    file,
    profile,
    line,
    sim,
    move,
    home,
    board,
    flash,
    late,
)
for command in (command for group in _groups for command in group.COMMANDS):
    main.add_command(command)
line.line.add_command(show.line_show)
