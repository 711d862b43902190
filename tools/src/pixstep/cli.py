# SPDX-License-Identifier: MIT
"""The `pixstep` command. Exit status: 0 fine, 1 failed or warnings, 2 refused."""

import click

from pixstep import (
    __version__,
    cli_bench,
    cli_docs,
    cli_file,
    cli_home,
    cli_line,
    cli_move,
    cli_profile,
    cli_show,
    cli_sim,
)
from pixstep.cli_options import Group


@click.group(cls=Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="pixstep")
def main() -> None:
    """Line files to exact STEP edges: make, check, plan, simulate, prove."""


_groups = (
    cli_file,
    cli_profile,
    cli_line,
    cli_sim,
    cli_move,
    cli_home,
    cli_bench,
    cli_docs,
)
for command in (command for group in _groups for command in group.COMMANDS):
    main.add_command(command)
cli_line.line.add_command(cli_show.line_show)
