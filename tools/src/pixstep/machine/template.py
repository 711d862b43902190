# SPDX-License-Identifier: MIT
"""The text of a new machine file: it is valid as it is, and says what may be changed."""

import json
import math
import re
from fractions import Fraction

from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.machine import describe, reading
from pixstep.profiles import origin

_HEAD = """\
# A machine: its pixel clock, its boards and its motors, for the commands of pixstep.
# docs/MACHINE.md explains every key. `pixstep machine check` checks this file.
#
# Figures have units: "100.13 Hz", "3 um", "12 mm/s", "200 mm/s2", "4 px", "250 steps",
# "128 steps/px2". A bare number is Hz, steps, steps/px, steps/px2 or pixels.

[clock]
pixel = "{hz} Hz" # of its edges, exact: "30000/1001 Hz" is understood
{divider} # edges of the clock in a pixel, 1 to 1000: gentler accelerations at kilohertz
{sync} # free of the clock, start on an edge of it, or lock to it until the line's end
# gate_edges = 20 # of a clock that rests between lines: from a burst's first edge to line zero

[line]
{motor_key}pixels = 60 # length of a line, both ramps included
# lead_in = 4 # pixels at constant speed before the image

[boards.main]
kind = "{board}"
# port = "/dev/ttyACM0"
# unit = 1 # Modbus address
# baud = 115200
# parity = "E" # E, O or N
"""

_MOTOR = """
[motors.{key}]
axis = {axis}
kind = "{kind}" # smooth: accelerates inside of a pixel; plain: one speed in each pixel
steps_per_unit = "400 steps/mm" # or "2.5 um/step", "12.5 steps/deg"
direction = "+" # "-": the load's positive direction is the motor's negative one
backlash = "0 um" # play between motor and load
# home_is_limit = "plus" # its home switch is the motor's plus limit switch, too
# profiles.line = {profile} # beside this file; for `line make`
# profiles.move = "AccProf-fast-move.csv" # for `move` and `home`: profiles.home

[motors.{key}.limits] # each may be left out
max_speed = "{speed} mm/s"
max_acceleration = "{acceleration} mm/s2"
# max_jerk = "20000 mm/s3"
# start_stop = "4 steps/px" # plain motors turn up to here without a ramp
"""


_SPEED, _ACCELERATION, _STEPS_MM = 30, 500, 400  # mm/s, mm/s2 and steps/mm of a new motor
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def text(
    board: str,
    clock_hz: Fraction,
    motors: dict[str, str],
    divider: int | None = None,
    sync: str | None = None,
) -> str:
    """Return a file for a board with motors, kinds by name, on its axes in a row.

    Without a divider a pixel has as many edges of the clock as the accelerations need; with one
    the accelerations are what its pixels allow. `sync` that is None is there as a comment. Raises
    UserError if the board has fewer axes, and for a clock that it cannot follow.
    """
    if len(motors) > boards.load(board).axes:
        raise UserError(f"{len(motors)} motors: {boards.axes_text(board)}")
    made = _text(board, clock_hz, motors, divider, sync)
    found = reading.parse(made)
    smooth = dict.fromkeys(motors, "smooth")  # `limits` tells the shortest smooth line of any motor
    enough = describe.enough_divider(
        reading.parse(_text(board, clock_hz, smooth, divider, sync)), faults=0
    )
    if divider is None and enough and enough > 1:
        made = _text(board, clock_hz, motors, enough, sync)
        found = reading.parse(made)
    elif divider is not None:
        hz = clock_hz / divider
        least = Fraction(describe.LEAST["smooth"], _STEPS_MM)
        speed = max(_SPEED, _two_digits_up(least * hz))
        acceleration = max(_ACCELERATION, _two_digits_up(least * hz**2))
        made = _text(board, clock_hz, motors, divider, sync, speed, acceleration)
        found = reading.parse(made)
    wrong = next(describe.warnings(found), None)
    if wrong:
        raise UserError(wrong + (f": --divider {enough} would do" if enough else ""))
    return made


def _two_digits_up(value: Fraction) -> int:
    """Return a figure rounded up to two digits."""
    unit = int("1".ljust(len(str(math.ceil(value))) - 1, "0"))
    return math.ceil(value / unit) * unit


def _text(
    board: str,
    clock_hz: Fraction,
    motors: dict[str, str],
    divider: int | None,
    sync: str | None,
    speed: int = _SPEED,
    acceleration: int = _ACCELERATION,
) -> str:
    first = next(iter(motors))
    key = f"motor = {_quoted(first)} # the motor that lines are for, if no --motor is given\n"
    hz = f"{clock_hz.numerator}/{clock_hz.denominator}".removesuffix("/1")
    head = _HEAD.format(
        hz=hz,
        board=board,
        motor_key=key,
        divider=f"divider = {divider}" if divider else "# divider = 4",
        sync=f'sync = "{sync}"' if sync else '# sync = "lock"',
    )
    pixel_hz = clock_hz / (divider or 1)
    return head + "".join(
        _MOTOR.format(
            name=name,
            key=name if _BARE.fullmatch(name) else _quoted(name),
            axis=axis,
            kind=kind,
            profile=_quoted(_profile(name, pixel_hz)),
            speed=speed,
            acceleration=acceleration,
        )
        for axis, (name, kind) in enumerate(motors.items())
    )


def _quoted(name: str) -> str:
    """Return a printable text as TOML has it."""
    return json.dumps(name, ensure_ascii=False)


def _profile(name: str, pixel_hz: Fraction) -> str:
    """Return the name by which `profile make` writes a motor's profile."""
    try:
        return origin.conventional_name(name, pixel_hz, "1")
    except UserError:  # a name that no file can have
        return "profile.PRN"
