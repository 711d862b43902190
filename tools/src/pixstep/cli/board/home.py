# SPDX-License-Identifier: MIT
"""`pixstep board home`: find the home switch of a real axis and stand on its edge."""

from fractions import Fraction
from typing import Unpack

import click

from pixstep import progress
from pixstep.board.errors import BoardError
from pixstep.board.port import Port
from pixstep.cli.board.group import Known, one_board, port_options, stopping, unit_option
from pixstep.cli.clockoptions import board_clock_options
from pixstep.cli.command import command
from pixstep.cli.homeoptions import HomeOptions, home_options, make_plan
from pixstep.cli.options import json_option, show_json
from pixstep.moves import homing
from pixstep.moves.homing import Homed, HomingError
from pixstep.moves.inputs import Inputs
from pixstep.moves.onboard import Clock, HomingOnBoard, prepare_homing


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
        ready = prepare(known, options, pixel_hz, divider)
        try:
            with progress.shown("homing") as show, stopping([ready.lines]):
                homed = ready.make(found.world, show)
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
) -> HomingOnBoard:
    """Check all that can be checked, then set and enable."""
    known.axes((options["axis"],))
    known.board.require("homing")
    clock = Clock(clock_hz, divider)
    plan = make_plan(options, clock.pixel_hz(known.board), refuse=True)
    inputs = Inputs(options["inverted"], options["filter_us"], options["home_is_limit"])
    return prepare_homing(known.board, plan, clock, inputs)


def _text(unit: int, homed: Homed) -> str:
    """Return what was found, in a sentence."""
    seconds = homed.legs[-1].ended_s - homed.legs[0].began_s
    return (
        f"board {unit} axis {homed.plan.axis}: home found at {homed.edge.position_steps} steps, "
        f"now position 0; stands on {homed.position_steps}, {len(homed.legs)} legs in "
        f"{seconds:.1f} s"
    )
