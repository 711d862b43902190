# SPDX-License-Identifier: MIT
"""What boards are guaranteed, for the tables that show it beside the highest clean figures."""

from collections.abc import Mapping
from fractions import Fraction

from pixstep.board import capability, guarantee
from pixstep.board.port import BAUD

_STRIDE_HZ = 50
_MOTIONS = {"ramp and hold": "ramp"}  # of the bench, where `limits` has another name


def rate(board: str, axes: int, motion: str, hz: Fraction) -> int:
    """Return the rate that is guaranteed on each of so many axes, steps/s: that of `limits`."""
    return int(steps(board, axes, _MOTIONS.get(motion, motion), hz) * hz)


def steps(
    board: str,
    axes: int,
    motion: str,
    hz: Fraction,
    clock: Mapping[str, int] | None = None,
    baud: int = BAUD,
) -> int:
    """Return what is guaranteed on each of so many axes, steps a pixel; `clock`: its settings."""
    able = capability.of(board, hz, axes=axes, clock=clock)
    world = guarantee.world(board, hz, clock, baud)
    return guarantee.rate(motion, axes, world, able.top_speed(guarantee.decode_of(motion)))


def clock(board: str, axes: int, motion: str, steps: int, most_hz: int) -> int:
    """Return the highest guaranteed clock up to `most_hz` with so many steps a pixel, Hz."""

    def fits(strides: int) -> bool:
        hz = Fraction(strides * _STRIDE_HZ)
        line = guarantee.line_at(motion, steps, hz)
        return guarantee.follows([line] * axes, guarantee.world(board, hz))

    return guarantee.highest(most_hz // _STRIDE_HZ, fits) * _STRIDE_HZ
