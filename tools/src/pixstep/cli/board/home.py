# SPDX-License-Identifier: MIT
"""`pixstep board home`: find the home switch of a real axis and stand on its edge."""

from fractions import Fraction
from typing import Unpack

import click

from pixstep import progress
from pixstep.board import limits, run, settings, upload
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.port import Port
from pixstep.cli.board.group import Known, one_board, port_options, stopping, unit_option
from pixstep.cli.clockoptions import board_clock_options
from pixstep.cli.command import command
from pixstep.cli.homeoptions import HomeOptions, home_options, make_plan
from pixstep.cli.options import json_option, show_json
from pixstep.lines.rational import refuse_period
from pixstep.moves import homing, legs
from pixstep.moves.homesim import INVERTED, shared_limits
from pixstep.moves.homing import Homed, HomingError


@command("home")
@home_options
@port_options
@unit_option
@board_clock_options
@json_option
def home_command(
    port: Port,
    unit: int,
    pixel_hz: Fraction | None,
    divider: int | None,
    as_json: bool,
    **options: Unpack[HomeOptions],
) -> None:
    """Home an axis: its switch's edge becomes position 0.

    By a CSV or CSB profile. Off the switch, towards it, back, slowly towards it again; then the
    axis stands on 0. A fault ends it, named, and stays latched. The same options as `pixstep home
    sim`, which tries it first.
    """
    with one_board(port, unit) as (found, known):
        plan, hz = prepare(known, options, pixel_hz, divider)
        try:
            group = [run.Lines(known.board, [plan.axis])]
            with progress.shown("homing") as show, stopping(group):
                homed = homing.home(known.board, plan, hz, found.world, show)
        except HomingError as error:
            if as_json:
                made = homing.legs_as_json(error.legs)
                row = {"found": False, "fault": error.name, "text": str(error), "legs": made}
                show_json(row)
            raise BoardError(f"board {unit}: {error}") from None
    if as_json:
        show_json({"found": True, "unit": unit} | homed.as_json())
    else:
        click.echo(_text(unit, homed))


def prepare(
    known: Known, options: HomeOptions, clock_hz: Fraction | None, divider: int | None
) -> tuple[legs.HomingPlan, Fraction]:
    """Check all that can be checked, then set and enable; return the plan and its clock in Hz."""
    known.axes((options["axis"],))
    known.board.require("homing")
    pixel_hz = settings.pixel_hz(known.board, clock_hz, divider)
    refuse_period(pixel_hz, known.board.tick_hz())
    plan = make_plan(options, pixel_hz, refuse=True)
    legs.refuse(plan, limits.connected(known.board, pixel_hz))
    upload.require_idle(known.board, [plan.axis])
    _set_inputs(known.board, options, clock_hz, divider)
    run.command(known.board, "enable", [plan.axis])
    return plan, pixel_hz


def _set_inputs(
    board: Board, options: HomeOptions, clock_hz: Fraction | None, divider: int | None
) -> None:
    """Write the settings that the options of homing ask for, in one request."""
    wanted = settings.of_clock(None, divider)
    if clock_hz:
        wanted["pixel_hz_num"] = clock_hz.numerator
        wanted["pixel_hz_den"] = clock_hz.denominator
    old = settings.read(board)
    if options["inverted"] is not None:  # the emergency stop's bit stays
        wanted["inputs_inverted"] = old["inputs_inverted"] & 4 | INVERTED[options["inverted"]]
    if options["filter_us"] is not None:
        wanted["input_filter_us"] = options["filter_us"]
    if options["home_is_limit"] is not None:  # the other axes' bits stay
        word, axis = old["home_is_limit"], options["axis"]
        wanted["home_is_limit"] = shared_limits(word, axis, options["home_is_limit"])
        if wanted["home_is_limit"]:
            board.require("shared_switch")
    settings.write(board, old, settings.changes(old, wanted))


def _text(unit: int, homed: Homed) -> str:
    """Return what was found, in a sentence."""
    seconds = homed.legs[-1].ended_s - homed.legs[0].began_s
    return (
        f"board {unit} axis {homed.plan.axis}: home found at {homed.edge.position_steps} steps, "
        f"now position 0; stands on {homed.position_steps}, {len(homed.legs)} legs in "
        f"{seconds:.1f} s"
    )
