# SPDX-License-Identifier: MIT
"""`pixstep board move`: exactly N steps on a real axis."""

from fractions import Fraction
from typing import Unpack

import click

from pixstep import progress
from pixstep.board import limits, run, settings, upload
from pixstep.board.errors import BoardError
from pixstep.board.port import Port
from pixstep.cli.board.group import AXIS, one_board, port_options, stopping, unit_option
from pixstep.cli.clockoptions import board_clock_options
from pixstep.cli.command import command
from pixstep.cli.moveoptions import MoveOptions, headline, plan_options, read_plan
from pixstep.cli.options import json_option, show_json
from pixstep.lines.rational import refuse_period


@command("move")
@plan_options
@port_options
@unit_option
@click.option("--axis", type=AXIS, default=0, show_default=True)
@board_clock_options
@json_option
def move_command(
    port: Port,
    unit: int,
    axis: int,
    pixel_hz: Fraction | None,
    divider: int | None,
    as_json: bool,
    **options: Unpack[MoveOptions],
) -> None:
    """Move an axis by exactly N steps.

    By a CSV acceleration profile; it needs no pixel clock. Planned as by `pixstep move show`,
    checked with the board's own limits, followed to its end. Ctrl-C stops the axis.
    """
    with one_board(port, unit) as (found, known):
        board = known.board
        known.axes((axis,))
        hz = settings.pixel_hz(board, pixel_hz, divider)
        refuse_period(hz, board.tick_hz())
        _profile, move = read_plan(options, hz, refuse=True)
        planned = move.line(str(options["profile"]))
        limits.check(planned, limits.connected(board, hz))
        upload.require_idle(board, [axis])
        settings.set_clock(board, pixel_hz, divider=divider)
        before = run.positions(board, [axis])[axis]
        group = [run.Lines(board, [axis])]
        with progress.shown("moving") as show, stopping(group):
            group[0].uploads += upload.begin(
                board, {axis: planned}, divider or settings.divider(board)
            )
            run.arm_queued(group[0])
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
