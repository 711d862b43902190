# SPDX-License-Identifier: MIT
"""What `move make|show|sim` and `board move` share: how a move is asked for."""

from fractions import Fraction
from pathlib import Path
from typing import TypedDict

import click

from pixstep.cli import directions, meantfor
from pixstep.cli.command import FILE
from pixstep.cli.options import line_option, raw_option, say
from pixstep.cli.quantities import SPEED_TYPE, Decorated, StepsType, whole_limit
from pixstep.lines.units import Quantity
from pixstep.moves import accel, fast
from pixstep.moves.fast import FastMove

STEPS = StepsType(-fast.MAX_STEPS, fast.MAX_STEPS)
_OPTIONS = (
    click.argument("profile", type=FILE),
    click.option(
        "--steps", type=STEPS, required=True, help="Steps to move, signed, not 0; or 3mm."
    ),
    click.option("--max-speed", type=SPEED_TYPE, help="Never faster: steps/px or steps/s."),
    raw_option,
    line_option,
)


class MoveOptions(TypedDict):
    """What the argument and the options that plan a move give."""

    profile: Path
    steps: int
    max_speed: Quantity | None
    raw: bool
    line_number: int | None


def plan_options(command: Decorated) -> Decorated:
    """Give a command the argument and the options that plan a move."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_plan(
    options: MoveOptions, pixel_hz: Fraction, *, refuse: bool = False
) -> tuple[accel.Acceleration, FastMove]:
    """Read the profile and plan the move in the motor's steps; notes go to the error stream.

    `refuse` a profile that was made for a lower pixel frequency.
    """
    profile = accel.read(
        options["profile"],
        raw=options["raw"],
        number=options["line_number"],
        max_speed=whole_limit(options["max_speed"], pixel_hz),
    )
    say(meantfor.motor_notes(options["profile"], profile.header))
    say(profile.notes_at(pixel_hz, refuse=refuse))
    way = directions.way(click.get_current_context())
    return profile, fast.plan(profile, way * options["steps"])


def headline(move: FastMove, pixel_hz: Fraction) -> str:
    """Return a move in one line."""
    return (
        f"{move.steps} steps in {move.pixels} pixels, {move.seconds(pixel_hz):.3f} s at "
        f"{float(pixel_hz):g} Hz, top {move.top} steps/pixel = "
        f"{float(move.top * pixel_hz):g} steps/s"
    )
