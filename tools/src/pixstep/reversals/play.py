# SPDX-License-Identifier: MIT
"""The play model: a motor moves a load that lags behind by up to the play at every reversal."""

from collections.abc import Iterable


def load_positions(motor: Iterable[int], play: int, taken_up: int) -> list[int]:
    """Return the load's position at each of the motor's, both in steps from 0 at the start.

    `taken_up` is the direction (+1 or -1) in which the play is taken up at the start. The motor
    must not turn back between two of its positions (a plain pixel has one direction), so that
    looking at the pixel edges alone loses nothing.
    """
    low = 0 if taken_up > 0 else -play  # of load - motor; the play is above it
    load = 0
    positions = []
    for position in motor:
        load = min(max(load, position + low), position + low + play)
        positions.append(load)
    return positions
