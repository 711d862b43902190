# SPDX-License-Identifier: MIT
"""`pixstep move make`, `move show`, `move sim`: fast moves of exactly N steps."""

import json

import click
from rich.console import Console

from pixstep import formats, progress
from pixstep.board import boards
from pixstep.cli.moveoptions import headline, plan_options, read_plan
from pixstep.cli.options import FILE, FOLDER, pixel_hz_option, refuse_input, teller
from pixstep.cli.results import deliver
from pixstep.errors import UserError
from pixstep.moves import fastsim, fasttask
from pixstep.simulation import report

_MOST_ROWS = 40


@click.group()
def move() -> None:
    """Fast moves of exactly N steps by a CSV acceleration profile."""


@move.command("make")
@plan_options
@pixel_hz_option
@click.option("-o", "--output", type=FILE, required=True, help="CSV line file to write (plain).")
def move_make(output, **options):
    """Write a move as a plain line: one signed count per pixel, the fewest pixels there are."""
    refuse_input(output, options["profile"])
    job = _job(options, refuse=True)
    formats.write_csv(output, list(job.move.counts))
    teller(output)(f"{output}: {headline(job.move, job.pixel_hz)}")


@move.command("show")
@plan_options
@pixel_hz_option
@click.option("--plot", type=FILE, help="Draw speed and position over time (PNG).")
@click.option("--json", "as_json", is_flag=True, help="Machine-readable output.")
def move_show(plot, as_json, **options):
    """Show a move: how fast in which pixels, how long, where."""
    refuse_input(plot, options["profile"])
    job = _job(options)
    if plot:
        from pixstep.moves import fastplot  # matplotlib takes a second to load

        fastplot.draw_plan(job, plot)
    if as_json:
        click.echo(json.dumps(fastsim.plan_summary(job), indent=2))
        return
    click.echo(headline(job.move, job.pixel_hz))
    _print_runs(job)


@move.command("sim")
@plan_options
@pixel_hz_option
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--axis", type=click.IntRange(0, 3), default=0, show_default=True)
@click.option(
    "--out",
    type=FOLDER,
    required=True,
    help="Folder for the results; replaces only those of earlier runs.",
)
@click.option("--plot", is_flag=True, help="Draw move.png into the folder.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.pass_context
def move_sim(ctx, board, axis, out, plot, as_json, **options):
    """Make a move on a simulated board and judge every STEP edge and where it ends.

    Exit status 0 only if the verdict is pass, 1 if it is not, 2 for misuse.
    """
    if axis >= boards.load(board).axes:
        raise UserError(f"axis {axis}: the {boards.axes_text(board)}")
    job = _job(options, board, axis)
    with progress.shown("moving") as show:
        done = fasttask.simulate(job, out, plot=plot, progress=show)

    def page(console: Console, summary: dict) -> None:
        report.print_page(console, summary)
        click.echo(headline(job.move, job.pixel_hz))
        click.echo(
            f"ends at {_known(summary['move']['position_register_steps'])} by the board's position "
            f"register, {summary['move']['counted_steps']} by the simulator's count of STEP edges"
        )

    ctx.exit(deliver(done.judged.summary, out, page, as_json=as_json))


def _job(options: dict, board: str = "", axis: int = 0, *, refuse: bool = False) -> fastsim.MoveJob:
    """Read the profile and plan the move; `refuse` a profile for a lower pixel frequency."""
    pixel_hz = options["pixel_hz"]
    profile, planned = read_plan(options, pixel_hz, refuse=refuse)
    return fastsim.MoveJob(profile, planned, board, axis, pixel_hz)


def _print_runs(job: fastsim.MoveJob) -> None:
    """Print one row for each stretch of equal pixels; of very many the first and last ones."""
    table = report.new_table("pixels", "steps/pixel", "steps/s", "position at its end")
    pixel = place = 0
    hidden = range(_MOST_ROWS // 2, len(job.move.runs) - _MOST_ROWS // 2)
    for index, (count, repeat) in enumerate(job.move.runs):
        span = f"{pixel + 1}" if repeat == 1 else f"{pixel + 1} to {pixel + repeat}"
        pixel, place = pixel + repeat, place + count * repeat
        if index not in hidden:
            table.add_row(span, str(count), f"{float(count * job.pixel_hz):g}", str(place))
        elif index == hidden.start:
            table.add_row("...", "", "", "")
    Console(highlight=False).print(table)


def _known(value: int | None) -> str:
    return "no position" if value is None else str(value)


COMMANDS = (move,)
