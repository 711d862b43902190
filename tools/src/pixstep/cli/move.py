# SPDX-License-Identifier: MIT
"""`pixstep move make`, `move show`, `move sim`: fast moves of exactly N steps."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from pixstep import formats, progress
from pixstep.board import boards
from pixstep.cli import machinedefaults
from pixstep.cli.command import OUTPUT, command
from pixstep.cli.moveoptions import MoveOptions, headline, plan_options, read_plan
from pixstep.cli.options import (
    deliver_facts,
    details_option,
    json_option,
    out_option,
    pixel_hz_option,
    plot_option,
    plots_option,
    show_json,
)
from pixstep.cli.results import deliver
from pixstep.errors import UserError
from pixstep.moves import fastsim, fasttask
from pixstep.simulation import report
from pixstep.simulation.summary import Summary

if TYPE_CHECKING:
    import rich.console

_MOST_ROWS = 40


@command("make")
@plan_options
@pixel_hz_option
@click.option("-o", "--output", type=OUTPUT, required=True, help="CSV file to write (plain).")
@json_option
def move_make(
    output: Path, pixel_hz: Fraction, as_json: bool, **options: Unpack[MoveOptions]
) -> None:
    """Write a move as a plain line: one signed count per pixel, the fewest pixels there are."""
    job = _job(options, pixel_hz, refuse=True)
    formats.write_csv(output, list(job.move.counts))
    facts = {"file": str(output), **fastsim.plan_summary(job)}
    text = f"{output}: {headline(job.move, job.pixel_hz)}"
    deliver_facts(facts, text, output, as_json=as_json)


@command("show")
@plan_options
@pixel_hz_option
@plot_option(what="Draw speed and position over time")
@json_option
def move_show(
    plot: Path | None, pixel_hz: Fraction, as_json: bool, **options: Unpack[MoveOptions]
) -> None:
    """Show a move: how fast in which pixels, how long, where."""
    job = _job(options, pixel_hz)
    if plot:
        from pixstep.moves import fastplot  # matplotlib takes a second to load

        fastplot.draw_plan(_scaled(job), plot)
    if as_json:
        show_json(fastsim.plan_summary(job))
        return
    click.echo(headline(job.move, job.pixel_hz))
    _print_runs(job)


@command("sim")
@plan_options
@pixel_hz_option
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--axis", type=click.IntRange(0, 3), default=0, show_default=True)
@out_option
@plots_option
@details_option
@json_option
@click.pass_context
def move_sim(
    ctx: click.Context,
    board: str,
    axis: int,
    pixel_hz: Fraction,
    out: Path,
    plot: bool,
    details: bool,
    as_json: bool,
    **options: Unpack[MoveOptions],
) -> None:
    """Make a move on a simulated board and judge every STEP edge and where it ends.

    Exit status 0 only if the verdict is pass, 1 if it is not, 2 for misuse.
    """
    if axis >= boards.load(board).axes:
        raise UserError(f"axis {axis}: the {boards.axes_text(board)}")
    job = _job(options, pixel_hz, board, axis)
    with progress.shown("moving") as show:
        if plot:
            job = _scaled(job)
        done = fasttask.simulate(job, out, plot=plot, progress=show)

    def page(console: rich.console.Console, summary: Summary) -> None:
        report.print_page(console, summary, details=details)
        click.echo(headline(job.move, job.pixel_hz))
        move = summary["move"]
        click.echo(
            f"ends at {_known(move['position_register_steps'])} by the board's position "
            f"register, {move['counted_steps']} by the simulator's count of STEP edges"
        )

    ctx.exit(deliver(done.judged.summary, out, page, as_json=as_json))


def _job(
    options: MoveOptions,
    pixel_hz: Fraction,
    board: str = "",
    axis: int = 0,
    *,
    refuse: bool = False,
) -> fastsim.MoveJob:
    """Read the profile and plan the move; `refuse` a profile for a lower pixel frequency."""
    profile, planned = read_plan(options, pixel_hz, refuse=refuse)
    return fastsim.MoveJob(profile, planned, board, axis, pixel_hz)


def _scaled(job: fastsim.MoveJob) -> fastsim.MoveJob:
    """Return a job with the scale of its axis' motor, for a picture."""
    return replace(job, scale=machinedefaults.scales(click.get_current_context()).get(job.axis))


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
    report.new_console().print(table)


def _known(value: int | None) -> str:
    return "no position" if value is None else str(value)
