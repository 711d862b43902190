# SPDX-License-Identifier: MIT
"""`pixstep board measure-play`: the play of an axis, by its home switch from both sides."""

from fractions import Fraction
from typing import Unpack

import click

from pixstep import progress
from pixstep.board.errors import BoardError
from pixstep.board.port import Port
from pixstep.cli import machinedefaults
from pixstep.cli.board.group import one_board, port_options, stopping, unit_option
from pixstep.cli.board.home import prepare
from pixstep.cli.clockoptions import board_clock_options
from pixstep.cli.command import command
from pixstep.cli.homeoptions import HomeOptions, home_options
from pixstep.cli.options import json_option, show_json
from pixstep.cli.quantities import StepsType
from pixstep.errors import UserError
from pixstep.lines.units import SPEED, parse
from pixstep.moves import encoders, playmeasure
from pixstep.moves.homing import HomingError
from pixstep.moves.playmeasure import MeasuredPlay


@command("measure-play")
@home_options
@port_options
@unit_option
@board_clock_options
@click.option("--repeat", type=click.IntRange(1, 100), default=5, show_default=True,
              help="Slow approaches from either side.")  # fmt: skip
@click.option("--hysteresis", type=StepsType(0),
              help="Of the switch: by how much it opens below where it closes, as its data sheet "
              "says. Without it the play found has it within.")  # fmt: skip
@click.option("--encoder", metavar="COMMAND",
              help="Prints the load's position in steps, asked at rest: play and hysteresis are "
              "told apart.")  # fmt: skip
@click.option("--save", is_flag=True, help="Write the play into the machine file.")
@json_option
@click.pass_context
def measure_play_command(
    ctx: click.Context,
    port: Port,
    unit: int,
    pixel_hz: Fraction | None,
    divider: int | None,
    repeat: int,
    hysteresis: int | None,
    encoder: str | None,
    save: bool,
    as_json: bool,
    **options: Unpack[HomeOptions],
) -> None:
    """Measure the play of an axis by its home switch.

    By a CSV or CSB profile, with the options of `pixstep board home`; nothing is zeroed. The slow
    approaches are at 1 step/px unless --slow says more: a step must take longer than the switch's
    contact needs to follow.
    """
    motor = machinedefaults.motor_in_force(ctx) if save else None
    if save and motor is None:
        raise UserError("--save: no machine file: --machine FILE and --motor NAME say which motor")
    if encoder is not None and hysteresis is not None:
        raise UserError("--encoder finds the hysteresis itself: leave --hysteresis out")
    read = encoders.of_command(encoder) if encoder is not None else None
    if options["slow"] is None:
        options["slow"] = parse("2" if options["decode"] == "smooth" else "1", SPEED)
    with one_board(port, unit) as (found, known):
        ready = prepare(known, options, pixel_hz, divider)
        try:
            with progress.shown("measuring") as show, stopping([ready.lines]):
                measured = playmeasure.measure(
                    known.board, ready.plan, ready.pixel_hz, found.world,
                    repeat=repeat, hysteresis=hysteresis, encoder=read, progress=show,
                )  # fmt: skip
        except HomingError as error:
            raise BoardError(f"board {unit}: {error}") from None
    if motor:
        from pixstep.machine import writing

        writing.set_backlash(*motor, measured.play)
    if as_json:
        saved = str(motor[0]) if motor else None
        show_json({"unit": unit, "saved": saved} | measured.as_json())
    else:
        click.echo(_text(unit, measured))
        if motor:
            click.echo(f"{motor[0]}: motors.{motor[1]}.backlash = {measured.play} steps")


def _text(unit: int, found: MeasuredPlay) -> str:
    """Return what was found, in a sentence."""
    if found.by_encoder:
        known = f"by the encoder, the switch's hysteresis {found.hysteresis:g} steps"
    elif found.hysteresis is None:
        known = "the switch's hysteresis within (--hysteresis takes it off)"
    else:
        known = f"hysteresis of {found.hysteresis:g} steps taken off"
    return (
        f"board {unit} axis {found.axis}: play {found.play} steps, {known}; "
        f"{len(found.approaches)} approaches from either side, {found.spread:g} steps apart"
    )
