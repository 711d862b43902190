# SPDX-License-Identifier: MIT
"""The few pieces of arithmetic that the record does its own way."""

import math
from typing import Final

LOWEST_LONG: Final = -(2**31)
HIGHEST_LONG: Final = 2**31 - 1
_BEYOND: Final = 2.0**62


def nearest(number: float) -> int:
    """Return the nearest whole number, halves away from zero."""
    bounded = min(max(number, -_BEYOND), _BEYOND)
    return math.floor(bounded + 0.5) if bounded > 0 else math.ceil(bounded - 0.5)


def nearest_long(number: float) -> int:
    """Return the nearest whole number that a field of 32 bits holds."""
    return min(max(nearest(number), LOWEST_LONG), HIGHEST_LONG)


def within(number: float, lowest: float, highest: float) -> float:
    """Return the number, or the end that it is beyond. A highest of 0 means none."""
    if highest != 0 and max(number, lowest) > highest:
        return highest
    return max(number, lowest)


def share(whole: float, parts: float) -> float:
    """Return whole / parts; 0 where there are no parts."""
    return whole / parts if parts else 0.0
