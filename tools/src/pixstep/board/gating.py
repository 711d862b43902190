# SPDX-License-Identifier: MIT
"""A gated pixel clock: bursts of edges, one for each line, with rests between them.

Line zero is `gate_edges` (a board's setting) behind a burst's first edge. The board needs some of
them to give a line its place, so that there is a least number for each frequency.
"""

from fractions import Fraction

from pixstep.errors import UserError

SETTING = "gate_edges"
FEATURE = "gate"
MOST_EDGES = 1000
# What the firmware has: PLACE_TICKS of app/reference.c, CLOCK_FILTER_FRESH_EDGES of
# motion/clock_filter.h.
_PLACE_TICKS = 0x14000
_FRESH_EDGES = 3


def least_edges(clock_hz: Fraction, tick_hz: int, *, locked: bool) -> int:
    """Return the least `gate_edges` with which lines can be armed."""
    return _PLACE_TICKS // int(tick_hz / clock_hz) + 1 + (_FRESH_EDGES if locked else 0)


def refuse(gate_edges: int, clock_hz: Fraction, tick_hz: int, *, locked: bool) -> None:
    """Raise UserError for a number of edges with which a board arms no line; 0 is no gate."""
    least = least_edges(clock_hz, tick_hz, locked=locked)
    if 0 < gate_edges < least:
        raise UserError(text(gate_edges, clock_hz, least, locked=locked))


def text(gate_edges: int, clock_hz: Fraction, least: int, *, locked: bool) -> str:
    """Return what is wrong with too few edges."""
    return (
        f"gate_edges {gate_edges}: at {float(clock_hz):.10g} Hz a line{' that is locked' * locked} "
        f"can begin {least} edges behind the first one of a burst at the earliest"
    )
