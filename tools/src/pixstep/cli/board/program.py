# SPDX-License-Identifier: MIT
"""`pixstep board run`: a motion program on a board, planned while it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

import click

from pixstep import progress
from pixstep.board.port import Port
from pixstep.cli import machinedefaults
from pixstep.cli.board.group import one_board, port_options, stopping, unit_option
from pixstep.cli.board.recordoptions import exit_status, record_options, recorded
from pixstep.cli.command import FILE, command
from pixstep.cli.options import json_option, show_json, teller
from pixstep.cli.programoptions import (
    ProgramOptions,
    none_found,
    plan_options_of,
    program_options,
    setup_of,
)


@command("run")
@click.argument("program", metavar="PROGRAM", type=FILE)
@program_options
@port_options
@unit_option
@click.option(
    "--no-check", "check", is_flag=True, default=True, flag_value=False,
    help="Begin at once: a mistake further down stops the motors when the plan comes to it.",
)  # fmt: skip
@record_options
@json_option
@click.pass_context
def run_command(
    ctx: click.Context,
    program: Path,
    port: Port,
    unit: int,
    check: bool,
    record_file: Path | None,
    record: bool,
    as_json: bool,
    **options: Unpack[ProgramOptions],
) -> None:
    """Run a motion program while it is planned.

    A machine file says which motors it moves; positions count from where they are. First the
    program is planned once without moving: a mistake in it, or a line that the board would refuse,
    is found at rest. Then the motors start together on one pixel clock edge. Planning goes on in a
    process of its own and memory does not grow with the program. Ctrl-C stops the motors. The
    per-pixel records are read meanwhile; --records writes them.
    """
    from pixstep.programs import onboard  # numpy takes a while to load
    from pixstep.programs.sources import Request

    machine = machinedefaults.in_force(ctx)
    if machine is None:
        raise none_found()
    request = Request(str(program), setup_of(machine, options), plan_options_of(options))
    with one_board(port, unit) as (found, known):
        board = known.board
        known.axes(tuple(motor.axis for motor in request.setup.motors))
        onboard.require_fitting(machine, request.setup, known.who.board)
        rehearsed = None
        if check:
            with progress.shown("planning") as show:
                rehearsed = onboard.rehearse(board, request, show)
        with onboard.prepared(board, request, rehearsed) as run:
            with (
                recorded([run.lines], record_file, wanted=record) as records,
                progress.shown("running") as show,
                stopping([run.lines]),
            ):
                run.run(found.world, show)
            rows = [
                {**row, "records": records.of(unit, motor.axis)}
                for row, motor in zip(run.rows(), request.setup.motors, strict=True)
            ]
    if as_json:
        show_json({"program": str(program), "unit": unit, "axes": rows})
        ctx.exit(exit_status(records, echo=False))
    tell = teller(record_file)
    for row in rows:
        tell(
            f"board {unit} axis {row['axis']}: motor {row['motor']} {row['state']}, made "
            f"{row['made_steps']} steps, from position {row['from_steps']} to "
            f"{row['position_steps']}"
        )
    ctx.exit(exit_status(records, echo=True))
