# SPDX-License-Identifier: MIT
"""`pixstep board trajectory`: a table of two axes on a board, the original or compensated."""

from fractions import Fraction
from pathlib import Path
from typing import Unpack

import click

from pixstep.board import run, settings, upload
from pixstep.board.limits import connected
from pixstep.board.port import Port
from pixstep.cli import directions
from pixstep.cli.board.group import one_board, port_options, unit_option
from pixstep.cli.board.recordoptions import exit_status, record_options, recorded
from pixstep.cli.board.upload import check_lines, run_lines
from pixstep.cli.clockoptions import (
    board_clock_options,
    board_gate_edges_option,
    board_sync_option,
)
from pixstep.cli.command import FILE, command
from pixstep.cli.manylines import line_axes, line_axes_option
from pixstep.cli.options import json_option, show_json, teller
from pixstep.cli.trajectoryoptions import PlayOptions, axis_plays, board_play_options, read_table
from pixstep.lines.rational import refuse_period
from pixstep.trajectories import boardsim, host, transitions
from pixstep.trajectories.circletest import RUNS
from pixstep.trajectories.host import COMPENSATED
from pixstep.trajectories.table import AXES


@command("trajectory")
@click.argument("table", metavar="TABLE", type=FILE)
@board_play_options
@click.option("--run", "which", type=click.Choice(RUNS), default=COMPENSATED, show_default=True,
              help="The table as it is, or with its play taken up.")  # fmt: skip
@click.option("--take-up/--no-take-up", default=True, show_default=True,
              help="First go back by the play and forth again, so that it is taken up in the "
              "direction in which each axis begins.")  # fmt: skip
@port_options
@unit_option
@line_axes_option
@board_clock_options
@board_sync_option
@board_gate_edges_option
@record_options
@json_option
@click.pass_context
def trajectory_command(
    ctx: click.Context,
    table: Path,
    port: Port,
    unit: int,
    which: str,
    take_up: bool,
    axis: tuple[int, ...],
    pixel_hz: Fraction | None,
    divider: int | None,
    sync: str | None,
    gate_edges: int | None,
    record_file: Path | None,
    record: bool,
    as_json: bool,
    **options: Unpack[PlayOptions],
) -> None:
    """Run a table of two axes, its play taken up or not.

    Hold records are left out. The lines are checked with the board's own limits before anything
    moves, streamed, and followed to their end.
    """
    original = read_table(table).without_holds()
    motor_ways = directions.ways(ctx, AXES)
    ways = tuple(transitions.initial_direction(original, index) for index in range(AXES))
    with one_board(port, unit) as (found, known):
        axes = line_axes(axis, AXES)
        known.axes(tuple(axes))
        hz = settings.pixel_hz(known.board, pixel_hz, divider)
        refuse_period(hz, known.board.tick_hz())
        clock = settings.of_clock(sync, divider)
        limits = connected(known.board, hz, AXES, clock)
        top = int(limits.shortest_ticks) // limits.min_interval_ticks
        most = top - int(abs(original.velocities).max()) - 1
        plays = axis_plays(options, original, hz, most)
        made = host.command(original, plays, which)
        chosen = boardsim.taking_up(made, plays, ways) if take_up else boardsim.lines(made)
        lines = dict(zip(axes, boardsim.turned(chosen, motor_ways), strict=True))
        check_lines(known, lines, hz, clock)
        upload.require_idle(known.board, axes)
        settings.set_clock(known.board, pixel_hz, sync, divider, gate_edges)
        edges = divider or settings.divider(known.board)
        group = [run.Lines(known.board, axes)]
        with recorded(group, record_file, wanted=record) as records:
            summary = run_lines(group[0], found.world, lines, edges, records, arm=True, wait=True)
    if as_json:
        show_json({
            **summary, "run": which, "play_steps": [item.play for item in plays],
            "transition_points": [item.steps for item in plays],
        })  # fmt: skip
        ctx.exit(exit_status(records, echo=False))
    tell = teller(record_file)
    for row in summary["axes"]:
        tell(
            f"board {unit} axis {row['axis']}: {row['file']}, {row['steps']} steps in "
            f"{row['seconds']:g} s: {row['state']}, position {row['position_steps']}"
        )
    ctx.exit(exit_status(records, echo=True))
