# SPDX-License-Identifier: MIT
"""Fields that many requests have, each said once."""

from __future__ import annotations

from typing import Any

from pixstep.board import bauds, boards
from pixstep.board import registers as regs
from pixstep.board.port import BAUD, TIMEOUT_S, TIMEOUTS_S
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.operations import machine_defaults as machine
from pixstep.operations.asked import AskedError
from pixstep.operations.kinds import (
    ACCELERATION_FIGURE,
    FILE,
    FOLDER,
    HZ,
    JERK_FIGURE,
    PICTURE,
    SPEED_FIGURE,
    Choice,
    Steps,
    Time,
    Whole,
)
from pixstep.operations.request import flag, option
from pixstep.profiles.origin import MOST_EDGES

DECODE = Choice([SMOOTH, PLAIN])
BOARD = Choice(boards.BOARD_NAMES)
AXIS = Whole(0, 3)
LINE_NUMBER = Whole(1)
EDGES = Whole(1, MOST_EDGES)
SYNC = Choice(list(regs.SYNCS))
GATE_EDGES = Whole(0, boards.MOST_GATE_EDGES)
CLOCK_OUT_HZ = Whole(0, boards.MOST_CLOCK_OUT_HZ)


def decode(about: str = "Kind of the motor.", **more: Any) -> Any:
    """Return the field of how a motor's counts are decoded."""
    return option(DECODE, about, **{"required": True, "machine": machine.decode, **more})


def pixel_hz(about: str = "Pixel frequency: 30, 29.97 or 30000/1001.", **more: Any) -> Any:
    """Return the field of the frequency of pixels."""
    return option(HZ, about, **{"required": True, "machine": machine.pixel_hz, **more})


def clock_hz(
    about: str = "Frequency of the pixel clock's edges: 30, 29.97 or 30000/1001.", **more: Any
) -> Any:
    """Return the field of the frequency of the clock's edges, from which that of pixels follows."""
    default = "that of pixels times the divider"
    return option(HZ, about, **{"machine": machine.clock_hz, "default_text": default, **more})


def hz_of_pixels(about: str = "Frequency of pixels.", **more: Any) -> Any:
    """Return the field of the frequency of pixels beside that of the clock's edges."""
    return option(HZ, about, **{"default_text": "that of the clock by the divider", **more})


def divider(about: str = "Edges of the pixel clock in a pixel.", **more: Any) -> Any:
    """Return the field of how many edges of the clock a pixel has."""
    return option(EDGES, about, **{"shown": "M", "machine": machine.divider, **more})


def backlash(about: str = "Steps of play, or 3um.", **more: Any) -> Any:
    """Return the field of the play that a smooth line takes up, in steps."""
    return option(Steps(0), about, **{"default": 0, "machine": machine.backlash, **more})


def sync(
    about: str = "Lines ignore the pixel clock, begin on an edge of it, or follow it to their end.",
    **more: Any,
) -> Any:
    """Return the field of what lines are to the pixel clock."""
    return option(SYNC, about, **{"default": "start", "machine": machine.sync, **more})


def gate_edges(
    about: str = "The pixel clock is gated: line zero is N edges after a burst's first edge.",
    **more: Any,
) -> Any:
    """Return the field of how far behind a burst's first edge lines begin."""
    given = {"default": 0, "shown": "N", "machine": machine.gate_edges}
    return option(GATE_EDGES, about, **{**given, **more})


def clock_out_hz() -> Any:
    """Return the field of the pixel clock that the board makes itself."""
    return option(
        CLOCK_OUT_HZ, "Let the board make the pixel clock itself, in Hz, on its pin CLOCK_OUT; "
        "0: none.",
        shown="HZ", machine=machine.of_board("clock_out_hz"), default_text="the board's",
    )  # fmt: skip


def timer_of(about: str = "Board whose timer ticks are counted.") -> Any:
    """Return the field of a board that is not simulated, only reckoned with."""
    return option(BOARD, about, default=boards.DEFAULT, machine=machine.of_board("kind"))


def simulated_board() -> Any:
    """Return the field of the board that is simulated, or told of."""
    return option(BOARD, "Kind of the board.", required=True, machine=machine.of_board("kind"))


def image() -> Any:
    """Return the field of another image for a simulated board."""
    return option(FILE, "Another firmware image (ELF) for the board.")


class _BoardBaud(Whole):
    """A rate that a board's setting can hold."""

    def _within(self, value: Any) -> Any:
        if super()._within(value) % 100:
            raise UserError(f"{value}: a multiple of 100 is wanted")
        return value


def board_baud(about: str) -> Any:
    """Return the field of a board's own rate on the bus."""
    return option(_BoardBaud(*bauds.setting_range()), about, default=BAUD)


def refuse_baud(board: str, baud: int) -> None:
    """Raise AskedError for a rate of field `baud` that a board cannot make."""
    if refused := bauds.refusal(board, baud):
        raise AskedError("{baud}: {refused}", refused=refused)


def seed() -> Any:
    """Return the field of what a simulated run's chances come from."""
    return option(Whole(0), "Seed of everything random.", default=1)


def timeout() -> Any:
    """Return the field of how long a board's reply is waited for."""
    return option(
        Time("s", *TIMEOUTS_S), "Time to wait for a reply, s.", shown="TIME",
        variable="PIXSTEP_TIMEOUT", default_text=f"{TIMEOUT_S}",
    )  # fmt: skip


def raw() -> Any:
    """Return the flag of a CSV whose header is not looked at."""
    return flag("Take every row after a CSV header as a value.")


def line_number(about: str = "Line N of a file of many lines.", **more: Any) -> Any:
    """Return the field of which line of a file is meant."""
    return option(LINE_NUMBER, about, "--line", shown="N", **more)


def out(folder: str) -> Any:
    """Return the field of the folder for results; with a machine file it has a name."""
    about = "Folder for the results; replaces only what an earlier run has left there."
    return option(FOLDER, about, required=True, machine=machine.folder(folder))


def plots() -> Any:
    """Return the flag of pictures in the folder for results."""
    return flag("Draw pictures (PNG) into the folder.")


def details() -> Any:
    """Return the flag of a longer page."""
    return flag("Print every interrupt's count, cycles and latest start too.")


def picture(*others: str, what: str = "Draw into a file") -> Any:
    """Return the field of a drawing, of an operation without a folder for results."""
    return option(PICTURE, f"{what}: .png, .svg or .pdf.", "--plot", *others, shown="FILE")


def max_speed(about: str = "Largest speed, steps/px or steps/s.", **more: Any) -> Any:
    """Return the field of the highest speed."""
    return option(SPEED_FIGURE, about, **{"machine": machine.limit("max_speed"), **more})


def max_acceleration(
    about: str = "Largest acceleration, steps/px2 or steps/s2.", **more: Any
) -> Any:
    """Return the field of the highest acceleration."""
    given = {"machine": machine.limit("max_acceleration")}
    return option(ACCELERATION_FIGURE, about, **{**given, **more})


def max_jerk(
    about: str = "Largest change of the acceleration, steps/px3 or steps/s3.", **more: Any
) -> Any:
    """Return the field of the highest jerk."""
    return option(JERK_FIGURE, about, **{"machine": machine.limit("max_jerk"), **more})


def start_stop(about: str, **more: Any) -> Any:
    """Return the field of the speed up to which a plain line needs no ramp."""
    return option(SPEED_FIGURE, about, **{"machine": machine.limit("start_stop"), **more})
