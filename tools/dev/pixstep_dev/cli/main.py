# SPDX-License-Identifier: MIT
"""The `pixstep-dev` command. Exit status: 0 fine, 1 a promise broken, 2 refused."""

import click

from pixstep.cli.command import Group
from pixstep.version import __version__
from pixstep_dev.cli import (
    bench,
    campaign,
    docs,
    fuzz,
    guarantee,
    jobs,
    motor_record,
    mutants,
    release,
    robustness,
    site,
    wheels,
)


@click.group(cls=Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="pixstep-dev")
def main() -> None:
    """Prove pixstep: measure, inject faults, fuzz, mutate, keep the documents true."""


for group in (
    bench,
    guarantee,
    campaign,
    robustness,
    jobs,
    fuzz,
    motor_record,
    mutants,
    docs,
    site,
    wheels,
    release,
):
    for command in group.COMMANDS:
        main.add_command(command)
