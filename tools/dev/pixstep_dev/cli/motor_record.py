# SPDX-License-Identifier: MIT
"""`pixstep-dev motor-record`: our motor record against recordings of the real one."""

import json
from pathlib import Path

import click

from pixstep.cli.command import FILE, Group
from pixstep_trials.motor_traces import verdict


@click.group("motor-record", cls=Group)
def motor_record() -> None:
    """Hold our motor record against recordings of the real one."""


@motor_record.command()
@click.argument("paths", metavar="FILE...", type=FILE, nargs=-1, required=True)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@click.pass_context
def replay(ctx: click.Context, paths: tuple[Path, ...], as_json: bool) -> None:
    """Replay traces: JSON lines, packed by xz where a name ends so.

    Prints how many are equal in commands, changes of DMOV and all fields, by kind, and the first
    difference of each other one. Exit status 1 unless all are equal.
    """
    judged = verdict.judge(paths)
    if as_json:
        click.echo(json.dumps(judged.to_dict(), indent=2))
    else:
        for line in judged.lines():
            click.echo(line)
    ctx.exit(1 if judged.differing else 0)


@motor_record.command()
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def figures(as_json: bool) -> None:
    """Measure how quick `pixstep ioc` is on this computer, with simulated boards: half a minute."""
    from pixstep_dev import motor_figures  # which the other commands do not need

    found = motor_figures.measure()
    if as_json:
        click.echo(json.dumps(vars(found), indent=2))
        return
    for line in found.lines():
        click.echo(line)


COMMANDS = (motor_record,)
