# SPDX-License-Identifier: MIT
"""What callers of the interface say of lines and boards, read and refused in one way."""

import contextlib
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeVar, cast

from pixstep import arguments
from pixstep.api.machines import Motor
from pixstep.api.words import BoardKind, Decode, Sync
from pixstep.arguments import FAR
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.errors import UserError, told
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import Quantity, Scale, legal_hz, parse_hz
from pixstep.profiles.origin import MOST_EDGES

Hz = Fraction | Decimal | float | str
"""A pixel frequency: `30`, `29.97`, `"30000/1001"`, `Fraction(30)`, a number of numpy."""

_Value = TypeVar("_Value")


MOST_SEED = 0xFFFFFFFF


def maybe(read: Callable[..., _Value], name: str, given: object, *within: Any) -> _Value | None:
    """Return what is read of a value within some bounds, None if none is given."""
    return None if given is None else read(name, given, *within)


@contextlib.contextmanager
def number_for_line() -> Iterator[None]:
    """Let errors call the number of a line as this interface does: `number`."""
    try:
        yield
    except UserError as error:
        error.args = (told(error, {"line": "number"}), *error.args[1:])
        raise


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


def time(name: str, given: float | str) -> float:
    """Return a time in seconds: a number, or written as `"20 ms"`."""
    value = units.parse_seconds(given) if isinstance(given, str) else given
    return arguments.finite(name, value, 0)


def scale(given: str | Scale | None, motor: Motor | None) -> Scale | None:
    """Return the steps for a millimetre or a degree that are given, else the motor's."""
    if given is None:
        return motor.steps_per_unit if motor else None
    if isinstance(given, Scale):
        return given
    return units.parse_scale(arguments.text("steps_per_unit", given))


def steps(name: str, given: int | str, scale: Scale | None, low: int = 0, high: int = FAR) -> int:
    """Return a distance in whole steps: a number, or written as `"3mm"`, `"250 steps"`."""
    if not isinstance(given, str):
        return arguments.whole(name, given, low, high)
    found = units.parse(given, units.DISTANCE, signed=low < 0).in_steps(scale)
    return arguments.whole(name, found.whole_steps(), low, high)


def pixels(name: str, given: int | str, low: int = 0) -> int:
    """Return a number of pixels: a number, or written as `"60 px"`."""
    value = units.parse_pixels(given) if isinstance(given, str) else given
    return arguments.whole(name, value, low)


def quantity(name: str, given: float | str, order: int, scale: Scale | None) -> Quantity:
    """Return a speed, acceleration or jerk: a number per pixel, or written as `"12mm/s"`."""
    if isinstance(given, str):
        return units.parse(given, order).in_steps(scale)
    value = arguments.exact(name, given, 0)
    return Quantity(value, order, False, arguments.shown(given))


def needs_hz(name: str, found: Quantity, hz: Fraction | None) -> Quantity:
    """Return a quantity. Raises UserError for one per second without a pixel frequency."""
    if found.per_second and hz is None:
        raise UserError(
            f"{name} {found.text}: per second needs a pixel frequency: pixel_hz or motor"
        )
    return found


def limit(
    name: str, given: float | str | None, order: int, hz: Fraction | None, scale: Scale | None
) -> int | None:
    """Return a limit in whole steps and pixels, rounded down, if it is given."""
    if given is None:
        return None
    found = needs_hz(name, quantity(name, given, order, scale), hz)
    return units.whole_limit(found, hz)


def motor(given: Motor | None) -> Motor | None:
    """Return a motor of a machine file, if there is one."""
    return maybe(arguments.instance, "motor", given, Motor, "a motor of a Machine")


def decode(given: str | None, motor: Motor | None) -> Decode:
    """Return the decode rule that is given, else the motor's, else smooth."""
    if given is None:
        return motor.decode if motor else "smooth"
    return cast(Decode, arguments.one_of("decode", given, (SMOOTH, PLAIN)))


def backlash(given: int | str | None, rule: str, motor: Motor | None) -> int:
    """Return the backlash that is given, else the motor's: only smooth lines take it up."""
    if given is not None:
        return steps("backlash", given, scale(None, motor))
    return motor.backlash_steps if motor and rule == SMOOTH else 0


def refuse_empty(line: Line) -> None:
    """Raise UserError for a line without pixels, which can be neither run nor drawn."""
    if not line.pixels:
        raise UserError(f"{line.name}: has no pixels")


def sync(given: str | None) -> Sync | None:
    """Return what lines are to the pixel clock, if it is given."""
    return cast("Sync | None", maybe(arguments.one_of, "sync", given, tuple(regs.SYNCS)))


def divider(given: int | None) -> int | None:
    """Return how many clock edges a pixel has, if it is given."""
    return maybe(arguments.whole, "divider", given, 1, MOST_EDGES)


def gate_edges(given: int | None) -> int | None:
    """Return how many edges behind a burst's first one lines begin, if it is given."""
    return maybe(arguments.whole, "gate_edges", given, 0, boards.MOST_GATE_EDGES)


def board(given: str | None) -> BoardKind | None:
    """Return the name of a kind of board, if it is given."""
    if given is None:
        return None
    return cast(BoardKind, boards.load(arguments.text("board", given)).name)


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
