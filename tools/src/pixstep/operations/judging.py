# SPDX-License-Identifier: MIT
"""What the limits of a motor and of a board say of the lines of an operation that runs them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from pixstep.board import capability, guarantee
from pixstep.board.capability import BoardCapability
from pixstep.board.guarantee import LineConditions
from pixstep.errors import AskedText
from pixstep.lines.line import Line
from pixstep.lines.line_check import Limits
from pixstep.operations.asked import AskedRefusedError
from pixstep.operations.request import flag, unless

if TYPE_CHECKING:
    from pixstep.operations.desk import Desk
    from pixstep.operations.facts import Facts

NOT_JUDGED = "whether the board has the time is judged for a clock without a gate"
ADVICE = AskedText("`pixstep line check` shows all; {no_check} lets the board judge it")


def no_check() -> Any:
    """Return the field `check`: yes unless the host's check is to be left out."""
    return unless("Leave out the host's check of the line; the board judges it.", "--no-check")


def beyond() -> Any:
    """Return the field `beyond`: go past what a board is guaranteed to follow."""
    return flag(
        "Also run lines together that the board may not have the time for; what is not guaranteed "
        "may end in a named fault."
    )


def together(
    desk: Desk, lines: Sequence[Line], world: LineConditions, *, beyond: bool, gated: bool = False
) -> bool:
    """Ask whether the board is guaranteed to follow these lines together; True if it is.

    Raises RefusedError if it is not, and says so instead with `beyond`. A gate is not judged.
    """
    if gated:
        desk.say([NOT_JUDGED])
    text = guarantee.refusal(lines, world)
    if text and not beyond:
        raise AskedRefusedError("{text} ({beyond} tries it)", text=text)
    if text:
        desk.say([f"beyond what is guaranteed: {text}"])
    return not text


def motor_limits(facts: Facts, lines: list[Line], hz: Fraction) -> list[Limits]:
    """Return the limits of each line's motor; none of them without a machine file.

    `hz` is the frequency of pixels. Raises UserError for one that its pixels are too short for.
    """
    _ = facts.found  # a machine counts here also if no field has a value of it
    motors = facts.motors_in_force
    if len(motors) != len(lines) or not motors:
        return [Limits()] * len(lines)
    from pixstep.machine import line_limits  # pydantic takes a while to load

    return [
        line_limits.of_motor(motor, line, hz) for line, motor in zip(lines, motors, strict=True)
    ]


def check(
    desk: Desk, line: Line, board: BoardCapability, motor: Limits, advice: str = ADVICE
) -> None:
    """Check a line by the limits of its board and its motor; warnings are said.

    Raises RefusedError with `advice` for the first error.
    """
    desk.say(
        f"{line.name}: {one.name} at pixel {one.pixel}: {one.message}"
        for one in capability.check_line(line, board, motor, advice)
    )
