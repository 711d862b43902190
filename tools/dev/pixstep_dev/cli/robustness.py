# SPDX-License-Identifier: MIT
"""`pixstep-dev robustness`: campaigns of injected faults and of foreign clients."""

import json
from dataclasses import asdict

import click

from pixstep import progress
from pixstep.board import boards
from pixstep.cli.command import Group
from pixstep_dev.cli.orders import orders
from pixstep_dev.robustness import holes

_seed = click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True)
_json = click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")


@click.group("robustness", cls=Group)
def robustness_group() -> None:
    """What may happen to a board: mutated frames, a bad line, other clients, cuts and stops."""


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option(
    "--count", type=click.IntRange(min=1), default=100_000, show_default=True, help="Frames."
)
@_seed
@_json
@click.pass_context
def frames(ctx, board, count, seed, as_json):
    """Send mutated frames while every axis moves.

    Compares every STEP edge: runs the same lines undisturbed and under fire. Exit status 0 only if
    the edges are the same to the cycle and the board answers, at rest and without a fault,
    afterwards.
    """
    from pixstep_dev.robustness import framestorm  # pymodbus takes a while to load

    with progress.shown(f"{board}: {count} frames") as show:
        outcome = framestorm.run(framestorm.Plan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.frames:,} frames in {outcome.seconds:.0f} simulated seconds, "
        f"{outcome.answers:,} answered, {outcome.exceptions:,} of these by an exception",
        f"  {outcome.edges:,} STEP edges, {outcome.turns} direction changes moved by at most "
        f"{outcome.turn_shift_cycles} cycles",
        *(f"  {number:>7,} {kind}" for kind, number in sorted(outcome.kinds.items())),
        *(f"  board's {name}: {value}" for name, value in outcome.counters.items()),
    ]
    _finish(ctx, asdict(outcome), rows, "not one STEP edge differs", as_json=as_json)


def _finish(
    ctx: click.Context, facts: dict, rows: list[str], otherwise: str, *, as_json: bool
) -> None:
    """Print what a campaign found, as JSON or as text; end with 1 if there are complaints."""
    complaints = facts["complaints"]
    if as_json:
        click.echo(json.dumps(facts, indent=2))
    else:
        told = [f"FAIL: {text}" for text in complaints] or [f"  {otherwise}"]
        click.echo("\n".join([*rows, *told]))
    ctx.exit(1 if complaints else 0)


@robustness_group.command()
@click.option(
    "--board",
    type=click.Choice(("native", *boards.BOARD_NAMES)),
    default="native",
    show_default=True,
    help="The firmware natively, or an image in the simulator.",
)
@click.option(
    "--count", type=click.IntRange(min=1), default=200_000, show_default=True, help="Blocks."
)
@click.option(
    "--garbage",
    is_flag=True,
    help="Random bytes at the end of half of the frames: some pass the checksum; goes on then.",
)
@_seed
@_json
@click.pass_context
def uploads(ctx, board, count, garbage, seed, as_json):
    """Upload lines over a bad serial line.

    Bits turned over, bursts, bytes lost and added, frames lost and repeated. Both ends are the real
    ones: the host's client and the firmware. Exit status 0 only if every queue held exactly what
    was sent (natively), every line played exactly (in the simulator).
    """
    from pixstep_dev.robustness import noise
    from pixstep_dev.robustness import uploads as campaign

    model = noise.Model(0.5, (noise.garbage,)) if garbage else noise.Model()
    plan = campaign.Plan(board, count, seed, model, go_on=garbage)
    with progress.shown(f"{board}: {count} blocks") as show:
        outcome = campaign.run(plan, show)
    rows = _upload_rows(board, outcome)
    _finish(ctx, _upload_facts(outcome), rows, "every queue was exact", as_json=as_json)


def _upload_facts(outcome) -> dict:
    facts = {name: value for name, value in vars(outcome).items() if name != "plan"}
    return {"board": outcome.plan.board, "seed": outcome.plan.seed, **facts}


def _upload_rows(board: str, outcome) -> list[str]:
    """Return in words what a campaign did."""
    rows = [
        f"{board}: {outcome.blocks:,} blocks of {outcome.lines:,} lines, "
        f"{outcome.entries:,} entries, {outcome.requests:,} requests, "
        f"{outcome.given_up:,} times begun again after every retry had failed"
    ]
    if outcome.steps:
        rows.append(f"  {outcome.steps:,} steps made and counted")
    rows += [f"  {number:>7,} {name}" for name, number in sorted(outcome.noise.items())]
    rows.append(f"  {outcome.undetected:,} spoilt frames had a right checksum all the same")
    if outcome.complaints:
        rows.append(
            f"  {outcome.reported} lines ended with an error, {outcome.silent} were silently wrong"
        )
    return rows


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), multiple=True, help="Default: all.")
@click.pass_context
def clients(ctx, board):
    """Run a list of cases by mbpoll, libmodbus and pymodbus.

    Against every image in the simulator.

    `pixstep-dev docs conformance --write docs/PROTOCOL.md` keeps its table. Exit status 0 only if
    no case fails.
    """
    from pixstep_dev.robustness.clients import conformance

    with progress.shown("clients") as show:
        results = conformance.run(board or boards.BOARD_NAMES, show)
    click.echo(conformance.table(results), nl=False)
    failures = conformance.failures(results)
    for text in failures:
        click.echo(f"FAIL: {text}", err=True)
    ctx.exit(1 if failures else 0)


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--count", type=click.IntRange(min=1), default=1000, show_default=True, help="Stops.")
@_seed
@_json
@click.pass_context
def estops(ctx, board, count, seed, as_json):
    """Press the emergency stop at random cycles of a run.

    Every axis runs a random line.

    Exit status 0 only if the edges stop within the bound, the permit output is off, the fault is
    named and every reported position is the number of edges made.
    """
    from pixstep_dev.robustness import estops as campaign

    with progress.shown(f"{board}: {count} stops") as show:
        outcome = campaign.run(campaign.Plan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.stops:,} stops, {outcome.moving:,} of them in motion, "
        f"{outcome.edges:,} STEP edges",
        f"  the last edge but one comes {outcome.latest_cycles} cycles behind the stop at "
        f"most, the permit's end {outcome.permit_cycles}; bound {campaign.BOUND_CYCLES}",
    ]
    otherwise = "every position is the number of edges made"
    _finish(ctx, asdict(outcome), rows, otherwise, as_json=as_json)


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--count", type=click.IntRange(min=1), default=2000, show_default=True, help="Cuts.")
@_seed
@_json
@click.pass_context
def powercuts(ctx, board, count, seed, as_json):
    """Cut the supply at random cycles of a settings store.

    Exit status 0 only if after every cut the board has the old settings or the new ones, whole.
    """
    from pixstep_dev.robustness import powercuts as campaign

    with progress.shown(f"{board}: {count} cuts") as show:
        outcome = campaign.run(campaign.Plan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.cuts:,} cuts, {outcome.in_a_byte:,} of them inside a byte; then "
        f"{outcome.old:,} times the old settings, {outcome.new:,} times the new"
    ]
    _finish(ctx, asdict(outcome), rows, "always one of them, whole", as_json=as_json)


@robustness_group.command("holes")
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), multiple=True, help="Default: all.")
@click.option("--axes", type=click.IntRange(1, 4), help="Default: one up to all of a board.")
@click.option("--sync", type=click.Choice(holes.SYNCS), multiple=True, help="Default: both.")
@click.option("--motion", type=click.Choice(holes.MOTIONS), multiple=True, help="Default: all.")
@click.option("--clocks", type=click.IntRange(1), default=40, show_default=True)
@click.option(
    "--counts",
    type=click.IntRange(1),
    default=150,
    show_default=True,
    help="Of steps a pixel; a hundred of them are possible at a middling clock.",
)
@click.option("--quick", is_flag=True, help="All axes, few clocks and counts.")
@_json
@click.pass_context
def holes_command(ctx, board, sync, motion, as_json, **options):
    """Sweep pixel clocks and steps a pixel for rates that fail below one that passes.

    From 1 Hz to 5 kHz, on one axis up to all, begun on the clock and locked to it.

    Exit status 0 only if no hole is deeper than 5 %.
    """
    chosen = holes.combinations(
        board or boards.BOARD_NAMES, sync or holes.SYNCS, motion or holes.MOTIONS
    )
    clocks, counts = holes.clocks(options["clocks"]), holes.counts(options["counts"])
    if options["quick"]:
        chosen = holes.only_all_axes(chosen)
        clocks, counts = holes.QUICK_CLOCKS, holes.QUICK_COUNTS
    if options["axes"]:
        chosen = tuple(case for case in chosen if case.axes == options["axes"])
    with progress.shown("holes") as show:
        outcome = holes.run(holes.Plan(chosen, clocks, counts), show)
    otherwise = f"no hole deeper than {holes.ALLOWED_PERCENT:g} %"
    _finish(ctx, asdict(outcome), holes.table(outcome), otherwise, as_json=as_json)


robustness_group.add_command(orders)

COMMANDS = (robustness_group,)
