# SPDX-License-Identifier: MIT
"""`pixstep-dev robustness`: campaigns of injected faults and of foreign clients."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from pixstep import progress
from pixstep.board import boards
from pixstep.cli.command import Group
from pixstep_dev.cli.findings import finish, json_option, seed_option
from pixstep_dev.cli.orders import orders
from pixstep_dev.robustness import holes
from pixstep_trials.promises import ESTOP_CYCLES

if TYPE_CHECKING:
    from pixstep_dev.robustness.uploads import UploadsOutcome


@click.group("robustness", cls=Group)
def robustness_group() -> None:
    """What may happen to a board: mutated frames, a bad line, other clients, cuts and stops."""


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option(
    "--count", type=click.IntRange(min=1), default=100_000, show_default=True, help="Frames."
)
@seed_option
@json_option
@click.pass_context
def frames(ctx: click.Context, board: str, count: int, seed: int, as_json: bool) -> None:
    """Send mutated frames while every axis moves.

    Compares every STEP edge: runs the same lines undisturbed and under fire. Exit status 0 only if
    the edges are the same to the cycle and the board answers, at rest and without a fault,
    afterwards.
    """
    from pixstep_dev.robustness import framestorm  # takes a while to load

    with progress.shown(f"{board}: {count} frames") as show:
        outcome = framestorm.run(framestorm.FramestormPlan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.frames:,} frames in {outcome.seconds:.0f} simulated seconds, "
        f"{outcome.answers:,} answered, {outcome.exceptions:,} of these by an exception",
        f"  {outcome.edges:,} STEP edges, {outcome.turns} direction changes moved by at most "
        f"{outcome.turn_shift_cycles} cycles",
        *(f"  {number:>7,} {kind}" for kind, number in sorted(outcome.kinds.items())),
        *(f"  board's {name}: {value}" for name, value in outcome.counters.items()),
    ]
    finish(ctx, asdict(outcome), rows, "not one STEP edge differs", as_json=as_json)


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
@seed_option
@json_option
@click.pass_context
def uploads(
    ctx: click.Context, board: str, count: int, garbage: bool, seed: int, as_json: bool
) -> None:
    """Upload lines over a bad serial line.

    Bits turned over, bursts, bytes lost and added, frames lost and repeated. Both ends are the real
    ones: the host's client and the firmware. Exit status 0 only if every queue held exactly what
    was sent (natively), every line played exactly (in the simulator).
    """
    from pixstep_dev.robustness import uploads as campaign
    from pixstep_trials import noise

    model = noise.NoiseModel(0.5, (noise.garbage,)) if garbage else noise.NoiseModel()
    plan = campaign.UploadsPlan(board, count, seed, model, go_on=garbage)
    with progress.shown(f"{board}: {count} blocks") as show:
        outcome = campaign.run(plan, show)
    rows = _upload_rows(board, outcome)
    finish(ctx, _upload_facts(outcome), rows, "every queue was exact", as_json=as_json)


def _upload_facts(outcome: UploadsOutcome) -> dict[str, Any]:
    facts = {name: value for name, value in vars(outcome).items() if name != "plan"}
    return {"board": outcome.plan.board, "seed": outcome.plan.seed, **facts}


def _upload_rows(board: str, outcome: UploadsOutcome) -> list[str]:
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
def clients(ctx: click.Context, board: tuple[str, ...]) -> None:
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
@seed_option
@json_option
@click.pass_context
def estops(ctx: click.Context, board: str, count: int, seed: int, as_json: bool) -> None:
    """Press the emergency stop at random cycles of a run.

    Every axis runs a random line.

    Exit status 0 only if the edges stop within the bound, the permit output is off, the fault is
    named and every reported position is the number of edges made.
    """
    from pixstep_dev.robustness import estops as campaign

    with progress.shown(f"{board}: {count} stops") as show:
        outcome = campaign.run(campaign.EstopsPlan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.stops:,} stops, {outcome.moving:,} of them in motion, "
        f"{outcome.edges:,} STEP edges",
        f"  the last edge but one comes {outcome.latest_cycles} cycles behind the stop at "
        f"most, the permit's end {outcome.permit_cycles}; bound {ESTOP_CYCLES}",
    ]
    otherwise = "every position is the number of edges made"
    finish(ctx, asdict(outcome), rows, otherwise, as_json=as_json)


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option(
    "--count", type=click.IntRange(min=1), default=350, show_default=True, help="Sequences."
)
@click.option(
    "--first",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Number of the first one: sequence SEED:NUMBER is the same in every run.",
)
@seed_option
@json_option
@click.pass_context
def plays(ctx: click.Context, board: str, count: int, first: int, seed: int, as_json: bool) -> None:
    """Look where the loads of axes with play are.

    The axes are stopped at random cycles. Lines, moves, searches, stops, emergency stops and
    disarms follow each other at random; each sequence begins with a reset and a play of 1 to
    400 steps.

    Exit status 0 only if every load is within a step of its line at every pixel edge away from
    take-ups, or the board says that it did not know the play; and if the board knows the play once
    a line with backlash came to its end.
    """
    from pixstep_dev.robustness.plays import campaign

    with progress.shown(f"{board}: {count} sequences") as show:
        outcome = campaign.run(campaign.PlaysPlan(board, count, seed, first), show)
    ends = ", ".join(f"{number:,} {name}" for name, number in sorted(outcome.ends.items()))
    rows = [
        f"{board}: {outcome.sequences:,} sequences, {outcome.lines:,} lines with backlash, of "
        f"{outcome.warned:,} the board did not know the play",
        f"  motions: {ends}",
        f"  {outcome.edges:,} pixel edges away from take-ups, the load {outcome.worst_steps} steps "
        f"off at most",
    ]
    otherwise = "every load was where its line says"
    finish(ctx, asdict(outcome), rows, otherwise, as_json=as_json)


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--count", type=click.IntRange(min=1), default=2000, show_default=True, help="Cuts.")
@seed_option
@json_option
@click.pass_context
def powercuts(ctx: click.Context, board: str, count: int, seed: int, as_json: bool) -> None:
    """Cut the supply at random cycles of a settings store.

    Exit status 0 only if after every cut the board has the old settings or the new ones, whole.
    """
    from pixstep_dev.robustness import powercuts as campaign

    with progress.shown(f"{board}: {count} cuts") as show:
        outcome = campaign.run(campaign.PowercutsPlan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.cuts:,} cuts, {outcome.in_a_byte:,} of them inside a byte; then "
        f"{outcome.old:,} times the old settings, {outcome.new:,} times the new"
    ]
    finish(ctx, asdict(outcome), rows, "always one of them, whole", as_json=as_json)


@robustness_group.command()
@click.option(
    "--board",
    type=click.Choice(boards.BOARD_NAMES),
    multiple=True,
    help="Kinds to choose from.  [default: all]",
)
@click.option(
    "--count", type=click.IntRange(min=1), default=10_000, show_default=True, help="Starts."
)
@seed_option
@json_option
@click.pass_context
def starts(
    ctx: click.Context, board: tuple[str, ...], count: int, seed: int, as_json: bool
) -> None:
    """Start two or three boards together on one pixel clock.

    By the host's own procedure, at random frequencies, dividers, rests of the clock and flaws of
    one board's pin, each simulator with boards that came from reset apart. Exit status 0 only if
    in every start all boards began on one clock edge, or somebody said why not.
    """
    from pixstep_dev.robustness import starts as campaign

    plan = campaign.StartsPlan(board or tuple(boards.BOARD_NAMES), count, seed)
    with progress.shown(f"{count} starts") as show:
        outcome = campaign.run_plan(plan, show)
    rows = [
        f"{outcome.starts:,} starts: {outcome.together:,} together (at most "
        f"{outcome.apart_edges:.3f} clock periods apart), {outcome.named:,} named before anything "
        f"moved, {outcome.named_moved:,} named and stopped in motion",
        *(
            f"  {number:>6,} {reason}"
            for reason, number in sorted(outcome.reasons.items(), key=lambda item: -item[1])
        ),
    ]
    finish(ctx, asdict(outcome), rows, "no silent difference", as_json=as_json)


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--count", type=click.IntRange(min=1), default=20, show_default=True, help="Trials.")
@click.option(
    "--lines", type=click.IntRange(min=1), default=10, show_default=True, help="Of each trial."
)
@click.option(
    "--pixels", type=click.IntRange(min=8), default=512, show_default=True, help="Of each line."
)
@click.option(
    "--rest-s",
    type=click.FloatRange(0.0005, 60),
    nargs=2,
    default=(0.001, 5.0),
    show_default=True,
    help="The shortest and the longest rest.",
)
@click.option("--flaws/--no-flaws", default=True, help="Bursts and rests with flaws, too.")
@seed_option
@json_option
@click.pass_context
def gates(
    ctx: click.Context,
    board: str,
    count: int,
    lines: int,
    pixels: int,
    rest_s: tuple[float, float],
    flaws: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Run lines on a gated pixel clock, one a burst.

    The axes run them back to back over the rests. Random frequencies of 100 Hz to 2 kHz, rests,
    dividers, axes and lines, started and locked. Some bursts are too short or lack an edge, some
    rests have a false one.

    Exit status 0 only if every line was on its edges of its burst, or a fault said why not; a fault
    without a flaw is no excuse.
    """
    from pixstep_dev.robustness import gates as campaign

    _require_order("--rest-s", *rest_s)
    chosen = campaign.FLAWS if flaws else campaign.FLAWS[:1]
    plan = campaign.GatesPlan(board, count, lines, pixels, seed, chosen, rest_s)
    with progress.shown(f"{board}: {count} trials") as show:
        outcome = campaign.run_plan(plan, show)
    faults = ", ".join(f"{number:,} {name}" for name, number in sorted(outcome.faults.items()))
    rows = [
        f"{board}: {outcome.trials:,} trials, {outcome.right:,} right, {outcome.named:,} named "
        f"({faults or 'no fault'})",
        f"  {outcome.lines:,} lines of all axes, {outcome.pixels:,} pixel ends; locked ones on an "
        f"even clock {outcome.off_ticks:.1f} ticks off at most",
        f"  {1000 * outcome.late_s:.1f} ms from line to line were not enough",
    ]
    finish(ctx, asdict(outcome), rows, "every line on its burst", as_json=as_json)


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--count", type=click.IntRange(min=1), default=500, show_default=True, help="Plants.")
@click.option(
    "--bounce-ticks",
    type=click.IntRange(min=1),
    nargs=2,
    default=(1, 20_000),
    show_default=True,
    help="The shortest and the longest bouncing.",
)
@seed_option
@json_option
@click.pass_context
def homings(
    ctx: click.Context,
    board: str,
    count: int,
    bounce_ticks: tuple[int, int],
    seed: int,
    as_json: bool,
) -> None:
    """Home by switches that bounce, and measure the play by them.

    Random mechanics: play, hysteresis, the contact's delay and its bounces as it closes and opens;
    half of the home switches are limit switches too.

    Exit status 0 only if every home and every play is right to a step.
    """
    from pixstep_dev.robustness import homings as campaign

    _require_order("--bounce-ticks", *bounce_ticks)
    with progress.shown(f"{board}: {count} plants") as show:
        outcome = campaign.run(campaign.HomingsPlan(board, count, seed, bounce_ticks), show)
    rows = [
        f"{board}: {outcome.plants:,} plants, contacts that bounce for {bounce_ticks[0]} to "
        f"{bounce_ticks[1]} ticks",
        f"  steps off, homed: {_spread(outcome.homed_off_steps)}; "
        f"play: {_spread(outcome.play_off_steps)}",
    ]
    finish(ctx, asdict(outcome), rows, "every switch was found to a step", as_json=as_json)


def _require_order(option: str, least: float, most: float) -> None:
    """Raise BadParameter unless the least value comes first."""
    if not least <= most:  # so is not a number
        raise click.BadParameter(
            f"{least:g} {most:g}: the least value comes first", param_hint=option
        )


def _spread(counts: dict[int, int]) -> str:
    """Return how often each deviation was met."""
    return ", ".join(f"{off} {number:,} times" for off, number in sorted(counts.items())) or "none"


@robustness_group.command()
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option(
    "--count", type=click.IntRange(min=1), default=1000, show_default=True, help="Clocks."
)
@seed_option
@json_option
@click.pass_context
def clocks(ctx: click.Context, board: str, count: int, seed: int, as_json: bool) -> None:
    """Give a board pixel clocks of another frequency than it is set to.

    0.24 to 4.2 times the frequency, at rest and in motion, lines that begin on the clock and lines
    that are locked to it. Exit status 0 only if each was refused or named by a fault within 8 of
    its edges or 20 ms, and no line ran to its end.
    """
    from pixstep_dev.robustness import clocks as campaign

    with progress.shown(f"{board}: {count} clocks") as show:
        outcome = campaign.run(campaign.ClocksPlan(board, count, seed), show)
    rows = [
        f"{board}: {outcome.clocks:,} wrong clocks, {outcome.in_motion:,} of them in motion",
        *(f"  {number:>6,} {name}" for name, number in sorted(outcome.named.items())),
    ]
    finish(ctx, asdict(outcome), rows, "each one was refused or named", as_json=as_json)


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
@json_option
@click.pass_context
def holes_command(
    ctx: click.Context,
    /,
    board: tuple[str, ...],
    sync: tuple[str, ...],
    motion: tuple[str, ...],
    as_json: bool,
    **options: Any,
) -> None:
    """Look for rates that fail below one that passes.

    A sweep of pixel clocks and steps a pixel. From 1 Hz to 5 kHz, on one axis up to all, begun on
    the clock and locked to it.

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
        if not chosen:
            raise click.BadParameter(
                f"{options['axes']}: none of the boards has so many axes", param_hint="--axes"
            )
    with progress.shown("holes") as show:
        outcome = holes.run(holes.HolesPlan(chosen, clocks, counts), show)
    otherwise = f"no hole deeper than {holes.ALLOWED_PERCENT:g} %"
    finish(ctx, asdict(outcome), holes.table(outcome), otherwise, as_json=as_json)


robustness_group.add_command(orders)

COMMANDS = (robustness_group,)
