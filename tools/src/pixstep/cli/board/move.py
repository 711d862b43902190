# SPDX-License-Identifier: MIT
"""`pixstep board move`: exactly N steps on a real axis."""

from fractions import Fraction
from typing import Unpack

import click

from pixstep import progress
from pixstep.board.port import Port
from pixstep.cli.board.group import AXIS, one_board, port_options, stopping, unit_option
from pixstep.cli.clockoptions import board_clock_options
from pixstep.cli.command import command
from pixstep.cli.moveoptions import MoveOptions, headline, plan_options, read_plan
from pixstep.cli.options import json_option, show_json
from pixstep.moves import onboard


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
    clock = onboard.Clock(pixel_hz, divider)
    with one_board(port, unit) as (found, known):
        known.axes((axis,))
        hz = clock.pixel_hz(known.board)
        _profile, move = read_plan(options, hz, refuse=True)
        ready = onboard.prepare_move(known.board, axis, move, clock, str(options["profile"]))
        with progress.shown("moving") as show, stopping([ready.lines]):
            moved = ready.make(found.world, show)
    if as_json:
        show_json({
            "unit": unit, "axis": axis, "steps": move.steps, "pixels": move.pixels,
            "seconds": round(move.seconds(hz), 6), "top_steps_px": move.top,
            "from_steps": moved.from_steps, "to_steps": moved.to_steps,
        })  # fmt: skip
        return
    click.echo(headline(move, hz))
    click.echo(f"board {unit} axis {axis}: from position {moved.from_steps} to {moved.to_steps}")
