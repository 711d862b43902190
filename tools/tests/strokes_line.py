# SPDX-License-Identifier: MIT
"""A plain line with four reversals, its limits and its play, shared by the tests."""

from pixstep.reversals.compensate import MotionLimits

LIMITS = MotionLimits(max_acceleration=10, start_stop=4)
PLAY = 40
_RAMP = [4, 12, 20, 28, 36, 44, 52, 60]
STROKE = [*_RAMP, *[60] * 8, *reversed(_RAMP)]


def four_reversals() -> list[int]:
    """Return five strokes of 24 pixels, forth and back, turning directly between two pixels."""
    return [way * count for way in (1, -1, 1, -1, 1) for count in STROKE]
