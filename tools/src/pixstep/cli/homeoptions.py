# SPDX-License-Identifier: MIT
"""What `home sim` and `board home` share: how homing is asked for."""

from fractions import Fraction
from pathlib import Path
from typing import TypedDict

import click

from pixstep.cli import directions, meantfor
from pixstep.cli.command import FILE
from pixstep.cli.options import DECODE, line_option, raw_option, say
from pixstep.cli.quantities import SPEED_TYPE, Decorated, StepsType, TimeType
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import Quantity
from pixstep.moves import accel, homesim, legs
from pixstep.profiles import names

DIRECTIONS = {"plus": 1, "minus": -1}
AXIS = click.IntRange(0, 3)
_OPTIONS = (
    click.argument("profile", type=FILE),
    click.option("--axis", type=AXIS, default=0, show_default=True),
    click.option(
        "--direction",
        type=click.Choice(list(DIRECTIONS)),
        default="plus",
        show_default=True,
        help="Where the switch is sought: closed from its place on, in this direction.",
    ),
    click.option(
        "--decode",
        type=DECODE,
        help="How the motor takes the profile where it seeks the switch; moves in between are "
        "plain.  [default: by the motor in the file's name, smooth for M39, else plain]",
    ),
    click.option(
        "--haps", type=int, help="Entries of the profile to use.  [default: its header's]"
    ),
    click.option(
        "--slow",
        type=SPEED_TYPE,
        help="Second approach, steps/px or steps/s, even if smooth.  [default: first entry, or the "
        "even number below]",
    ),
    click.option(
        "--search",
        type=StepsType(),
        default=20_000,
        show_default=True,
        help="Give a leg up after so many steps.",
    ),
    click.option(
        "--clear", type=StepsType(), help="Second approach from at least so many steps away."
    ),
    click.option(
        "--filter-us", type=TimeType("us", 100, 20_000, int), help="Filter of the switches."
    ),
    click.option(
        "--inverted",
        type=click.Choice(list(homesim.INVERTED)),
        default=None,
        help="Switches that are tripped when their pin is high.  [default: none; on a board "
        "as it is set]",
    ),
    click.option(
        "--home-is-limit",
        type=click.Choice(list(homesim.SHARED)),
        default=None,
        help="The motor's limit switch that the home switch is, too.  [default: none; on a board "
        "as it is set]",
    ),
    raw_option,
    line_option,
)


class HomeOptions(TypedDict):
    """What the profile and the options of homing give."""

    profile: Path
    axis: int
    direction: str
    decode: str | None
    haps: int | None
    slow: Quantity | None
    search: int
    clear: int | None
    filter_us: int | None
    inverted: str | None
    home_is_limit: str | None
    raw: bool
    line_number: int | None


def home_options(command: Decorated) -> Decorated:
    """Give a command the profile and the options of homing."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_profile(
    options: HomeOptions, pixel_hz: Fraction, *, refuse: bool = False
) -> accel.Acceleration:
    """Read the profile; notes go to the error stream. `refuse` one for a lower frequency."""
    read = accel.read(options["profile"], raw=options["raw"], number=options["line_number"])
    say(meantfor.motor_notes(options["profile"], read.header))
    say(read.notes_at(pixel_hz, refuse=refuse))
    return read


def make_plan(options: HomeOptions, pixel_hz: Fraction, *, refuse: bool = False) -> legs.HomingPlan:
    """Read the profile and plan the homing that the options ask for."""
    decode = options["decode"] or _motor_decode(options["profile"])
    way = directions.way(click.get_current_context())
    request = legs.HomingRequest(
        axis=options["axis"],
        direction=way * DIRECTIONS[options["direction"]],
        turned=way < 0,
        haps=options["haps"],
        slow=_slow(options["slow"], pixel_hz, decode),
        search_steps=options["search"],
        clear_steps=options["clear"],
        decode=decode,
    )
    return legs.plan(read_profile(options, pixel_hz, refuse=refuse), request, pixel_hz)


def _slow(speed: Quantity | None, hz: Fraction, decode: str) -> int | None:
    """Return the speed of the second approach in steps/pixel."""
    return None if speed is None else units.whole_speed(speed, hz, None, smooth=decode == SMOOTH)


def _motor_decode(profile: Path) -> str:
    """Return how the motor in a conventional file name decodes; plain if the name has none."""
    named = names.parse(profile)
    decode = meantfor.motor_decode(click.get_current_context(), profile)
    if named is None or decode is None:
        return PLAIN
    say((f"{profile}: named for {named.motor}, so homing is {decode} (--decode)",))
    return decode
