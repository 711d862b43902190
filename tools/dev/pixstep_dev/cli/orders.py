# SPDX-License-Identifier: MIT
"""`pixstep-dev robustness orders`: commands in every order, at any cycle."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pixstep import progress
from pixstep.board import boards
from pixstep.cli.command import FILE
from pixstep.errors import UserError
from pixstep_dev.cli.findings import json_option, seed_option

if TYPE_CHECKING:
    from pixstep_dev.robustness.orders import campaign, rests

_ESTOP_SHARE = 0.05  # of the trials, without --estop


@click.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option(
    "--count", type=click.IntRange(min=1), default=1000, show_default=True, help="Trials."
)
@seed_option
@click.option("--estop", is_flag=True, help="Press the emergency stop in every trial.")
@click.option("--first", type=click.IntRange(min=0), default=0, help="Number of the first trial.")
@click.option(
    "--replay", metavar="SEED:INDEX", help="Do one trial of such a campaign again, and tell of it."
)
@click.option(
    "--together", is_flag=True, help="Arm several axes at once, with bad blocks in between."
)
@click.option("--rests", is_flag=True, help="Let the pixel clock rest, for a second to ten hours.")
@json_option
@click.option("--write", type=FILE, help="Rewrite the board's part of FILE (docs/ORDERS.md).")
@click.pass_context
def orders(
    ctx: click.Context,
    board: str,
    count: int,
    seed: int,
    estop: bool,
    first: int,
    replay: str | None,
    together: bool,
    rests: bool,
    as_json: bool,
    write: Path | None,
) -> None:
    """Give commands in random pairs and triples at random cycles.

    Lines run from 1 to 60,000 steps a second. Exit status 0 only if every reported position is the
    number of edges made, no axis moves that must not, the permit output is low where it must be,
    and a refused command changes nothing.

    --together: axes armed together start together or not at all. --rests: behind a rest the board
    answers in time, without a fault, and a line begins where it should.
    """
    if together and (rests or boards.load(board).axes < 2):
        raise UserError("--together is for a board of several axes, and not with --rests")
    if rests:
        _run_rests(ctx, board, count, seed, first, as_json, write)
    from pixstep_dev.robustness.orders import campaign  # takes a while to load

    share = 1.0 if estop else _ESTOP_SHARE
    if replay:
        seed, index = _place(replay)
        plan = campaign.OrdersPlan(board, 1, seed, index, share, together)
        ctx.exit(0 if campaign.replay(plan, index, click.echo) else 1)
    plan = campaign.OrdersPlan(board, count, seed, first, share, together)
    with progress.shown(f"{board}: {count} trials") as show:
        outcome = campaign.run(plan, show)
    if write:
        _write(write, outcome)
    if as_json:
        click.echo(json.dumps(_facts(outcome), indent=2))
    else:
        _say(outcome)
    ctx.exit(1 if outcome.failed else 0)


def _run_rests(
    ctx: click.Context,
    board: str,
    count: int,
    seed: int,
    first: int,
    as_json: bool,
    write: Path | None,
) -> None:
    """Let the clock rest, say what happened and end the command."""
    from pixstep_dev.robustness.orders import rests as campaign

    with progress.shown(f"{board}: {count} rests") as show:
        outcome = campaign.run(campaign.RestsPlan(board, count, seed, first), show)
    if write:
        _write(write, outcome)
    if as_json:
        click.echo(json.dumps(asdict(outcome), indent=2))
    else:
        click.echo(campaign.text(outcome))
        for failure in outcome.failures:
            click.echo(f"FAIL: {failure}")
    ctx.exit(1 if outcome.failures else 0)


def _place(text: str) -> tuple[int, int]:
    seed, colon, index = text.partition(":")
    if not (colon and seed.isdecimal() and index.isdecimal()):
        raise UserError(f"{text!r}: expected SEED:INDEX")
    return int(seed), int(index)


def _write(path: Path, outcome: campaign.OrdersOutcome | rests.RestsOutcome) -> None:
    from pixstep_dev import markdown
    from pixstep_dev.robustness.orders import record

    markdown.write(path, record.name(outcome), record.markdown(outcome))


def _facts(outcome: campaign.OrdersOutcome) -> dict[str, Any]:
    """Return plain data; pairs by "first, second"."""
    facts = {name: value for name, value in vars(outcome).items() if name != "plan"}
    facts["pairs"] = {", ".join(pair): number for pair, number in outcome.pairs.items()}
    facts["failures"] = [asdict(failure) for failure in outcome.failures]
    return {"board": outcome.plan.board, "seed": outcome.plan.seed, **facts}


def _say(outcome: campaign.OrdersOutcome) -> None:
    click.echo(
        f"{outcome.plan.board}: {outcome.trials:,} trials, {len(outcome.pairs):,} different pairs "
        f"of commands, {outcome.failed:,} failed"
    )
    for what, number in sorted(outcome.started.items()):
        click.echo(f"  {number:>7,} {what} of the axes armed together started")
    for fault, number in sorted(outcome.faults.items()):
        click.echo(f"  {number:>7,} fault {fault}")
    for failure in outcome.failures:
        click.echo(f"FAIL: {failure.text}")
