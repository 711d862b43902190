# SPDX-License-Identifier: MIT
"""The text of a new machine file: it is valid as it is, and says what may be changed."""

from fractions import Fraction

from pixstep.board import boards
from pixstep.errors import UserError

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
[motors.{name}]
axis = {axis}
kind = "{kind}" # smooth: accelerates inside of a pixel; plain: one speed in each pixel
steps_per_unit = "400 steps/mm" # or "2.5 um/step", "12.5 steps/deg"
direction = "+" # "-": the load's positive direction is the motor's negative one
backlash = "0 um" # play between motor and load
# home_is_limit = "plus" # its home switch is the motor's plus limit switch, too
# profiles.line = "AccProf{name}-{hz}Hz-1.PRN" # beside this file; for `line make`
# profiles.move = "AccProf-fast-move.csv" # for `move` and `home`: profiles.home

[motors.{name}.limits] # each may be left out
max_speed = "30 mm/s"
max_acceleration = "500 mm/s2"
# max_jerk = "20000 mm/s3"
# start_stop = "4 steps/px" # plain motors turn up to here without a ramp
"""


def text(
    board: str,
    clock_hz: Fraction,
    motors: dict[str, str],
    divider: int | None = None,
    sync: str | None = None,
) -> str:
    """Return a file for a board with motors, kinds by name, on its axes in a row.

    What is None of the clock is there as a comment. Raises UserError if the board has fewer axes.
    """
    if len(motors) > boards.load(board).axes:
        raise UserError(f"{len(motors)} motors: {boards.axes_text(board)}")
    first = next(iter(motors))
    key = f'motor = "{first}" # the motor that lines are for, if no --motor is given\n'
    hz = f"{clock_hz.numerator}/{clock_hz.denominator}".removesuffix("/1")
    head = _HEAD.format(
        hz=hz,
        board=board,
        motor_key=key,
        divider=f"divider = {divider}" if divider else "# divider = 4",
        sync=f'sync = "{sync}"' if sync else '# sync = "lock"',
    )
    pixel_hz = f"{float(clock_hz / (divider or 1)):.10g}"
    return head + "".join(
        _MOTOR.format(name=name, axis=axis, kind=kind, hz=pixel_hz)
        for axis, (name, kind) in enumerate(motors.items())
    )
