# SPDX-License-Identifier: MIT
"""`pixstep-dev fuzz`: mutated bytes against frame parser, server and board, natively."""

import json
from dataclasses import asdict

import click

from pixstep import natives, progress
from pixstep.cli.command import Group
from pixstep.errors import UserError
from pixstep_dev.fuzzing import campaign, defects, fuzzer

_target = click.argument("target", type=click.Choice(fuzzer.TARGETS))


@click.group("fuzz", cls=Group)
def fuzz_group() -> None:
    """Fuzz the firmware's serial side by libFuzzer, under sanitizers.

    Targets: `server` is frame parser and Modbus server over a small model whose every reply is
    compared with a second implementation; `board` is the whole firmware on fake hardware.
    """


@fuzz_group.command()
@_target
@click.option("--executions", type=click.IntRange(min=0), default=0, help="End after so many.")
@click.option("--seconds", type=click.IntRange(min=0), default=0, help="End after so long.")
@click.option("--seed", type=click.IntRange(min=1), default=1, show_default=True)
@click.option("--grow", is_flag=True, help="Keep inputs that reach more in fuzz/corpus.")
@click.option("--record", is_flag=True, help="Write the figures to fuzz/CAMPAIGN.md.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@click.pass_context
def run(
    ctx: click.Context,
    target: str,
    executions: int,
    seconds: int,
    seed: int,
    grow: bool,
    record: bool,
    as_json: bool,
) -> None:
    """Fuzz a target, from the kept corpus on.

    Exit status 1 if anything is found.
    """
    if not executions and not seconds:
        raise UserError("say when to end: --executions N, --seconds N or both")
    limits = fuzzer.FuzzLimits(executions, seconds, seed)
    with progress.shown(f"fuzzing {target}") as show:
        outcome = campaign.run(target, limits, grow=grow, progress=show)
    if record:
        with progress.shown("counting lines"):
            path = natives.root() / "fuzz" / "CAMPAIGN.md"
            campaign.record(target, limits, outcome, path)
    if as_json:
        click.echo(json.dumps(asdict(outcome), indent=2, default=str))
    else:
        _say(target, outcome)
    ctx.exit(1 if outcome.finding else 0)


def _say(target: str, outcome: fuzzer.FuzzerOutcome) -> None:
    """Print what a run did."""
    click.echo(
        f"{target}: {outcome.executions:,} executions, {outcome.edges:,} of "
        f"{outcome.edges_known:,} edges, {outcome.inputs:,} inputs: "
        f"{outcome.finding or 'nothing found'}"
    )
    if outcome.artifact:
        click.echo(f"  the input: {outcome.artifact}")
        click.echo(f"  again: {campaign.program(target)} {outcome.artifact}")


@fuzz_group.command()
@click.option(
    "--executions",
    type=click.IntRange(min=1),
    default=3_000_000,
    show_default=True,
    help="At most, each.",
)
@click.pass_context
def prove(ctx: click.Context, executions: int) -> None:
    """Plant known defects; see that fuzzing finds each."""
    missed = 0
    for defect in defects.DEFECTS:
        outcome, kept = campaign.plant(defect, fuzzer.FuzzLimits(executions))
        missed += not outcome.finding
        new = max(0, outcome.executions - kept)
        found = outcome.finding or "NOT FOUND"
        click.echo(f"{defect.target}: {defect.about}: {found} ({new:,} executions)")
    click.echo(f"{len(defects.DEFECTS) - missed} of {len(defects.DEFECTS)} planted defects found")
    ctx.exit(1 if missed else 0)


COMMANDS = (fuzz_group,)
