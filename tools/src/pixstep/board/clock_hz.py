# SPDX-License-Identifier: MIT
"""The frequency of a pixel clock by what a board has measured, beside the one that it is set to."""

from fractions import Fraction

from pixstep.board.errors import BoardError

_INTERVAL_TICKS = 256  # unit of register clock_interval and of the faults' arguments
_TIMED_FAULTS = ("pixel_clock_off", "clock_drifted")
CLOCK_FAULTS = (*_TIMED_FAULTS, "pixel_clock_missing", "clock_hold_over")


def set_hz(numerator: int, denominator: int) -> Fraction:
    """Return the frequency that a board is set to; raises BoardError if it is none."""
    if not (numerator and denominator):
        raise BoardError(f"the pixel frequency is set to {numerator}/{denominator} Hz")
    return Fraction(numerator, denominator)


def interval_hz(interval: int, tick_hz: int) -> float | None:
    """Return the frequency of a clock by register clock_interval; None if it is the one set."""
    return tick_hz / (_INTERVAL_TICKS * interval) if interval else None


def fault_hz(name: str, argument: int, tick_hz: int) -> float | None:
    """Return the frequency that the argument of a clock's fault tells, if it does."""
    return interval_hz(argument, tick_hz) if name in _TIMED_FAULTS else None


def beside(measured_hz: float | None, set_hz: float) -> str:
    """Return in words what is measured beside what is set."""
    measured = f"measured {measured_hz:.4g} Hz, " if measured_hz else ""
    return f"{measured}set to {set_hz:.6g} Hz"
