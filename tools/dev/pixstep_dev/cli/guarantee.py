# SPDX-License-Identifier: MIT
"""`pixstep-dev costs` and `pixstep-dev guarantee`: what images cost, and what follows from it."""

from __future__ import annotations

from dataclasses import asdict

import click

from pixstep import progress
from pixstep.board import boards, costs
from pixstep.cli.command import command
from pixstep_dev.cli.findings import finish, json_option, seed_option


@command("costs")
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), multiple=True, help="Default: all.")
@click.option("--write", is_flag=True, help="Write the table into the package, all boards at once.")
@json_option
@click.pass_context
def costs_command(
    ctx: click.Context, /, board: tuple[str, ...], *, write: bool, as_json: bool
) -> None:
    """Measure what the boards' images cost in the simulator, and compare the table with it.

    Cycles for each kind of pixel, step, account, round, clock edge, request and interrupt. Exit
    status 1 if a probe costs more than the table has for it: then the table is stale.
    """
    from pixstep_dev.costs import table  # takes a while to load

    if write and board:
        raise click.UsageError("--write is for the table of all boards: leave --board out")
    names = board or boards.BOARD_NAMES
    found, complaints = {}, []
    with progress.shown("costs") as show:
        for done, name in enumerate(names, 1):
            found[name] = table.measure(name)
            complaints += [] if write else table.stale(name, found[name])
            show(done / len(names))
    if write:
        table.write(found)
    head = f"{'cycles':20}" + "".join(f"{name:>10}" for name in found)
    rows = [
        f"{one:20}" + "".join(f"{found[name][one]:10g}" for name in found) for one in costs.NAMES
    ]
    facts = {"costs": found, "complaints": complaints}
    finish(ctx, facts, [head, *rows], "the table fits the images", as_json=as_json)


@command("guarantee")
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), multiple=True, help="Default: all.")
@click.option("--count", type=click.IntRange(min=1), default=500, show_default=True, help="Sets.")
@click.option(
    "--rates",
    "phases",
    type=click.IntRange(min=0),
    default=0,
    metavar="RUNS",
    help="No random sets, but so many runs of each line at a guaranteed rate.",
)
@click.option(
    "--sweep",
    is_flag=True,
    help="No runs: what is guaranteed at 36 clocks from 20 Hz to 3.6 kHz, and its dips.",
)
@click.option(
    "--search",
    "tries",
    type=click.IntRange(min=0),
    default=0,
    metavar="PATTERNS",
    help="No random sets, but a search among so many short patterns of each board for those that"
    " fail closest to what is guaranteed.",
)
@seed_option
@json_option
@click.pass_context
def guarantee_command(
    ctx: click.Context,
    /,
    board: tuple[str, ...],
    count: int,
    seed: int,
    phases: int,
    tries: int,
    *,
    sweep: bool,
    as_json: bool,
) -> None:
    """Run random sets of lines about what boards are guaranteed to follow.

    One to all axes, plain and smooth lines with ramps and backlash, started and locked, 20 Hz to 5
    kHz, counts queued or streamed, at 40 to 120 % of the limit, with a clock as bad as declared,
    beside a quiet or a saturated bus. Exit status 0 only if no set that is accepted ends otherwise
    than with every edge right.

    With --rates lines at the guaranteed rates run so many times each beside a saturated bus. With
    --sweep no clock may be promised much fewer steps a pixel than a faster one. With --search
    patterns run at the highest clock that is accepted and beyond, with clocks a little off, and the
    closest are changed and tried again.
    """
    from pixstep_dev.guarantee import campaign, rates, search, sweeps

    if bool(phases) + bool(tries) + sweep > 1:
        raise click.UsageError("--rates, --search and --sweep are questions of their own: one only")
    if tries:
        with progress.shown("search") as show:
            closest = search.run(tries, seed, board, show)
        finish(ctx, asdict(closest), closest.rows, "every accepted pattern runs", as_json=as_json)
        return
    if sweep:
        with progress.shown("sweep") as show:
            swept = sweeps.run(board, progress=show)
        told = {"rows": swept.rows, "complaints": [str(dip) for dip in swept.dips]}
        finish(ctx, told, swept.rows, "no clock is promised less than faster ones", as_json=as_json)
        return
    if phases:
        lines = rates.rated(board)
        with progress.shown(f"{len(lines)} lines") as show:
            found = rates.run(lines, phases, progress=show)
        finish(ctx, asdict(found), found.rows, "every line ran to its end", as_json=as_json)
        return
    with progress.shown(f"{count} sets") as show:
        outcome = campaign.run(campaign.GuaranteePlan(count, seed, board), show)
    facts = {"ended": [asdict(one) for one in outcome.ended], "complaints": outcome.complaints}
    finish(ctx, facts, campaign.table(outcome), "every accepted set ran clean", as_json=as_json)


COMMANDS = (costs_command, guarantee_command)
