# SPDX-License-Identifier: MIT
"""What `move make|show|sim` and `board move` share: how a move is asked for."""

from collections.abc import Callable
from fractions import Fraction

import click

from pixstep.cli.command import FILE
from pixstep.cli.options import line_option, raw_option, say
from pixstep.moves import accel, fast
from pixstep.moves.fast import FastMove

STEPS = click.IntRange(-fast.MAX_STEPS, fast.MAX_STEPS)
_OPTIONS = (
    click.argument("profile", type=FILE),
    click.option("--steps", type=STEPS, required=True, help="Steps to move, signed, not 0."),
    click.option("--max-speed", type=click.IntRange(1), help="Never faster, steps/pixel."),
    raw_option,
    line_option,
)


def plan_options(command: Callable) -> Callable:
    """Give a command the argument and the options that plan a move."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_plan(options: dict, pixel_hz: Fraction) -> tuple[accel.Acceleration, FastMove]:
    """Read the profile and plan the move; notes go to the error stream."""
    profile = accel.read(
        options["profile"],
        raw=options["raw"],
        number=options["line_number"],
        max_speed=options["max_speed"],
    )
    say(profile.notes_at(pixel_hz))
    return profile, fast.plan(profile, options["steps"])


def headline(move: FastMove, pixel_hz: Fraction) -> str:
    """Return a move in one line."""
    return (
        f"{move.steps} steps in {move.pixels} pixels, {move.seconds(pixel_hz):.3f} s at "
        f"{float(pixel_hz):g} Hz, top {move.top} steps/pixel = "
        f"{float(move.top * pixel_hz):g} steps/s"
    )
