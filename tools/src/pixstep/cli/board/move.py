# SPDX-License-Identifier: MIT
"""`pixstep board move`: exactly N steps on a real axis."""

import click

from pixstep import progress
from pixstep.board import limits, run, settings, upload
from pixstep.board.client import BoardError
from pixstep.cli.board.group import AXIS, line_options, one_board, stopping, unit_option
from pixstep.cli.clockoptions import board_clock_options
from pixstep.cli.command import command
from pixstep.cli.moveoptions import headline, plan_options, read_plan
from pixstep.cli.options import json_option, show_json
from pixstep.lines.rational import refuse_period


@command("move")
@plan_options
@line_options
@unit_option
@click.option("--axis", type=AXIS, default=0, show_default=True)
@board_clock_options
@json_option
def move_command(line, unit, axis, pixel_hz, divider, as_json, **options):
    """Move an axis by exactly N steps.

    By a CSV acceleration profile; it needs no pixel clock. Planned as by `pixstep move show`,
    checked with the board's own limits, followed to its end. Ctrl-C stops the axis.
    """
    with one_board(line, unit) as (found, known):
        board = known.board
        known.axes((axis,))
        hz = settings.pixel_hz(board, pixel_hz, divider)
        refuse_period(hz, board.tick_hz())
        _profile, move = read_plan(options, hz, refuse=True)
        planned = move.line(str(options["profile"]))
        limits.check(planned, limits.connected(board, hz))
        settings.set_clock(board, pixel_hz, divider=divider)
        before = run.positions(board, [axis])[axis]
        uploads = upload.begin(board, {axis: planned})
        group = [run.Lines(board, [axis], uploads)]
        with progress.shown("moving") as show, stopping(group):
            run.arm(board, [axis])
            run.follow(group, found.world, move.pixels, show)
        after = run.positions(board, [axis])[axis]
    if after - before != move.steps:
        raise BoardError(
            f"board {unit}: axis {axis} moved {after - before} steps, not {move.steps}"
        )
    if as_json:
        show_json({
            "unit": unit, "axis": axis, "steps": move.steps, "pixels": move.pixels,
            "seconds": round(move.seconds(hz), 6), "top_steps_px": move.top,
            "from_steps": before, "to_steps": after,
        })  # fmt: skip
        return
    click.echo(headline(move, hz))
    click.echo(f"board {unit} axis {axis}: from position {before} to {after}")
