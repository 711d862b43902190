# SPDX-License-Identifier: MIT
"""Pixel frequencies are carried exactly: 29.97 is 2997/100, 30000/1001 is itself."""

import re
from fractions import Fraction

from pixstep.errors import UserError

_DECIMAL = re.compile(r"[0-9]{1,10}(\.[0-9]{1,20})?")
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
    """Return the frequency written as a decimal or a fraction, exactly, in Hz: 29.97, 30000/1001Hz.

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


def hz_text(hz: Fraction) -> str:
    """Return the exact `N/D` text that the native programs read."""
    return f"{hz.numerator}/{hz.denominator}"


def period_ticks(hz: Fraction, tick_hz: int) -> Fraction:
    """Return the exact pixel period in timer ticks, of which there are `tick_hz` a second."""
    return Fraction(tick_hz) / hz


def edge_tick(pixel: int, period: Fraction) -> int:
    """Return B_k = floor(k * P), the tick of the end edge of pixel k after line zero."""
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
