# SPDX-License-Identifier: MIT
"""What callers of the interface say of lines and boards, read and refused in one way."""

from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeVar

from pixstep import arguments
from pixstep.api.machines import Motor
from pixstep.board import boards, gating
from pixstep.board import registers as regs
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.rational import legal_hz, parse_hz
from pixstep.profiles.madefor import MOST_EDGES

Hz = Fraction | Decimal | float | str
"""A pixel frequency: `30`, `29.97`, `"30000/1001"`, `Fraction(30)`, a number of numpy."""

_Value = TypeVar("_Value")


def exact_hz(given: Hz | None) -> Fraction | None:
    """Return a pixel frequency as the board takes it: exact, of a float the digits it shows."""
    if given is None:
        return None
    if isinstance(given, str):
        return parse_hz(given)
    exact, text = arguments.number(given), arguments.shown(given)
    if exact is None:
        raise UserError(f"pixel frequency {text}: expected Hz as 30, 29.97 or '30000/1001'")
    return legal_hz(exact, text)


def motor(given: Motor | None) -> Motor | None:
    """Return a motor of a machine file, if there is one."""
    if given is None:
        return None
    return arguments.instance("motor", given, Motor, "a motor of a Machine")


def decode(given: str | None, motor: Motor | None) -> str:
    """Return the decode rule that is given, else the motor's, else smooth."""
    if given is None:
        return motor.decode if motor else SMOOTH
    return arguments.one_of("decode", given, (SMOOTH, PLAIN))


def backlash(given: int | None, rule: str, motor: Motor | None) -> int:
    """Return the backlash that is given, else the motor's: only smooth lines take it up."""
    if given is not None:
        return arguments.whole("backlash", given)
    return motor.backlash_steps if motor and rule == SMOOTH else 0


def refuse_empty(line: Line) -> None:
    """Raise UserError for a line without pixels, which can be neither run nor drawn."""
    if not line.pixels:
        raise UserError(f"{line.name}: has no pixels")


def sync(given: str | None) -> str | None:
    """Return what lines are to the pixel clock, if it is given."""
    return None if given is None else arguments.one_of("sync", given, tuple(regs.SYNCS))


def divider(given: int | None) -> int | None:
    """Return how many clock edges a pixel has, if it is given."""
    if given is None:
        return None
    return arguments.whole("divider", given, 1, MOST_EDGES)


def gate_edges(given: int | None) -> int | None:
    """Return how many edges behind a burst's first one lines begin, if it is given."""
    if given is None:
        return None
    return arguments.whole("gate_edges", given, 0, gating.MOST_EDGES)


def board(given: str | None) -> str | None:
    """Return the name of a kind of board, if it is given."""
    if given is None:
        return None
    return boards.load(arguments.text("board", given)).name


def axes(given: int, board: str | None) -> int:
    """Return how many axes move together, no more than a board has."""
    most = max(item.axes for item in boards.all_boards())
    count = arguments.whole("axes", given, 1, most)
    if board is not None and count > boards.load(board).axes:
        raise UserError(f"axes {count}: the {boards.axes_text(board)}")
    return count


def axis(given: int) -> int:
    """Return the number of an axis."""
    return arguments.whole("axis", given)


def by_axis(name: str, given: Mapping[int, _Value]) -> dict[int, _Value]:
    """Return what is given by axis, in the order of the axes."""
    found: dict[int, _Value] = {}
    if not isinstance(given, Mapping):
        raise UserError(f"{name} {arguments.shown(given)}: expected one, or several by axis")
    for key, value in given.items():
        if found.setdefault(axis(key), value) is not value:
            raise UserError(f"axis {key}: is given twice")
    return dict(sorted(found.items(), key=_axis_of))


def _axis_of(item: tuple[int, Any]) -> int:
    return item[0]
