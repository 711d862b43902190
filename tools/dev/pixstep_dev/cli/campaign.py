# SPDX-License-Identifier: MIT
"""`pixstep-dev campaign`: random valid lines on a simulated board, judged."""

from pathlib import Path
from typing import Any

import click

from pixstep import atomic, progress
from pixstep.board import boards
from pixstep.cli.command import OUTPUT, command
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep_dev.randomlines import campaign


@command("campaign")
@click.option("--lines", type=click.IntRange(min=1), default=200, show_default=True)
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--decode", type=click.Choice([SMOOTH, PLAIN]), multiple=True, help="Default: both.")
@click.option("--seed", type=int, default=1, show_default=True)
@click.option("--min-interval", type=click.IntRange(1), default=533, show_default=True)
@click.option("--axes", type=click.IntRange(1, 4), default=1, help="Lines at once, one an axis.")
@click.option("--serial-load", is_flag=True)
@click.option("-o", "--output", type=OUTPUT, help="JSON file to write.")
@click.pass_context
def campaign_command(
    ctx: click.Context, /, board: str, output: Path | None, **options: Any
) -> None:
    """Run random valid lines on a simulated board; exit status 0 only if every one passes."""
    plan = campaign.RandomLinesPlan(
        board=board,
        lines=options["lines"],
        decodes=options["decode"] or ("smooth", "plain"),
        seed=options["seed"],
        min_interval_ticks=options["min_interval"],
        axes=options["axes"],
        serial_load=options["serial_load"],
    )
    with progress.shown(f"{board} campaign") as show:
        outcome = campaign.run(plan, show)
    for row in outcome["results"]:
        worst = units.ticks_text(row["max_edge_error_ticks"])
        click.echo(
            f"{board} {row['decode']}: {row['passed']} of {row['lines']} lines pass, "
            f"{row['steps']} steps, worst edge error {worst} ticks, "
            f"worst rms {1000 * row['max_rms_edge_error_us']:.1f} ns"
        )
        for failure in row["failures"]:
            click.echo(f"  line {failure['index']}: {'; '.join(failure['reasons'])}")
    if output:
        atomic.write_json(output, outcome)
    ctx.exit(0 if outcome["verdict"] == "pass" else 1)


COMMANDS = (campaign_command,)
