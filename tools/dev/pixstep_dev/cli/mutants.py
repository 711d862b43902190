# SPDX-License-Identifier: MIT
"""`pixstep-dev mutants`: small changes of the firmware that the tests must see."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pixstep import progress
from pixstep.cli.command import FILE
from pixstep_dev.mutants import stages

if TYPE_CHECKING:
    from pixstep_dev.mutants import campaign, judged


@click.command()
@click.option(
    "--count", type=click.IntRange(min=1), default=400, show_default=True, help="Mutants."
)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True)
@click.option(
    "--only", default="", metavar="PATTERN", help="Draw from files whose path matches a pattern."
)
@click.option("--assembly", is_flag=True, help="Of the assembly sources, not of C.")
@click.option(
    "--last",
    type=click.Choice(stages.NAMES),
    default=stages.NAMES[-1],
    show_default=True,
    help="The last kind of test that is tried.",
)
@click.option(
    "--jobs", type=click.IntRange(min=1), default=2, show_default=True, help="Mutants at a time."
)
@click.option(
    "--again", type=FILE, help="Try only the survivors of FILE, which --json has printed."
)
@click.option("--json", "as_json", is_flag=True, help="Print every mutant and its fate as JSON.")
@click.option("--write", type=FILE, help="Rewrite the figures in FILE (docs/MUTANTS.md).")
@click.pass_context
def mutants(
    ctx: click.Context,
    count: int,
    seed: int,
    only: str,
    assembly: bool,
    last: str,
    jobs: int,
    again: Path | None,
    as_json: bool,
    write: Path | None,
) -> None:
    """Change the firmware in small ways; see which tests notice.

    Each mutant changes one operator, constant, condition, statement or returned value of
    firmware/core or firmware/app, in a copy; with --assembly one instruction of an assembly
    source. It is tried by the native suites, then by the suites on AVR, pixstep-explore, and the
    tests on all images, until one of them fails.

    Exit status 0 only if every survivor is judged (tools/dev/pixstep_dev/data/mutants.toml).
    """
    from pixstep_dev import markdown
    from pixstep_dev.mutants import campaign, judged, record

    judgements = judged.read()
    kept = campaign.read(again) if again else None
    names = stages.NAMES[: stages.NAMES.index(last) + 1]
    with progress.shown(f"{count} mutants") as show:
        plan = campaign.MutantsPlan(count, seed, names, jobs, only, assembly)
        outcome = campaign.run(plan, show, kept, lambda one: judged.equivalent(judgements, one))
    if write:
        markdown.write(write, record.NAME, record.markdown(outcome, judgements))
    if as_json:
        click.echo(json.dumps(campaign.facts(outcome), indent=1))
    else:
        _say(outcome, judgements)
    ctx.exit(1 if judged.score(outcome, judgements).open else 0)


def _say(outcome: campaign.MutantsOutcome, judgements: judged.Judgements) -> None:
    """Print the figures, and the survivors that nobody has judged."""
    from pixstep_dev.mutants import judged, record

    click.echo(record.summary(outcome, judgements))
    for fate, number in sorted(outcome.counts().items()):
        click.echo(f"  {number:>5,} {fate}")
    for trial in outcome.survivors:
        if not judged.of(judgements, trial.mutant):
            mutant = trial.mutant
            click.echo(f"FAIL: {mutant.file}:{mutant.line}: {mutant.was}")
            click.echo(f"      survives as {mutant.becomes}")


COMMANDS = (mutants,)
