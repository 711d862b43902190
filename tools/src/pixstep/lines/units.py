# SPDX-License-Identifier: MIT
"""Figures with units, carried exactly: 250 steps, 12mm/s, 128 steps/px2, 20us, 100.13Hz, 4px.

A speed of s steps/px is s*f steps/s at the pixel frequency f; an acceleration of a steps/px2 is
a*f^2 steps/s2, a jerk of j steps/px3 is j*f^3 steps/s3. Millimetres and degrees become steps by
the `Scale` of a motor. A frequency of 29.97 is 2997/100, one of 30000/1001 is itself.
"""

import math
import re
from dataclasses import dataclass, replace
from fractions import Fraction

from pixstep.errors import AskedText, UserError

DISTANCE, SPEED, ACCELERATION, JERK = 0, 1, 2, 3
_NAMES = ("distance", "speed", "acceleration", "jerk")  # by their order

STEP, MM, DEGREE = "steps", "mm", "deg"
_PIXEL, _SECOND = "px", "s"
_INCH = Fraction(254, 10)
_LENGTHS = {
    "step": (STEP, Fraction(1)),
    "steps": (STEP, Fraction(1)),
    "nm": (MM, Fraction(1, 1_000_000)),
    "um": (MM, Fraction(1, 1000)),
    "mm": (MM, Fraction(1)),
    "cm": (MM, Fraction(10)),
    "m": (MM, Fraction(1000)),
    "in": (MM, _INCH),
    "arcsec": (DEGREE, Fraction(1, 3600)),
    "arcmin": (DEGREE, Fraction(1, 60)),
    "deg": (DEGREE, Fraction(1)),
    "°": (DEGREE, Fraction(1)),
    "rev": (DEGREE, Fraction(360)),
}
_SECONDS = {
    "us": Fraction(1, 1_000_000),
    "ms": Fraction(1, 1000),
    "s": Fraction(1),
    "min": Fraction(60),
}
_PIXELS = ("px", "pixel", "pixels")
_POWERS = {"": 1, "2": 2, "²": 2, "^2": 2, "3": 3, "³": 3, "^3": 3}
LENGTH_UNITS = tuple(_LENGTHS)
SECOND_UNITS = tuple(_SECONDS)

_NUMBER = re.compile(r"([+-]?[0-9]{1,12}(?:\.[0-9]{1,12})?(?:[eE][+-]?[0-9]{1,2})?) *(.*)")
_RATE = re.compile(r"([^/0-9^²³ ]+)/([a-z]+)([0-9²³^]*)")
_SCALE = re.compile(r"([^/ ]+) */ *([^/ ]+)")


@dataclass(frozen=True)
class Scale:
    """How many steps a motor makes for one millimetre or one degree of its load."""

    steps_per_unit: Fraction
    length: str  # MM or DEGREE

    def __str__(self) -> str:
        return f"{number_text(self.steps_per_unit)} steps/{self.length}"


@dataclass(frozen=True)
class Quantity:
    """A figure as it was given.

    The order is 0 for a distance, 1 a speed, 2 an acceleration, 3 a jerk; `length` is STEP, MM or
    DEGREE.
    """

    value: Fraction
    order: int
    per_second: bool
    text: str
    length: str = STEP

    def in_steps(self, scale: Scale | None) -> "Quantity":
        """Return the same in steps. Raises UserError if that needs a scale which is missing."""
        if self.length == STEP:
            return self
        if scale is None or scale.length != self.length:
            has = f", the motor has {scale}" if scale else ": choose a motor of a machine file"
            raise UserError(
                f"{_NAMES[self.order]} {self.text}: needs a motor's steps per {self.length}{has}"
            )
        return replace(self, value=self.value * scale.steps_per_unit, length=STEP)

    def per_pixel(self, hz: Fraction | None) -> Fraction:
        """Return the value in steps/px^order. Raises UserError if that needs a missing `hz`."""
        steps = self.in_steps(None).value
        if not self.per_second:
            return steps
        if hz is None:
            raise UserError(AskedText(
                "{what} {text}: per second needs {pixel_hz}",
                what=_NAMES[self.order], text=self.text,
            ))  # fmt: skip
        return steps / hz**self.order

    def whole_steps(self) -> int:
        """Return a distance as a whole number of steps; raises UserError with its neighbours."""
        value = self.in_steps(None).value
        if value.denominator != 1:
            below = value.numerator // value.denominator
            raise UserError(
                f"{_NAMES[self.order]} {self.text} is {number_text(value)} steps, not a whole "
                f"number: nearest {below} and {below + 1}"
            )
        return int(value)


def parse(text: str, order: int, *, signed: bool = False) -> Quantity:
    """Return the quantity written as 128, 128steps/px2, 115200 steps/s2, 12mm/s or 3um.

    A bare number is in steps, per pixel. Raises UserError for anything else, another order
    included.
    """
    given = text.strip()
    number, name = _split(given, f"{_NAMES[order]} {text!r}: expected a number of {_wanted(order)}")
    if number < 0 and not signed:
        raise UserError(f"{_NAMES[order]} {text!r}: expected a number of 0 or more")
    if not name:
        return Quantity(number, order, False, given)
    length, factor, second = _unit_of(name, order, text)
    return Quantity(number * factor, order, second, given, length)


def parse_scale(text: str) -> Scale:
    """Return steps per length, written as 400 steps/mm, 12.5 steps/deg or 2.5 um/step."""
    wrong = f"{text!r}: expected steps per length, as 400 steps/mm or 2.5 um/step"
    number, name = _split(text.strip(), wrong)
    found = _SCALE.fullmatch(_plain(name))
    if not found or number <= 0 or not {found[1], found[2]} <= _LENGTHS.keys():
        raise UserError(wrong)
    (upper, many), (lower, one) = _LENGTHS[found[1]], _LENGTHS[found[2]]
    if (upper == STEP) == (lower == STEP):
        raise UserError(wrong)
    ratio = number * many / one
    return Scale(ratio, lower) if upper == STEP else Scale(1 / ratio, upper)


def parse_seconds(text: str, bare: str = "s") -> Fraction:
    """Return a time in seconds, written as 20us, 1.5 s or, in the unit `bare`, as a number."""
    wrong = f"time {text!r}: expected a number of {', '.join(_SECONDS)}"
    number, name = _split(text.strip(), wrong)
    if number < 0 or _plain(name or bare) not in _SECONDS:
        raise UserError(wrong)
    return number * _SECONDS[_plain(name or bare)]


def parse_pixels(text: str) -> int:
    """Return a number of pixels, written as 4, 4px or 4 pixels."""
    wrong = f"{text!r}: expected a whole number of pixels, as 4 or 4px"
    number, name = _split(text.strip(), wrong)
    if number.denominator != 1 or (name and name not in _PIXELS):
        raise UserError(wrong)
    return int(number)


def parse_length_unit(name: str) -> tuple[str, Fraction] | None:
    """Return STEP, MM or DEGREE and how much of it a unit is; None for no unit of length."""
    return _LENGTHS.get(_plain(name.strip()))


def is_unit(name: str) -> bool:
    """True for the unit of a distance or of a speed: mm, mm/min, um/px."""
    order = SPEED if "/" in name else DISTANCE
    try:
        _unit_of(name.strip(), order, name)
    except UserError:
        return False
    return True


class TooLittleError(UserError):
    """A limit that is less than `least` steps/px^order: pixels are too short for it.

    `given` is the limit as it was given. `quantity` is the same if it has a unit of time, so that
    longer pixels hold more.
    """

    def __init__(self, message: str, least: int, quantity: "Quantity | None" = None) -> None:
        super().__init__(message)
        self.least = least
        self.given = quantity
        self.quantity = quantity if quantity and quantity.per_second else None


def enough_edges(quantity: Quantity, clock_hz: Fraction, least: int) -> int | None:
    """Return the fewest clock edges of a pixel in which a limit per second is `least` or more.

    None for a limit that is 0, or per pixel.
    """
    value = quantity.in_steps(None).value
    if value <= 0 or not quantity.per_second:
        return None
    wanted = clock_hz**quantity.order * least / value  # of edges to the power of the order
    edges: int = max(1, math.floor(float(wanted) ** (1 / quantity.order)) - 1)
    while Fraction(edges) ** quantity.order < wanted:
        edges += 1
    return edges


def whole_limit(quantity: Quantity, hz: Fraction | None, *, least: int = 1) -> int:
    """Return a limit as whole steps/px^order, rounded down.

    Raises UserError for a limit below `least`, and for one per second without a frequency.
    """
    value = quantity.per_pixel(hz)
    if value < least:
        kind = unit(quantity.order)
        figure = number_text(value)
        text = f"{quantity.text} is {figure} {kind}: at least {least} {kind}"
        raise TooLittleError(text, least, quantity)
    return int(value)


def whole_speed(
    quantity: Quantity, hz: Fraction | None, scale: Scale | None = None, *, smooth: bool
) -> int:
    """Return a speed in whole steps/px; raises UserError naming the nearest legal ones.

    The caller refuses an odd speed of a smooth line.
    """
    value = quantity.in_steps(scale).per_pixel(hz)
    if value.denominator == 1:
        return int(value)
    step = 2 if smooth else 1
    below = int(value // step) * step
    legal = [speed for speed in (below, below + step) if speed > 0]
    kind = "an even whole number, as a smooth line needs" if smooth else "a whole number"
    raise UserError(
        f"speed {quantity.text} is {number_text(value)} steps/px, not {kind}: nearest legal "
        f"{' and '.join(both_text(speed, SPEED, hz, scale) for speed in legal)}"
    )


def unit(order: int, *, per_second: bool = False, length: str = STEP) -> str:
    """Return the name of a unit: steps, steps/px, steps/s2, mm/s."""
    if order == DISTANCE:
        return length
    return f"{length}/{_SECOND if per_second else _PIXEL}{order if order > 1 else ''}"


def per_second(value: Fraction | int, order: int, hz: Fraction) -> Fraction:
    """Return a value in steps/px^order as steps/s^order."""
    return Fraction(value) * hz**order


def number_text(value: Fraction | float) -> str:
    """Return a figure as people read it: whole where it is, else seven digits."""
    if Fraction(value).denominator == 1:
        return str(int(value))
    return f"{float(value):.7g}"


def both_text(
    value: Fraction | int, order: int, hz: Fraction | None, scale: Scale | None = None
) -> str:
    """Return a figure per pixel and, where frequency and scale are known, in the units of both."""
    text = f"{number_text(value)} {unit(order)}"
    if hz is None:
        return text
    second = per_second(value, order, hz)
    text += f" = {number_text(second)} {unit(order, per_second=True)}"
    if scale is None:
        return text
    load = second / scale.steps_per_unit
    return f"{text} = {number_text(load)} {unit(order, per_second=True, length=scale.length)}"


def _split(text: str, wrong: str) -> tuple[Fraction, str]:
    """Return the number at the beginning of a text, and what is behind it."""
    found = _NUMBER.fullmatch(text)
    if not found:
        raise UserError(wrong)
    return Fraction(found[1]), found[2].strip()


def _plain(name: str) -> str:
    """Return the name of a unit with both kinds of a micro sign as u."""
    return name.replace("\u00b5", "u").replace("\u03bc", "u")


def _wanted(order: int) -> str:
    if order == DISTANCE:
        return "steps, mm or deg"
    return f"{unit(order)} or {unit(order, per_second=True)} (or mm, um, deg for steps)"


def _unit_of(name: str, order: int, text: str) -> tuple[str, Fraction, bool]:
    """Return length, factor and whether it is per second, of a unit of the right order."""
    wrong = f"{_NAMES[order]} {text!r}: expected a number of {_wanted(order)}"
    if order == DISTANCE:
        if _plain(name) not in _LENGTHS:
            raise UserError(wrong)
        return (*_LENGTHS[_plain(name)], False)
    found = _RATE.fullmatch(_plain(name).replace(" ", ""))
    if not found or found[1] not in _LENGTHS or _POWERS.get(found[3]) != order:
        raise UserError(wrong)
    length, factor = _LENGTHS[found[1]]
    if found[2] in _PIXELS:
        return length, factor, False
    if found[2] not in _SECONDS:
        raise UserError(wrong)
    return length, factor / _SECONDS[found[2]] ** order, True


_DECIMAL = re.compile(r"[0-9]{1,10}(\.[0-9]{1,20})?([eE][+-]?[0-9]{1,2})?")
_FRACTION = re.compile(r"[0-9]{1,10}/[0-9]{1,10}")
_UNIT = re.compile(r" *(k|M|m)?Hz$")
_PREFIXES: dict[str | None, Fraction] = {
    None: Fraction(1),
    "m": Fraction(1, 1000),
    "k": Fraction(1000),
    "M": Fraction(1_000_000),
}
_U32_MAX = 0xFFFFFFFF
_NEAR_DENOMINATOR = 10_000  # of the fraction that an error proposes
PERIOD_TICKS = (1024, 0xFFFFFF)  # what the pixel grid of a board can carry


def parse_hz(text: str, what: str = "pixel frequency") -> Fraction:
    """Return the frequency written as a decimal or a fraction, exactly, in Hz: 1e3, 30000/1001Hz.

    Both numerator and denominator of the reduced fraction must fit 32 bits, as the board takes
    them so. Raises UserError naming the text otherwise, or if the frequency is not above zero;
    `what` is the name of the frequency in that message.
    """
    text = text.strip()
    named = _UNIT.search(text)
    number = text[: named.start()] if named else text
    if not (_DECIMAL.fullmatch(number) or _FRACTION.fullmatch(number)):
        raise UserError(f"{what} {text!r}: expected Hz as 30, 29.97 or 30000/1001")
    numerator, _, denominator = number.partition("/")
    if denominator and int(denominator) == 0:
        raise UserError(f"{what} {text!r}: the denominator is zero")
    hz = Fraction(numerator) / Fraction(denominator or 1) * _PREFIXES[named[1] if named else None]
    return legal_hz(hz, text, what)


def legal_hz(hz: Fraction, text: str, what: str = "pixel frequency") -> Fraction:
    """Return a frequency that was written as `text`; `what` names it in a message.

    Raises UserError if it is not above zero or needs more than 32 bits.
    """
    if hz <= 0:
        raise UserError(f"{what} {text!r}: must be above 0 Hz")
    if hz.numerator > _U32_MAX or hz.denominator > _U32_MAX:
        near = hz.limit_denominator(_NEAR_DENOMINATOR)
        hint = f": write {near}?" if 0 < near <= _U32_MAX // _NEAR_DENOMINATOR else ""
        raise UserError(f"{what} {text!r}: needs more than 32 bits{hint}")
    return hz


def hz_words(hz: Fraction) -> str:
    """Return a frequency as it is typed: 1000, 29.97 or 30000/1001."""
    decimal = f"{float(hz):.10g}"
    return decimal if Fraction(decimal) == hz else str(hz)


def hz_text(hz: Fraction) -> str:
    """Return the exact `N/D` text that the native programs read."""
    return f"{hz.numerator}/{hz.denominator}"


def ticks_text(ticks: float) -> str:
    """Return an error in ticks to three places, rounded down: only a real 1 reads as 1.000."""
    return f"{math.floor(ticks * 1000) / 1000:.3f}"


def period_ticks(hz: Fraction, tick_hz: int) -> Fraction:
    """Return the exact pixel period in timer ticks, of which there are `tick_hz` a second."""
    return Fraction(tick_hz) / hz


def edge_tick(pixel: int, period: Fraction, phase: Fraction = Fraction(0)) -> int:
    """Return B_k = floor(k * P), the tick of the end edge of pixel k after line zero.

    A line that follows another one begins a `phase` of a tick late.
    """
    if phase:
        return int((phase + pixel * period) // 1)
    return pixel * period.numerator // period.denominator


def refuse_period(hz: Fraction, tick_hz: int, *, locked: bool = False) -> None:
    """Raise UserError for a frequency whose pixel period a board's grid cannot carry.

    Pixels that are `locked` to the clock need room: each may become longer than nominal.
    """
    low, high = PERIOD_TICKS
    if locked:
        high = high // 16 * 15
    if not low <= period_ticks(hz, tick_hz) <= high:
        raise UserError(
            f"pixel frequency {float(hz):g} Hz: the period must be {low} to {high} ticks"
            f"{', as lines are locked to the clock' if locked else ''}"
        )


def refuse_periods(hz: Fraction, divider: int, tick_hz: int, *, locked: bool) -> None:
    """Do the same for pixels of `divider` clock edges, and for the edges by themselves."""
    refuse_period(hz, tick_hz, locked=locked)
    refuse_period(hz * divider, tick_hz)
